// SPDX-License-Identifier: MIT
// Pictures of the page in its dresses, for people to look at; SILVAFIT_SCREENSHOTS is the folder.
import assert from "node:assert/strict";
import { mkdirSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { paintedPixels } from "./browser.mjs";
import { inBrowser } from "./in-browser.mjs";
import { comparison, example } from "./template.mjs";

const folder = process.env.SILVAFIT_SCREENSHOTS;
const browser = inBrowser();
const skip = browser.skip || (folder ? false : "SILVAFIT_SCREENSHOTS names no folder");

const DRESSES = [
  ["report-light", example, { viewport: { width: 1280, height: 900 } }],
  ["report-dark", example, { viewport: { width: 1280, height: 900 }, colorScheme: "dark" }],
  ["report-phone", example, { viewport: { width: 320, height: 640 } }],
  ["comparison-light", comparison, { viewport: { width: 1280, height: 900 } }],
];

for (const [name, data, options] of DRESSES) {
  test(`picture ${name}`, { skip }, () =>
    browser.withPage(data(), options, async (page) => {
      mkdirSync(folder, { recursive: true });
      await paintedPixels(page);
      const path = join(folder, `${name}.png`);
      await page.screenshot({ path, fullPage: true });
      // An empty page of that size takes a tenth.
      assert.ok(statSync(path).size > 100_000, `${path} is hardly a picture`);
    }),
  );
}

test("print as PDF", { skip }, () =>
  browser.withPage(example(), { viewport: { width: 1280, height: 900 } }, async (page) => {
    mkdirSync(folder, { recursive: true });
    const pdf = await page.pdf({ format: "A4", printBackground: true });
    writeFileSync(join(folder, "report-print.pdf"), pdf);
    assert.equal(pdf.subarray(0, 5).toString(), "%PDF-");
    // Charts are drawn for paper when the browser announces it.
    assert.ok(pdf.length > 100_000, `${pdf.length} bytes`);
  }),
);
