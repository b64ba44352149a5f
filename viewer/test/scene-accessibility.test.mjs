// SPDX-License-Identifier: MIT
// The 3D page for everybody: axe-core, focus, and every width from a phone's to 4k.
import assert from "node:assert/strict";
import { test } from "node:test";
import axe from "axe-core";
import { inWebGl } from "./scene-page.mjs";
import { sceneExample } from "./template.mjs";

const { skip, withScene } = inWebGl();
const RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

async function violations(page) {
  await page.evaluate(axe.source);
  const found = await page.evaluate((rules) => window.axe.run(document, { runOnly: rules, resultTypes: ["violations"] }), RULES);
  return found.violations.map(({ id, nodes }) => `${id}: ${nodes.slice(0, 3).map(({ html }) => html.slice(0, 160)).join(" | ")}`);
}

for (const [name, options] of [["light", { colorScheme: "light" }], ["dark", { colorScheme: "dark" }], ["on a phone", { viewport: { width: 320, height: 640 } }]]) {
  test(`the page, ${name}, has no barrier that axe knows`, { skip }, () =>
    withScene(sceneExample(), options, async (page) => {
      await page.getByRole("button", { name: "Choose plot 1, tree 58" }).click();
      await page.getByLabel("Color by").selectOption("ols-h");
      await page.getByLabel("Overlapping crowns").click();
      await page.getByLabel("Drawing figures").click();
      assert.deepEqual(await violations(page), []);
      await page.getByRole("button", { name: "Walk", exact: true }).click();
      await page.getByRole("button", { name: "Keys and touch" }).click();
      assert.deepEqual(await violations(page), []);
    }),
  );
}

test("Tab goes through picture and controls in their order, and shows where it is", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    const order = [];
    for (let presses = 0; presses < 18; ++presses) {
      await page.keyboard.press("Tab");
      const [id, outline] = await page.evaluate(() => [document.activeElement.id, parseFloat(getComputedStyle(document.activeElement).outlineWidth)]);
      assert.ok(outline >= 2, `${id} shows no focus`);
      order.push(id);
    }
    assert.deepEqual(order, ["canvas", "hide-panel", "orbit", "walk", "whole", "save", "show-keys", "variant", "beside", "plot", "detail", "crowns", "overlaps", "shadows", "show-figures", "theme", "color", "search"]);
  }),
);

test("every control has a name", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    for (const control of await page.locator("button, select, input, canvas").all()) {
      const name = await control.evaluate((node) => node.getAttribute("aria-label") ?? node.labels?.[0]?.innerText ?? node.textContent);
      assert.ok(name.trim().length > 0, await control.evaluate((node) => node.outerHTML));
    }
  }),
);

for (const [width, height] of [[320, 640], [768, 1024], [1280, 720], [3840, 2160]]) {
  test(`nothing is cut off at ${width} x ${height}`, { skip }, () =>
    withScene(sceneExample(), { viewport: { width, height } }, async (page) => {
      const { overflow, picture, text } = await page.evaluate(() => ({
        overflow: document.documentElement.scrollWidth - window.innerWidth,
        picture: document.getElementById("canvas").getBoundingClientRect().toJSON(),
        text: parseFloat(getComputedStyle(document.body).fontSize),
      }));
      assert.ok(overflow <= 0, `${overflow} px too wide`);
      assert.ok(picture.width * picture.height > 0.4 * width * height, JSON.stringify(picture));
      assert.ok(text >= 16);
      for (const name of ["Hide controls", "Orbit", "Save picture"]) {
        const box = await page.getByRole("button", { name, exact: true }).boundingBox();
        assert.ok(box.x >= 0 && box.x + box.width <= width, name);
        // WCAG 2.5.8: targets of at least 24 px.
        assert.ok(box.height >= 24, name);
      }
      await page.getByRole("button", { name: "Hide controls" }).click();
      await page.waitForFunction((whole) => document.getElementById("canvas").getBoundingClientRect().width >= whole - 1, width);
    }),
  );
}
