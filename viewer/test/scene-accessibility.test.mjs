// SPDX-License-Identifier: MIT
// The 3D page for everybody: axe-core, focus, and every width from a phone's to 4k.
import assert from "node:assert/strict";
import { test } from "node:test";
import axe from "axe-core";
import { inWebGl } from "./scene-page.mjs";
import { sceneExample } from "./template.mjs";

const { skip, withScene: withSharpScene } = inWebGl();
const withScene = (data, options, use) => withSharpScene(data, { pixelRatio: 0.25, ...options }, use);
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
      await page.getByLabel("Drawing statistics").click();
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
    for (let presses = 0; presses < 22; ++presses) {
      await page.keyboard.press("Tab");
      const [id, outline] = await page.evaluate(() => [document.activeElement.id, parseFloat(getComputedStyle(document.activeElement).outlineWidth)]);
      assert.ok(outline >= 2, `${id} shows no focus`);
      order.push(id);
    }
    assert.deepEqual(order, ["canvas", "hide-panel", "orbit", "walk", "whole", "save", "link", "show-profile", "show-keys", "picture-size", "variant", "beside", "plot", "filters-summary", "detail", "crowns", "overlaps", "shadows", "show-figures", "theme", "color", "search"]);
  }),
);

test("every control has a name", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    // What is folded away has no text.
    await page.locator("details").evaluateAll((nodes) => nodes.forEach((node) => (node.open = true)));
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

test("the page itself never scrolls", { skip }, async () => {
  for (const viewport of [{ width: 320, height: 640 }, { width: 768, height: 1024 }, { width: 1440, height: 900 }]) {
    await withScene(sceneExample(), { viewport }, async (page) => {
      const { height, inner } = await page.evaluate(() => ({ height: document.documentElement.scrollHeight, inner: innerHeight }));
      assert.ok(height <= inner, `${height} px of ${inner} at ${viewport.width}`);
    });
  }
});

test("a key keeps the focus where it was", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    const button = page.getByRole("button", { name: "Choose plot 2, tree 990" });
    await button.focus();
    await page.keyboard.press("Enter");
    assert.equal(await page.evaluate(() => document.activeElement.getAttribute("aria-label")), "Choose plot 2, tree 990");
  }),
);

test("the last page of the list leaves the focus on a button that works", { skip }, () => {
  const data = sceneExample();
  const times = (values) => Array.from({ length: 60 }, (_, tree) => values[tree % 14]);
  data.trees = Object.fromEntries(Object.entries(data.trees).map(([name, values]) => [name, times(values)]));
  for (const variant of data.variants) {
    for (const name of ["h", "hcb", "cw", "hc", "model"]) variant[name] = times(variant[name]);
    if (variant.radii) variant.radii = Object.fromEntries(Object.entries(variant.radii).map(([name, values]) => [name, times(values)]));
  }
  return withScene(data, {}, async (page) => {
    await page.getByRole("button", { name: "Next" }).focus();
    await page.keyboard.press("Enter");
    assert.equal(await page.evaluate(() => document.activeElement.textContent), "Previous");
    await page.keyboard.press("Enter");
    assert.equal(await page.evaluate(() => document.activeElement.textContent), "Next");
  });
});

test("names of the halves and the button do not cover each other", { skip }, async () => {
  for (const viewport of [{ width: 320, height: 640 }, { width: 1100, height: 700 }]) {
    await withScene(sceneExample(), { viewport }, async (page) => {
      await page.getByLabel("Sizes", { exact: true }).selectOption("population");
      await page.getByLabel("Compare with").selectOption("conditional");
      const button = await page.getByRole("button", { name: "Hide controls" }).boundingBox();
      for (const name of await page.locator(".side-name:visible").all()) {
        const box = await name.boundingBox();
        const isApart = box.x + box.width <= button.x || box.y >= button.y + button.height || box.y + box.height <= button.y || box.x >= button.x + button.width;
        assert.ok(isApart, `${JSON.stringify(box)} and ${JSON.stringify(button)} at ${viewport.width}`);
      }
    });
  }
});

test("scales and swatches keep their colors where colors are forced", { skip }, () =>
  withScene(sceneExample(), { forcedColors: "active" }, async (page) => {
    await page.getByLabel("Color by").selectOption("species");
    const colors = await page.locator("#colors .swatch").evaluateAll((all) => all.map((node) => getComputedStyle(node).backgroundColor));
    assert.equal(new Set(colors).size, colors.length);
    await page.getByLabel("Color by").selectOption("M");
    assert.match(await page.locator("#colors .ramp").evaluate((node) => getComputedStyle(node).backgroundImage), /gradient/);
  }),
);

for (const [width, height] of [[768, 1024], [3840, 2160]]) {
  test(`the scale bar is in the picture at ${width} x ${height}`, { skip }, () =>
    withScene(sceneExample(), { viewport: { width, height } }, async (page) => {
      const corners = await page.evaluate(() => window.silvafitView.whereIsScale());
      const canvas = await page.locator("#canvas").boundingBox();
      for (const { x, y } of corners) assert.ok(x >= 0 && y >= 0 && x <= canvas.width && y <= canvas.height, JSON.stringify(corners));
    }),
  );
}
