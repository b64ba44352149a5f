// SPDX-License-Identifier: MIT
// What the 3D page looks like, against pictures kept in scene-pictures; SILVAFIT_UPDATE_PICTURES=folder writes new ones there.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";
import { decoded, difference, inWebGl, pixels } from "./scene-page.mjs";
import { sceneExample } from "./template.mjs";

const { skip, withScene } = inWebGl();
const kept = (name) => fileURLToPath(new URL(`./scene-pictures/${name}.png`, import.meta.url));
const folder = process.env.SILVAFIT_UPDATE_PICTURES;

/* Drawn in software, so that machines differ by rounding only, at edges of leaves: none of the pixels on one machine, and less than 1 % is
   granted to other versions of Chromium. Colors by species change 4 % of these pictures, and so do crown curves with overlaps. */
const MOST_CHANGED = 0.01;
const MOST_MEAN = 1;

const PICTURES = {
  natural: async () => {},
  dark: async () => {},
  species: (page) => page.getByLabel("Color by").selectOption("species"),
  residual: (page) => page.getByLabel("Color by").selectOption("ols-h"),
  beside: async (page) => {
    await page.getByLabel("Sizes", { exact: true }).selectOption("ols");
    await page.getByLabel("Compare with").selectOption("conditional");
    await page.getByLabel("Color by").selectOption("shown-h");
  },
  overlaps: async (page) => {
    await page.getByLabel("Overlapping crowns").click();
    await page.getByLabel("Crown curves").click();
  },
};

for (const [name, prepare] of Object.entries(PICTURES)) {
  test(`the picture ${name} is as it was`, { skip }, () =>
    withScene(sceneExample(), { viewport: { width: 720, height: 400 }, colorScheme: name === "dark" ? "dark" : "light", reducedMotion: "reduce" }, async (page) => {
      // The size of the picture must not hang on fonts.
      await page.evaluate(() => document.styleSheets[0].insertRule("main { grid-template-columns: 400px 320px !important; }", document.styleSheets[0].cssRules.length));
      await page.waitForFunction(() => document.getElementById("canvas").width === 400);
      await page.getByLabel("Detail").selectOption("high");
      await page.getByLabel("Plot", { exact: true }).selectOption({ label: "1" });
      await page.locator("#canvas").focus();
      for (let presses = 0; presses < 2; ++presses) await page.keyboard.press("+");
      await prepare(page);
      const picture = await pixels(page);
      if (folder) {
        mkdirSync(folder, { recursive: true });
        const png = await page.evaluate(() => (window.silvafitView.draw(), document.getElementById("canvas").toDataURL("image/png").split(",")[1]));
        writeFileSync(join(folder, `${name}.png`), Buffer.from(png, "base64"));
        return;
      }
      const expected = await decoded(page, readFileSync(kept(name)));
      assert.deepEqual([picture.width, picture.height], [expected.width, expected.height]);
      const { changed, mean } = difference(picture, expected, 32);
      assert.ok(changed <= MOST_CHANGED && mean <= MOST_MEAN, `${changed} of the pixels differ by more than 32, mean ${mean}`);
    }),
  );
}
