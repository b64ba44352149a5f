// SPDX-License-Identifier: MIT
// node picture-of-scene.mjs 'view.html#STATE' picture.png ['LABEL=OPTION' ...]
// The 3D page as PNG of 1280 x 720 pixels, after the options are chosen. STATE is that of a link to the view. WebGL is in software.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { launchWithWebGl, WEBGL_TIMEOUT } from "./browser.mjs";

const [address, picture, ...choices] = process.argv.slice(2);
const [file, state] = address.split("#");
const browser = await launchWithWebGl();
try {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 } });
  page.setDefaultTimeout(WEBGL_TIMEOUT);
  await page.goto(`${pathToFileURL(resolve(file)).href}${state ? `#${state}` : ""}`, { waitUntil: "commit" });
  await page.waitForFunction(() => window.silvafitView !== undefined);
  await page.evaluate(() => window.silvafitView.ready);
  for (const choice of choices) {
    const at = choice.indexOf("=");
    await page.getByLabel(choice.slice(0, at), { exact: true }).selectOption({ label: choice.slice(at + 1) });
    await page.evaluate(() => window.silvafitView.ready);
  }
  await page.evaluate(() => window.silvafitView.draw());
  await page.screenshot({ path: picture, timeout: WEBGL_TIMEOUT });
} finally {
  await browser.close();
}
