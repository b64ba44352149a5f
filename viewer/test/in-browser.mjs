// SPDX-License-Identifier: MIT
// One browser for the tests of a file.
import assert from "node:assert/strict";
import { after, before } from "node:test";
import { chromiumPath, hasChromium, launch, openPage } from "./browser.mjs";
import { writePage } from "./template.mjs";

/** Starts a browser, that of launch() or another, before the tests of the file and closes it after them. */
export function inBrowser(start = launch) {
  let browser;
  before(async () => {
    if (hasChromium) browser = await start();
  });
  after(() => browser?.close());
  return {
    skip: hasChromium ? false : `no Chromium at ${chromiumPath}; SILVAFIT_CHROMIUM can name another`,
    /** Opens the page, hands it over with the problems so far, closes it, and fails on errors and requests that are left among them. */
    async withPage(data, options, use) {
      const { page, problems } = await openPage(browser, writePage(data), options);
      await use(page, problems);
      assert.deepEqual(problems, []);
      await page.context().close();
    },
  };
}
