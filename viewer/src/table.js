// SPDX-License-Identifier: MIT
// Tables from a description of their columns.
import { element } from "./dom.js";

/**
 * @template Row
 * @typedef {{title: string | Node, value: (row: Row) => string | Node, text?: boolean}} Column
 *   `text` columns are set left, numbers right; the first column is the row's header.
 */

function cell(column, row, isFirst) {
  const attributes = { class: column.text ? "text" : "number", scope: isFirst ? "row" : null };
  return element(isFirst ? "th" : "td", attributes, column.value(row));
}

/**
 * A table in a frame that scrolls sideways where the screen is narrow, reachable by keyboard.
 * @template Row
 * @param {string} caption
 * @param {Column<Row>[]} columns
 * @param {Row[]} rows
 * @param {(row: Row) => string | null} rowClass
 */
export function table(caption, columns, rows, rowClass = () => null) {
  const title = (column) => element("th", { scope: "col", class: column.text ? "text" : "number" }, column.title);
  const body = rows.map((row) =>
    element("tr", { class: rowClass(row) }, ...columns.map((column, index) => cell(column, row, index === 0))),
  );
  return element(
    "div",
    { class: "scroll", tabindex: "0", role: "region", "aria-label": caption },
    element(
      "table",
      {},
      element("caption", {}, caption),
      element("thead", {}, element("tr", {}, ...columns.map(title))),
      element("tbody", {}, ...body),
    ),
  );
}

/** Rows that can be used first, best first; the others keep their order. */
export const byRank = (rows) => [...rows].sort((a, b) => (a.rank ?? Infinity) - (b.rank ?? Infinity));
