// SPDX-License-Identifier: MIT
// node check-scene.mjs view.html [picture.png]
// Opens a 3D page as a reader would and fails on errors, on anything it fetches, on data that break the contract, on an empty picture, and
// where no tree can be chosen. Prints what was drawn as JSON. Exit 0: all well, 1: problems (on stderr), 2: usage.
import { writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { launchWithWebGl, openPage, WEBGL_TIMEOUT } from "./browser.mjs";
import { difference, drawnShare, pixels } from "./scene-page.mjs";
import { schemaErrors } from "./template.mjs";

const LEAST_DRAWN = 0.02;

async function choosesATree(page) {
  const button = page.locator("[data-tree]").first();
  await button.click();
  const name = await button.getAttribute("aria-label");
  const told = await page.locator("#details").innerText();
  return told.includes(name.replace("Choose ", "")) ? [] : [`"${name}" is followed by: ${told}`];
}

async function changesWithColors(page) {
  const before = await pixels(page);
  await page.getByLabel("Color by").selectOption("species");
  const { changed } = difference(before, await pixels(page));
  await page.getByLabel("Color by").selectOption("natural");
  return changed > 0.001 ? [] : [`colors by species change ${changed} of the picture`];
}

async function check(file, picture) {
  const browser = await launchWithWebGl();
  try {
    const { page, problems } = await openPage(browser, file, { viewport: { width: 900, height: 500 }, timeout: WEBGL_TIMEOUT });
    await page.evaluate(() => window.silvafitView.ready);
    const data = JSON.parse(await page.locator("#view-data").textContent());
    problems.push(...schemaErrors(data).map((error) => `data: ${error}`));
    const share = drawnShare(await pixels(page));
    if (share < LEAST_DRAWN) problems.push(`only ${share} of the picture is drawn`);
    const stats = await page.evaluate(() => window.silvafitView.draw());
    if (data.trees.tree.length > 0) problems.push(...(await choosesATree(page)), ...(await changesWithColors(page)));
    if (picture) writeFileSync(picture, await page.screenshot());
    return { problems, stats: { ...stats, listed: data.trees.tree.length } };
  } finally {
    await browser.close();
  }
}

const [file, picture] = process.argv.slice(2);
if (!file) {
  console.error("usage: node check-scene.mjs view.html [picture.png]");
  process.exit(2);
}
const { problems, stats } = await check(resolve(file), picture);
problems.forEach((problem) => console.error(`${file}: ${problem}`));
if (problems.length === 0) console.log(JSON.stringify(stats));
process.exit(problems.length === 0 ? 0 : 1);
