// SPDX-License-Identifier: MIT
// node check-report.mjs report.html [picture.png]
// Opens a report as a reader would and fails on errors, on anything it fetches, on charts that are not drawn,
// and on data that break the contract. Exit 0: all well, 1: problems (on stderr), 2: usage.
import { resolve } from "node:path";
import { launch, openPage, paintedPixels } from "./browser.mjs";
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
    if (shown !== data.results.length) problems.push(`${shown} of ${data.results.length} results are shown`);
    painted.forEach((pixels, index) => {
      if (pixels < LEAST_PAINTED_PIXELS) problems.push(`chart ${index + 1} is empty`);
    });
    if (data.results.some(({ observations }) => observations.observed.length > 0) && painted.length === 0) problems.push("there is no chart");
    if (picture) await page.screenshot({ path: picture, fullPage: true });
    return { problems, charts: painted.length, results: shown };
  } finally {
    await browser.close();
  }
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
