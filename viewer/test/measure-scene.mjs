// SPDX-License-Identifier: MIT
// node measure-scene.mjs view.html...
// For each page: its bytes, the seconds until it has drawn for the first time, and what was drawn, as JSON. WebGL is in software.
import { statSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { launchWithWebGl, WEBGL_TIMEOUT } from "./browser.mjs";

async function measured(file) {
  const browser = await launchWithWebGl();
  try {
    const page = await browser.newPage({ viewport: { width: 900, height: 500 } });
    page.setDefaultTimeout(WEBGL_TIMEOUT);
    page.on("pageerror", (error) => console.error(error.message));
    const start = performance.now();
    await page.goto(pathToFileURL(file).href, { waitUntil: "commit", timeout: WEBGL_TIMEOUT });
    await page.waitForFunction(() => window.silvafitView !== undefined);
    await page.evaluate(() => window.silvafitView.ready);
    const ready = (performance.now() - start) / 1000;
    const stats = await page.evaluate(() => window.silvafitView.draw());
    return { file, bytes: statSync(file).size, ready_s: Number(ready.toFixed(2)), drawn_s: Number(((performance.now() - start) / 1000).toFixed(2)), ...stats };
  } finally {
    await browser.close();
  }
}

for (const file of process.argv.slice(2)) console.log(JSON.stringify(await measured(resolve(file))));
