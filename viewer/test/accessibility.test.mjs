// SPDX-License-Identifier: MIT
// axe-core finds no violation of WCAG 2.2 AA, in both themes, on a small screen, and with everything open.
import assert from "node:assert/strict";
import { test } from "node:test";
import axe from "axe-core";
import { inBrowser } from "./in-browser.mjs";
import { comparison, example } from "./template.mjs";

const { skip, withPage } = inBrowser();
const ALL = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];
/** What a theme can spoil. */
const CONTRAST = { type: "rule", values: ["color-contrast", "link-in-text-block"] };

async function violations(page, runOnly) {
  await page.evaluate(axe.source);
  const found = await page.evaluate((rules) => window.axe.run(document, { runOnly: rules, resultTypes: ["violations"] }), runOnly);
  return found.violations.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 3).map(({ html }) => html.slice(0, 160)).join(" | ")}`);
}

const DRESSES = [
  ["light", { colorScheme: "light" }, ALL],
  ["dark", { colorScheme: "dark" }, CONTRAST],
  ["small", { viewport: { width: 320, height: 640 } }, ALL],
];

/* One of a kind is enough: axe takes long over hundreds of tables. */
const report = () => ({ ...example(), results: example().results.slice(1) });
const ofOnePair = () => ({ ...comparison(), pairs: comparison().pairs.slice(1) });

for (const [name, data] of [["report", report], ["comparison", ofOnePair]]) {
  for (const [dress, options, rules] of DRESSES) {
    test(`the ${name}, ${dress}, has no barrier that axe knows`, { skip }, () =>
      withPage(data(), options, async (page) => {
        await page.locator("details > summary").evaluateAll((all) => all.forEach((summary) => summary.click()));
        assert.deepEqual(await violations(page, rules), []);
      }),
    );
  }
}

test("headings go down by one level at a time, and the page has its landmarks", { skip }, () =>
  withPage(example(), {}, async (page) => {
    const levels = await page.locator("h1, h2, h3, h4").evaluateAll((all) => all.map(({ tagName }) => Number(tagName[1])));
    assert.equal(levels.filter((level) => level === 1).length, 1);
    levels.slice(1).forEach((level, index) => assert.ok(level <= levels[index] + 1, `heading ${index + 2} jumps to level ${level}`));
    for (const landmark of ["navigation", "main"]) assert.equal(await page.getByRole(landmark).count(), 1, landmark);
  }),
);

test("what has the keyboard's focus shows it", { skip }, () =>
  withPage(example(), {}, async (page) => {
    for (let presses = 0; presses < 12; ++presses) {
      await page.keyboard.press("Tab");
      const width = await page.evaluate(() => parseFloat(getComputedStyle(document.activeElement).outlineWidth));
      assert.ok(width >= 2, await page.evaluate(() => document.activeElement.outerHTML.slice(0, 120)));
    }
  }),
);
