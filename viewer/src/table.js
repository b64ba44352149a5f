// SPDX-License-Identifier: MIT
// Tables from a description of their columns.
import { csvText, downloadButton } from "./csv.js";
import { element } from "./dom.js";

/**
 * @template Row
 * @typedef {{title: string | Node, value: (row: Row) => string | Node, raw?: (row: Row) => number | null, text?: boolean}} Column
 *   `text` columns are set left, numbers right; the first column is the row's header. `raw` is what a file gets where the page rounds.
 */

/** A column of numbers, rounded on the page. */
export const numeric = (title, raw, format) => ({ title, raw, value: (row) => format(raw(row)) });

function cell(column, row, isFirst) {
  const attributes = { class: column.text ? "text" : "number", scope: isFirst ? "row" : null };
  return element(isFirst ? "th" : "td", attributes, column.value(row));
}

const textOf = (part) => (typeof part === "string" ? part : part.textContent);

function content(columns, rows) {
  const value = (column, row) => (column.raw ? column.raw(row) : textOf(column.value(row)));
  return csvText(columns.map(({ title }) => textOf(title)), rows.map((row) => columns.map((column) => value(column, row))));
}

const fileName = (caption) => `${caption.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "").slice(0, 60)}.csv`;

/**
 * A table in a frame that scrolls sideways where the screen is narrow, reachable by keyboard, with a button that saves it.
 * @template Row
 * @param {string} caption
 * @param {Column<Row>[]} columns
 * @param {Row[]} rows
 * @param {(row: Row) => string | null} rowClass
 */
export function table(caption, columns, rows, rowClass = () => null) {
  const title = (column) => element("th", { scope: "col", class: column.text ? "text" : "number" }, column.title.cloneNode?.(true) ?? column.title);
  const body = rows.map((row) =>
    element("tr", { class: rowClass(row) }, ...columns.map((column, index) => cell(column, row, index === 0))),
  );
  const frame = element(
    "div",
    { class: "scroll", tabindex: "0", role: "group", "aria-label": caption },
    element(
      "table",
      {},
      element("caption", {}, caption),
      element("thead", {}, element("tr", {}, ...columns.map(title))),
      element("tbody", {}, ...body),
    ),
  );
  const button = downloadButton(fileName(caption), "Save as CSV", () => content(columns, rows));
  button.setAttribute("aria-label", `Save as CSV: ${caption}`);
  return element("div", { class: "table" }, frame, button);
}

/** Rows that can be used first, best first; the others keep their order. */
export const byRank = (rows) => [...rows].sort((a, b) => (a.rank ?? Infinity) - (b.rank ?? Infinity));
