// SPDX-License-Identifier: MIT
// Reading CSV (RFC 4180) to compare two tables.

/** @returns {string[][]} */
export function readCsv(text) {
  const rows = [];
  let row = [];
  for (const [, quoted, plain, end] of text.matchAll(/(?:"((?:[^"]|"")*)"|([^,\r\n]*))(,|\r?\n|$)/g)) {
    row.push(quoted === undefined ? plain : quoted.replaceAll('""', '"'));
    if (end === ",") continue;
    if (row.length > 1 || row[0] !== "") rows.push(row);
    row = [];
  }
  return rows;
}

const isSame = (a, b) => a === b || (a !== "" && b !== "" && Number(a) === Number(b));

/** Where two tables differ in rows, or in the columns that both have; numbers are compared as such. */
export function differences(first, second) {
  const [[header, ...rows], [otherHeader, ...others]] = [readCsv(first), readCsv(second)];
  const common = header.filter((name) => otherHeader.includes(name));
  if (common.length < 3) return [`few columns in common: ${header} / ${otherHeader}`];
  if (rows.length !== others.length) return [`${rows.length} rows against ${others.length}`];
  return rows.flatMap((row, index) =>
    common
      .map((name) => ({ name, ours: row[header.indexOf(name)], theirs: others[index][otherHeader.indexOf(name)] }))
      .filter(({ ours, theirs }) => !isSame(ours, theirs))
      .map(({ name, ours, theirs }) => `row ${index + 1}, ${name}: ${ours} / ${theirs}`),
  );
}
