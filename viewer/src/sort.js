// SPDX-License-Identifier: MIT
// Tables that are sorted by their headings: up, down, and back to the order of the report.
import { element } from "./dom.js";

const NEXT = { none: "ascending", ascending: "descending", descending: "none" };

const isMissing = (value) => value === null || value === undefined || value === "" || Number.isNaN(value);

/** The first number of a text such as "b: −0.0045***"; NaN without one. */
const numberIn = (text) => Number.parseFloat(text.replaceAll("\u2212", "-").replaceAll("\u202f", "").match(/-?\d[\d.]*(e-?\d+)?/)?.[0]);

const byText = new Intl.Collator("en", { numeric: true }).compare;
const compare = (a, b) => (typeof a === "number" && typeof b === "number" ? a - b : byText(String(a), String(b)));

/**
 * Comparison of two rows of a column: by number, or by text. Missing values are last in both directions.
 * @param {(string|number|null)[]} values
 * @param {boolean} isText
 * @returns {(a: number, b: number, sign: number) => number}  of rows by their places
 */
export function comparison(values, isText) {
  const keys = isText ? values : values.map((value) => (typeof value === "string" ? numberIn(value) : value));
  return (a, b, sign) => {
    const [missingA, missingB] = [isMissing(keys[a]), isMissing(keys[b])];
    if (missingA || missingB) return Number(missingA) - Number(missingB);
    return sign * compare(keys[a], keys[b]);
  };
}

/**
 * Makes a button of each heading.
 * @param {HTMLElement[]} headings
 * @param {HTMLElement} body
 * @param {HTMLElement[]} lines  rows of the body in the order of the report
 * @param {ReturnType<typeof comparison>[]} orders  by column
 */
export function makeSortable(headings, body, lines, orders) {
  if (lines.length < 2) return;
  const places = lines.map((_, index) => index);
  headings.forEach((heading, column) => {
    const button = element("button", { type: "button", class: "sort" });
    button.append(...heading.childNodes);
    heading.append(button);
    button.addEventListener("click", () => {
      const order = NEXT[heading.getAttribute("aria-sort") ?? "none"];
      headings.forEach((other) => other.removeAttribute("aria-sort"));
      if (order !== "none") heading.setAttribute("aria-sort", order);
      const sign = order === "descending" ? -1 : 1;
      const sorted = order === "none" ? places : [...places].sort((a, b) => orders[column](a, b, sign));
      body.append(...sorted.map((place) => lines[place]));
    });
  });
}
