// SPDX-License-Identifier: MIT
// A report page in headless Chromium, watched for errors and for anything it tries to fetch.
import { existsSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const FLAGS = [
  "--no-sandbox",
  "--disable-gpu",
  "--disable-quic",
  "--disable-dev-shm-usage",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
];

/** Where Chromium is; SILVAFIT_CHROMIUM overrides it. */
export const chromiumPath = process.env.SILVAFIT_CHROMIUM ?? "/usr/bin/chromium";
export const hasChromium = existsSync(chromiumPath);

export const launch = () => chromium.launch({ executablePath: chromiumPath, args: FLAGS });

/** WebGL in software: slow, the more so where several tests run at once, but the same picture on every machine. */
export const WEBGL_TIMEOUT = 240_000;
const WEBGL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
export const launchWithWebGl = () => chromium.launch({ executablePath: chromiumPath, args: [...FLAGS.filter((flag) => flag !== "--disable-gpu"), ...WEBGL] });

export const launchWithoutWebGl = () => chromium.launch({ executablePath: chromiumPath, args: [...FLAGS, "--disable-3d-apis"] });

/**
 * Opens a file in a browser of its own context.
 * @param {import("playwright-core").Browser} browser
 * @param {string} file
 * @param {import("playwright-core").BrowserContextOptions & {timeout?: number, pixelRatio?: number}} options  with the longest
 *   wait [ms], and pixels of a canvas per CSS pixel: fewer of them where only the page around it matters
 * @returns {Promise<{page: import("playwright-core").Page, problems: string[]}>}  `problems` grows while the page lives
 */
export async function openPage(browser, file, { timeout = 30_000, pixelRatio, ...options } = {}) {
  const context = await browser.newContext(options);
  context.setDefaultTimeout(timeout);
  const page = await context.newPage();
  if (pixelRatio) await page.addInitScript((value) => Object.defineProperty(window, "devicePixelRatio", { value, configurable: true }), pixelRatio);
  const problems = [];
  const self = pathToFileURL(file).href;
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) problems.push(`console: ${message.text()}`);
  });
  page.on("pageerror", (error) => problems.push(`error: ${error.stack ?? error.message}`));
  page.on("request", (request) => {
    const url = request.url();
    if (url.split("#")[0] !== self && !/^(data|blob):/.test(url)) problems.push(`request: ${url}`);
  });
  await page.goto(self, { waitUntil: "load" });
  return { page, problems };
}

/** Scrolls through the charts, so that each is drawn, and says how many pixels of each are not empty. */
export async function paintedPixels(page) {
  const charts = page.locator(".chart");
  const painted = [];
  for (let index = 0; index < (await charts.count()); ++index) {
    const chart = charts.nth(index);
    await chart.scrollIntoViewIfNeeded();
    await chart.locator("canvas").waitFor({ timeout: 10_000 });
    painted.push(await chart.locator("canvas").evaluate(countOpaque));
  }
  return painted;
}

/** The text of the file that a button saves. */
export async function savedText(page, button) {
  const [download] = await Promise.all([page.waitForEvent("download"), button.click()]);
  const chunks = [];
  for await (const chunk of await download.createReadStream()) chunks.push(chunk);
  return Buffer.concat(chunks).toString("utf8");
}

/* Runs in the page. */
function countOpaque(canvas) {
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let opaque = 0;
  for (let index = 3; index < data.length; index += 4) opaque += data[index] > 0 ? 1 : 0;
  return opaque;
}
