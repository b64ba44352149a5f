// SPDX-License-Identifier: MIT
// node check-report.mjs report.html [picture.png]
// Opens a report or a comparison as a reader would and fails on errors, on anything it fetches, on charts that are not
// drawn, on data that break the contract, and on tables that differ from those in the folder `tables` beside the page.
// Exit 0: all well, 1: problems (on stderr), 2: usage.
import { existsSync, readFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { launch, openPage, paintedPixels, savedText } from "./browser.mjs";
import { differences } from "./csv-reader.mjs";
import { schemaErrors } from "./template.mjs";

const LEAST_PAINTED_PIXELS = 2000;

async function check(file, picture) {
  const browser = await launch();
  try {
    const { page, problems } = await openPage(browser, file, { viewport: { width: 1280, height: 900 } });
    const data = JSON.parse(await page.locator("#report-data").textContent());
    const painted = await paintedPixels(page);
    problems.push(...schemaErrors(data).map((error) => `data: ${error}`));
    const shown = await page.locator("section.result").count();
    const expected = (data.results ?? data.pairs).length;
    if (shown !== expected) problems.push(`${shown} of ${expected} results are shown`);
    painted.forEach((pixels, index) => {
      if (pixels < LEAST_PAINTED_PIXELS) problems.push(`chart ${index + 1} is empty`);
    });
    if (data.results) problems.push(...(await compareTables(page, join(dirname(file), "tables"))));
    if (data.results?.some(({ observations }) => observations.observed.length > 0) && painted.length === 0) problems.push("there is no chart");
    problems.push(...(await cutTables(page)));
    if (picture) await page.screenshot({ path: picture, fullPage: true });
    return { problems, charts: painted.length, results: shown };
  } finally {
    await browser.close();
  }
}

/** Tables of the stand and of the summary that hide columns on a screen of 1400 pixels; those of coefficients may have any number. */
async function cutTables(page) {
  await page.setViewportSize({ width: 1400, height: 900 });
  // Frames are measured again when the browser has laid out the page.
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const captions = await page.locator(':is(#stand, #summary) .table[data-more~="right"]:visible caption').allTextContents();
  return captions.map((caption) => `columns are hidden: ${caption}`);
}

/** What the page saves must be what the program wrote. */
async function compareTables(page, folder) {
  const problems = [];
  for (const button of await page.locator("#tables [data-file]").all()) {
    const name = await button.getAttribute("data-file");
    if (!existsSync(join(folder, name))) continue;
    const found = differences(await savedText(page, button), readFileSync(join(folder, name), "utf8"));
    problems.push(...found.slice(0, 3).map((difference) => `${name}: ${difference}`));
  }
  return problems;
}

const [file, picture] = process.argv.slice(2);
if (!file) {
  console.error("usage: node check-report.mjs report.html [picture.png]");
  process.exit(2);
}
const { problems, charts, results } = await check(resolve(file), picture);
problems.forEach((problem) => console.error(`${file}: ${problem}`));
if (problems.length === 0) console.log(`${file}: ${results} results, ${charts} charts, no problems`);
process.exit(problems.length === 0 ? 0 : 1);
