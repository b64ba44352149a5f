// SPDX-License-Identifier: MIT
// Formats of numbers and names.

export const MISSING = "\u2013";

const missing = (value) => value === null || value === undefined || !Number.isFinite(value);

/** The minus sign of the page and of the charts' axes; files and code have the ASCII hyphen. */
const MINUS = "\u2212";

/** Sentences of the program with the page's minus sign: "-0.5" and "6e-07", but not "--seed" or "10-20". */
export const withMinusSigns = (text) => text.replace(/(^|[\s(\[=,;])-(?=[\d.])/g, `$1${MINUS}`).replace(/(\de)-(?=\d)/g, `$1${MINUS}`);

/** A fixed number of decimals; zero has no sign. */
export function decimals(value, digits) {
  if (missing(value)) return MISSING;
  const text = value.toFixed(digits);
  return text.replace("-", Number(text) === 0 ? "" : MINUS);
}

/** A number of significant digits, with an exponent only for the very small and very large. */
export function significant(value, digits = 5) {
  if (missing(value)) return MISSING;
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e7) return value.toExponential(digits - 1).replace("e+", "e").replaceAll("-", MINUS);
  return value.toFixed(Math.max(0, digits - 1 - Math.floor(Math.log10(size)))).replace("-", MINUS);
}

/** Steps of scales: 1, 2 or 5 times a power of ten. */
const STEPS = [1, 2, 5, 10];
const powerBelow = (value) => 10 ** Math.floor(Math.log10(value));

/** The smallest step that is not below a value. */
export const roundUp = (value) => STEPS.map((step) => step * powerBelow(value)).find((step) => step >= value * (1 - 1e-9));

/** The largest step that is not above a value. */
export const roundDown = (value) => STEPS.map((step) => step * powerBelow(value)).findLast((step) => step <= value * (1 + 1e-9));

/** A p-value; below 0.001 as "< 0.001". */
export function probability(value) {
  if (missing(value)) return MISSING;
  return value < 0.001 ? "< 0.001" : value.toFixed(3);
}

export const count = (value) => (missing(value) ? MISSING : value.toLocaleString("en-US").replaceAll(",", "\u202f").replace("-", MINUS));
export const r2 = (value) => decimals(value, 4);
export const criterion = (value) => decimals(value, 2);
export const points = (value) => (missing(value) ? MISSING : (value > 0 ? "+" : "") + decimals(value, 2));

const RESPONSES = { h: "Height", hcb: "Height to crown base", cw: "Crown width" };
export const responseName = (column) => RESPONSES[column] ?? column;

/** Within a sentence; a column of the file keeps its capitals. */
export const responseInText = (column) => RESPONSES[column]?.toLowerCase() ?? column;

const COLUMNS = { W: "uniform angle index", M: "mingling", U: "dominance", C: "crowding", h: "height", dbh: "DBH" };
export const columnName = (column) => COLUMNS[column] ?? column;

/** "RMSE, m"; without a unit the name alone. */
export const inUnit = (name, unit) => (unit === "" ? name : `${name}, ${unit}`);

export const plural = (number, one, many = `${one}s`) => `${count(number)} ${number === 1 ? one : many}`;

/** "4 apples and 2 pears"; "a, b and c". */
export function listing(items) {
  return items.length < 2 ? items.join("") : `${items.slice(0, -1).join(", ")} and ${items.at(-1)}`;
}

/** Coefficients with a sign between them; the texts of two groupings, "a | plot", are separate. */
export const joinedEffects = (effects, sign) => effects.join(effects.some((effect) => effect.includes(" | ")) ? "; " : sign);

export const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);
