// SPDX-License-Identifier: MIT
// Tables from a description of their columns.
import { csvText, downloadButton, slug } from "./csv.js";
import { element } from "./dom.js";
import { followScroll } from "./scroll.js";
import { comparison, makeSortable } from "./sort.js";

/**
 * @template Row
 * @typedef {{title: string | Node, value: (row: Row) => string | Node, raw?: (row: Row) => number | null, text?: boolean}} Column
 *   `text` columns are left-aligned, numbers right-aligned; the first column is the row's header. `raw` is the unrounded value for files.
 */

/** A column of numbers, rounded on the page. */
export const numeric = (title, raw, format) => ({ title, raw, value: (row) => format(raw(row)) });

function cell(column, row, isFirst) {
  const attributes = { class: column.text ? "text" : "number", scope: isFirst ? "row" : null };
  return element(isFirst ? "th" : "td", attributes, column.value(row));
}

const textOf = (part) => (typeof part === "string" ? part : part.textContent);
const valueOf = (column, row) => (column.raw ? column.raw(row) : textOf(column.value(row)));

const content = (columns, rows) => csvText(columns.map(({ title }) => textOf(title)), rows.map((row) => columns.map((column) => valueOf(column, row))));

/**
 * A table in a frame that scrolls sideways on a narrow screen, reachable by keyboard, with headings that sort it and a button that saves it.
 * @template Row
 * @param {string} caption
 * @param {Column<Row>[]} columns
 * @param {Row[]} rows
 * @param {(row: Row) => string | null} rowClass
 */
export function table(caption, columns, rows, rowClass = () => null) {
  const headings = columns.map((column) => element("th", { scope: "col", class: column.text ? "text" : "number" }, column.title.cloneNode?.(true) ?? column.title));
  const lines = rows.map((row) => element("tr", { class: rowClass(row) }, ...columns.map((column, index) => cell(column, row, index === 0))));
  const body = element("tbody", {}, ...lines);
  const orders = columns.map((column) => comparison(rows.map((row) => valueOf(column, row)), column.text === true));
  makeSortable(headings, body, lines, orders);
  const frame = element(
    "div",
    { class: "scroll", tabindex: "0", role: "group", "aria-label": caption },
    element("table", {}, element("caption", {}, element("span", { class: "label" }), caption), element("thead", {}, element("tr", {}, ...headings)), body),
  );
  const button = downloadButton(`${slug(caption, 60)}.csv`, "Save as CSV", () => content(columns, rows));
  button.setAttribute("aria-label", `Save as CSV: ${caption}`);
  return element("div", { class: "table" }, frame, followScroll(frame), button);
}

/** Usable rows first, the best at the top; the others keep their order. */
export const byRank = (rows) => [...rows].sort((a, b) => (a.rank ?? Infinity) - (b.rank ?? Infinity));
