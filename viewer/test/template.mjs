// SPDX-License-Identifier: MIT
// Fills the built template as write_report_page of libstudy does, for tests without the program.
import { mkdtempSync, readFileSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import Ajv2020 from "ajv/dist/2020.js";

const here = (name) => fileURLToPath(new URL(name, import.meta.url));

/** The built page; SILVAFIT_REPORT_TEMPLATE overrides it. */
export const templatePath = process.env.SILVAFIT_REPORT_TEMPLATE ?? here("../dist/report.html");

export const readJson = (path) => JSON.parse(readFileSync(path, "utf8"));
export const example = () => readJson(here("example.json"));

/** Where the data break the contract, in words. */
export function schemaErrors(data) {
  const validate = new Ajv2020({ allErrors: true, allowUnionTypes: true, strictRequired: false }).compile(
    readJson(here("../report-data.schema.json")),
  );
  return validate(data) ? [] : validate.errors.map(({ instancePath, message }) => `${instancePath} ${message}`);
}

const UNSAFE = /[<>&\u2028\u2029]/g;
const escapeJson = (text) => text.replace(UNSAFE, (sign) => `\\u${sign.charCodeAt(0).toString(16).padStart(4, "0")}`);
const escapeHtml = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);

/** Writes a page with the data to a temporary file and returns its path. */
export function writePage(data) {
  const html = readFileSync(templatePath, "utf8")
    .replace("{{=<% %>=}}", "")
    .replace("<% title %>", () => escapeHtml(data.title))
    .replace("<%& data %>", () => escapeJson(JSON.stringify(data)));
  const file = join(mkdtempSync(join(tmpdir(), "silvafit-report-")), "report.html");
  writeFileSync(file, html);
  return file;
}
