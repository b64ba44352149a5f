// SPDX-License-Identifier: MIT
// Tables as files: CSV by RFC 4180, saved from the page without a network.
import { element } from "./dom.js";

const NEEDS_QUOTES = /[",\r\n]/;

/** Texts that a spreadsheet may read as a formula; they get an apostrophe, as in the files of the program. */
const FORMULA = /^['\s]*[=+\-@]/;
const isHarmless = (text) => /^-{1,3}$/.test(text) || !Number.isNaN(Number(text.replace(",", ".")));

/** Numbers with all digits; missing values are empty. */
function field(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "";
  const plain = typeof value === "boolean" ? (value ? "yes" : "no") : String(value);
  const text = FORMULA.test(plain) && !isHarmless(plain) ? `'${plain}` : plain;
  return NEEDS_QUOTES.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}

/** @param {string[]} header  @param {(string|number|boolean|null)[][]} rows */
export const csvText = (header, rows) => [header, ...rows].map((row) => `${row.map(field).join(",")}\n`).join("");

/** A heading as part of a file's name. */
export const slug = (title, most) => title.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "").slice(0, most);

/** Lets the browser save a file. */
export function save(name, blob) {
  const link = element("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  // The browser reads it after the click.
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/**
 * A button that saves a table.
 * @param {string} name  of the file
 * @param {string} text  of the button
 * @param {() => string} content
 */
export function downloadButton(name, text, content) {
  const button = element("button", { type: "button", class: "download", "data-file": name }, text);
  button.addEventListener("click", () => save(name, new Blob([content()], { type: "text/csv" })));
  return button;
}
