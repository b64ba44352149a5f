// SPDX-License-Identifier: MIT
// The 3D page from file://: draws, picks, colors, compares variants, is moved by keys and touch; no error, nothing fetched.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import { launchWithoutWebGl } from "./browser.mjs";
import { inBrowser } from "./in-browser.mjs";
import { columns, difference, drawnShare, inWebGl, pixels, ready } from "./scene-page.mjs";
import { texturedModels } from "./textured-models.mjs";
import { sceneExample, schemaErrors } from "./template.mjs";

const { skip, withScene } = inWebGl();

test("the example obeys the schema, which refuses what is misspelled or missing", () => {
  assert.deepEqual(schemaErrors(sceneExample()), []);
  const broken = [(data) => delete data.trees.dbh, (data) => (data.variants[0].hieght = []), (data) => (data.models.glb = "https://example.org"), (data) => (data.trees.tree[0] = 12)];
  for (const breakIt of broken) {
    const data = sceneExample();
    breakIt(data);
    assert.notDeepEqual(schemaErrors(data), []);
  }
});

test("the page draws the stand", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    const share = drawnShare(await pixels(page));
    assert.ok(share > 0.1 && share < 0.9, `${share} of the picture is drawn`);
    const stats = await page.evaluate(() => window.silvafitView.draw());
    assert.equal(stats.trees, 14);
    assert.ok(stats.triangles > 14 * 60);
    assert.equal(await page.title(), "Fourteen trees");
    assert.equal(await page.locator("#canvas-hint").count(), 1);
  }),
);

test("a click chooses the tree under it, and says what is known of it", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    const data = sceneExample();
    const canvas = await page.locator("#canvas").boundingBox();
    // The tree that is nearest to the camera has nothing before it.
    const nearest = await page.evaluate(() => {
      const [x, , z] = window.silvafitView.camera();
      return { x, z };
    });
    const distance = (tree) => Math.hypot(data.trees.x[tree] - data.origin.x - nearest.x, data.origin.y - data.trees.y[tree] - nearest.z);
    const tree = data.trees.tree.map((_, index) => index).sort((a, b) => distance(a) - distance(b))[0];
    const at = await page.evaluate((index) => window.silvafitView.whereIs(index), tree);
    await page.mouse.click(canvas.x + at.x, canvas.y + at.y);
    assert.equal(await page.evaluate(() => window.silvafitView.chosen()), tree);
    const told = await page.locator("#details").innerText();
    const { trees } = data;
    assert.ok(told.includes(`Chosen: plot ${data.plots[trees.plot[tree]].name}, tree ${trees.tree[tree]}`), told);
    for (const [, value] of Object.entries({ h: trees.h[tree], hcb: trees.hcb[tree] })) assert.ok(told.includes(value.toFixed(2)), `${value} in ${told}`);
    const ols = data.variants.find(({ name }) => name === "ols");
    assert.ok(told.includes(ols.h[tree].toFixed(2)) && told.includes((trees.h[tree] - ols.h[tree]).toFixed(2)), told);
    for (const index of "WMUC") assert.ok(told.includes(trees[index][tree].toFixed(2)), index);
    assert.equal(await page.locator("tr.is-chosen").count(), 1);
    // The sky holds no tree.
    await page.mouse.click(canvas.x + 4, canvas.y + 4);
    assert.equal(await page.evaluate(() => window.silvafitView.chosen()), null);
  }),
);

test("the list finds, sorts and chooses trees", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    const data = sceneExample();
    await page.getByLabel("Search plot, tree, species").fill("plot 2, tree 990");
    assert.equal(await page.locator("[data-tree]").count(), 1);
    const before = await page.evaluate(() => window.silvafitView.camera());
    await page.getByRole("button", { name: "Choose plot 2, tree 990" }).click();
    assert.equal(await page.evaluate(() => window.silvafitView.chosen()), data.trees.tree.indexOf("990"));
    assert.notDeepEqual(await page.evaluate(() => window.silvafitView.camera()), before);
    await page.getByLabel("Search plot, tree, species").fill("");
    await page.getByRole("button", { name: "h m" }).click();
    await page.getByRole("button", { name: "h m" }).click();
    const first = await page.locator("[data-tree]").first().getAttribute("data-tree");
    assert.equal(data.trees.h[Number(first)], Math.max(...data.trees.h));
    assert.equal(await page.locator('th[aria-sort="descending"]').innerText(), "h m ↓");
  }),
);

test("every coloring changes the picture, and its legend says how", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    await page.getByLabel("Plot", { exact: true }).selectOption({ label: "1" });
    const values = await page.locator("#color option").evaluateAll((all) => all.map(({ value }) => value));
    // Natural, species and layer, sizes, indices, two other columns, residuals of four predictions.
    assert.equal(values.length, 1 + 2 + 4 + 4 + 2 + 4 * 3);
    // Residuals of what is shown are those of predictions.
    await page.getByLabel("Sizes", { exact: true }).selectOption("ols");
    const natural = await pixels(page);
    for (const value of values.slice(1)) {
      await page.getByLabel("Color by").selectOption(value);
      const { changed } = difference(natural, await pixels(page));
      assert.ok(changed > 0.02, `${value} changes ${changed} of the picture`);
      assert.match(await page.locator("[aria-live] >> text=/Trees are colored by|Observed minus predicted/").innerText(), /colored|Observed/);
    }
    await page.getByLabel("Color by").selectOption("natural");
    assert.equal(difference(natural, await pixels(page)).changed, 0);
  }),
);

test("two variants stand side by side, seen from one place", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    await page.getByLabel("Sizes", { exact: true }).selectOption("ols");
    await page.getByLabel("Compare with").selectOption("conditional");
    await page.getByLabel("Plot", { exact: true }).selectOption({ label: "1" });
    assert.deepEqual(await page.locator(".side-name:visible").allInnerTexts(), ["OLS", "NLME, plot"]);
    const picture = await pixels(page);
    const half = Math.floor(picture.width / 2);
    const [left, right] = [columns(picture, 0, half), columns(picture, half, 2 * half)];
    assert.ok(drawnShare(left) > 0.05 && drawnShare(right) > 0.05);
    // The same trees at the same places, of other sizes.
    const { changed } = difference(left, right);
    assert.ok(changed > 0.01 && changed < 0.5, `${changed}`);
    const places = await page.evaluate(() => [0, 1].map((side) => window.silvafitView.whereIs(3, side).x));
    assert.ok(Math.abs(places[1] - places[0] - half) < 1.5, `${places}`);
    // Each side is colored by its own residuals: the difference is larger than that of sizes.
    await page.getByLabel("Color by").selectOption("shown-h");
    const colored = await pixels(page);
    const apart = difference(columns(colored, 0, half), columns(colored, half, 2 * half)).mean;
    await page.getByLabel("Color by").selectOption("ols-h");
    const alike = await pixels(page);
    assert.ok(difference(columns(alike, half, 2 * half), columns(colored, half, 2 * half)).mean > 0.1 && apart > 0, `${apart}`);
    assert.equal(difference(columns(alike, 0, half), columns(colored, 0, half)).changed, 0);
    const at = await page.evaluate(() => window.silvafitView.whereIs(3, 1));
    const canvas = await page.locator("#canvas").boundingBox();
    await page.mouse.click(canvas.x + at.x, canvas.y + at.y);
    assert.notEqual(await page.evaluate(() => window.silvafitView.chosen()), null);
    await page.getByLabel("Compare with").selectOption("");
    assert.equal(await page.locator(".side-name:visible").count(), 0);
  }),
);

test("a thinning is shown before and after", { skip }, () => {
  const data = sceneExample();
  const [before] = data.variants;
  const kept = (values) => values.map((value, tree) => (tree % 2 === 0 ? value : null));
  data.variants.push({ ...Object.fromEntries(Object.entries(before).map(([name, value]) => [name, Array.isArray(value) ? kept(value) : value])),
    radii: before.radii && Object.fromEntries(Object.entries(before.radii).map(([name, value]) => [name, kept(value)])), name: "thinned", title: "After thinning" });
  assert.deepEqual(schemaErrors(data), []);
  return withScene(data, {}, async (page) => {
    assert.deepEqual(await page.locator(".side-name:visible").allInnerTexts(), ["Observed", "After thinning"]);
    assert.equal(await page.getByLabel("Compare with").inputValue(), "thinned");
    const picture = await pixels(page);
    const half = Math.floor(picture.width / 2);
    assert.ok(drawnShare(columns(picture, half, 2 * half)) < drawnShare(columns(picture, 0, half)));
    const places = await page.evaluate(() => [0, 1].map((side) => window.silvafitView.whereIs(2, side).x));
    assert.ok(Math.abs(places[1] - places[0] - half) < 1.5, `${places}`);
    assert.ok(await page.evaluate(() => !window.silvafitView.page.view.sides[1].bodies[3]));
  });
});

test("crown curves, overlaps and shadows come and go", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    await page.getByLabel("Plot", { exact: true }).selectOption({ label: "1" });
    const plain = await pixels(page);
    for (const label of ["Crown curves", "Overlapping crowns", "Shadows"]) {
      const box = page.getByLabel(label);
      await box.click();
      const { changed } = difference(plain, await pixels(page), 8);
      assert.ok(changed > 0.003, `${label} changes ${changed} of the picture`);
      if (label === "Overlapping crowns") assert.match(await page.getByText(/pairs of crowns overlap/).innerText(), /^\d+ pairs/);
      await box.click();
    }
    assert.equal(difference(plain, await pixels(page)).changed, 0);
  }),
);

test("one plot can be shown alone", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    await page.getByLabel("Plot", { exact: true }).selectOption({ label: "2" });
    assert.equal((await page.evaluate(() => window.silvafitView.draw())).trees, 5);
    assert.equal(await page.locator("[data-tree]").count(), 5);
  }),
);

test("trees are finer from near than from afar, and the budget is kept", { skip }, () =>
  withScene(sceneExample(), { reducedMotion: "reduce" }, async (page) => {
    const levels = () => page.evaluate(() => window.silvafitView.draw().byLevel[0]);
    await page.locator("#canvas").focus();
    for (let presses = 0; presses < 45; ++presses) await page.keyboard.press("-");
    const far = await levels();
    assert.equal(far.at(-1), 14, `${far}`);
    await page.getByRole("button", { name: "Choose plot 2, tree 990" }).click();
    await page.locator("#canvas").focus();
    for (let presses = 0; presses < 12; ++presses) await page.keyboard.press("+");
    const close = await levels();
    assert.ok(close[0] >= 1, `${close}`);
  }),
);

test("keys turn, come nearer and walk at eye height; without motion where that is asked for", { skip }, () =>
  withScene(sceneExample(), { reducedMotion: "reduce" }, async (page) => {
    const camera = () => page.evaluate(() => window.silvafitView.camera());
    await page.locator("#canvas").focus();
    const start = await camera();
    await page.keyboard.press("ArrowLeft");
    const turned = await camera();
    assert.ok(Math.abs(turned[1] - start[1]) < 1e-6 && Math.hypot(turned[0] - start[0], turned[2] - start[2]) > 0.5);
    await page.waitForTimeout(200);
    assert.deepEqual(await camera(), turned);
    await page.keyboard.press("2");
    assert.equal(await page.getByRole("button", { name: "Walk", exact: true }).getAttribute("aria-pressed"), "true");
    const walking = await camera();
    // The ground of the two plots lies between 120 and 140 m; eyes are 1.7 m above it.
    const data = sceneExample();
    const lowest = Math.min(...data.trees.z) - data.origin.z;
    const highest = Math.max(...data.trees.z) - data.origin.z;
    assert.ok(walking[1] >= lowest + 1.6 && walking[1] <= highest + 1.8, `${walking}`);
    await page.keyboard.press("w");
    const walked = await camera();
    assert.ok(Math.hypot(walked[0] - walking[0], walked[2] - walking[2]) > 0.2);
    await page.getByRole("button", { name: "Turn left" }).press("Enter");
    await page.getByRole("button", { name: "Walk forward" }).press("Enter");
    assert.notDeepEqual(await camera(), walked);
    await page.locator("#canvas").focus();
    await page.keyboard.press("?");
    assert.ok(await page.getByRole("dialog").isVisible());
    await page.keyboard.press("Escape");
    assert.ok(!(await page.getByRole("dialog").isVisible()));
  }),
);

test("a tap chooses and a finger turns", { skip }, () =>
  withScene(sceneExample(), { hasTouch: true, viewport: { width: 360, height: 640 } }, async (page) => {
    const at = await page.evaluate(() => window.silvafitView.whereIs(6));
    const canvas = await page.locator("#canvas").boundingBox();
    await page.touchscreen.tap(canvas.x + at.x, canvas.y + at.y);
    assert.notEqual(await page.evaluate(() => window.silvafitView.chosen()), null);
    const before = await page.evaluate(() => window.silvafitView.camera());
    const session = await page.context().newCDPSession(page);
    const finger = (type, x) => session.send("Input.dispatchTouchEvent", { type, touchPoints: type === "touchEnd" ? [] : [{ x: canvas.x + x, y: canvas.y + 150 }] });
    await finger("touchStart", 100);
    for (const x of [120, 150, 180]) await finger("touchMove", x);
    await finger("touchEnd", 180);
    await page.waitForFunction((old) => window.silvafitView.camera().some((value, axis) => Math.abs(value - old[axis]) > 0.1), before);
  }),
);

test("texts of the inventory stay texts", { skip }, () => {
  const hostile = "</script><img src=x onerror=\"document.title='taken'\">";
  const data = sceneExample();
  data.title = hostile;
  data.trees.tree[0] = hostile;
  data.species[0] = `<b>${hostile}`;
  data.plots[0].name = "\u2028<!--<script>";
  data.notes = [hostile];
  return withScene(data, {}, async (page) => {
    assert.equal(await page.locator("img, b").count(), 0);
    assert.equal(await page.title(), hostile);
    await page.getByLabel("Color by").selectOption("species");
    await page.getByRole("button", { name: `Choose plot ${data.plots[0].name}, tree ${hostile}` }).click();
    assert.ok((await page.locator("#details").innerText()).includes(hostile));
    assert.equal(await page.locator("img, b").count(), 0);
  });
});

test("the picture is saved as PNG", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save picture" }).click()]);
    assert.equal(download.suggestedFilename(), "silvafit-view.png");
    const bytes = readFileSync(await download.path());
    assert.deepEqual([...bytes.subarray(1, 4)].map((code) => String.fromCharCode(code)).join(""), "PNG");
    assert.ok(bytes.length > 20_000, `${bytes.length} bytes`);
    const { width, height } = await page.locator("#canvas").boundingBox();
    assert.deepEqual([bytes.readUInt32BE(16), bytes.readUInt32BE(20)], [2 * width, 2 * height]);
  }),
);

test("the legend stands below a saved picture, which can be larger", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    await page.getByLabel("Color by").selectOption("species");
    await page.getByLabel("Saved picture").selectOption("3");
    const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save picture" }).click()]);
    const bytes = readFileSync(await download.path());
    const { width, height } = await page.locator("#canvas").boundingBox();
    const [wide, high] = [bytes.readUInt32BE(16), bytes.readUInt32BE(20)];
    assert.equal(wide, 3 * width);
    // A title, a line of keys and a sentence.
    assert.ok(high >= 3 * (height + 60), `${high} pixels`);
    // The page has its own size again.
    assert.equal(await page.evaluate(() => document.getElementById("canvas").width), width);
  }),
);

test("a cross-section draws the trees of a strip and measures distances", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    const { trees } = sceneExample();
    await page.locator("#show-profile").click();
    const inStrip = (middle, width) => trees.y.filter((y) => Math.abs(y - middle) <= width / 2).length;
    await page.locator("#profile-width").fill("500");
    await page.locator("#profile-width").dispatchEvent("change");
    const middle = Number(await page.locator("#profile-middle").inputValue());
    assert.equal(await page.locator(".profile-tree").count(), inStrip(middle, 500));
    await page.locator("#profile-width").fill("6");
    await page.locator("#profile-middle").fill("27");
    await page.locator("#profile-middle").dispatchEvent("change");
    await page.locator("#profile-width").dispatchEvent("change");
    assert.equal(await page.locator(".profile-tree").count(), inStrip(27, 6));
    const box = await page.locator(".profile-drawing").boundingBox();
    await page.mouse.click(box.x + 0.4 * box.width, box.y + 0.5 * box.height);
    await page.mouse.click(box.x + 0.6 * box.width, box.y + 0.5 * box.height);
    const told = await page.locator("#profile-distance").innerText();
    assert.match(told, /^Distance ([\d.]+) m: \1 m horizontally, 0\.00 m vertically\.$/);
    const saved = page.waitForEvent("download");
    await page.locator("#profile-save").click();
    assert.equal((await saved).suggestedFilename(), "silvafit-cross-section.svg");
    await page.locator("#profile-close").click();
    assert.equal(await page.locator("#profile").isVisible(), false);
  }),
);

test("a range of residuals hides the other trees", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    const data = sceneExample();
    const ols = data.variants.find(({ name }) => name === "ols");
    const larger = data.trees.h.filter((h, tree) => h - ols.h[tree] >= 0).length;
    await page.locator("#filters-summary").click();
    await page.locator("#only-residual").selectOption({ label: "height, OLS" });
    await page.locator("#lowest-residual").fill("0");
    await page.locator("#lowest-residual").dispatchEvent("change");
    assert.match(await page.locator("#about").innerText(), new RegExp(`Shown: ${larger} of 14 trees`));
  }),
);

test("a page without trees shows its scene, and no list", { skip }, () => {
  const data = sceneExample();
  const empty = { ...data, scene: data.models.glb, models: null, variants: [], plots: [], species: [], trees: Object.fromEntries(Object.keys(data.trees).map((name) => [name, []])) };
  return withScene(empty, {}, async (page) => {
    assert.ok(drawnShare(await pixels(page)) > 0.01);
    assert.equal(await page.locator("#search").count(), 0);
    assert.equal(await page.getByLabel("Color by").count(), 0);
  });
});

test("pictures of leaves keep their transparency, in natural and other colors", { skip }, () =>
  withScene(texturedModels(sceneExample()), {}, async (page) => {
    // A disk of leaves 4 m across over each tree whose picture is opaque in its left half only, seen from above.
    await page.getByLabel("Plot", { exact: true }).selectOption({ label: "1" });
    await page.getByLabel("Detail").selectOption("high");
    for (const [coloring, isLeaf] of [["natural", (r, g, b) => g > r + 40 && g > b + 40], ["M", (r, g, b) => Math.max(r, g, b) - Math.min(r, g, b) > 30]]) {
      await page.getByLabel("Color by").selectOption(coloring);
      const { data } = await pixels(page);
      let leaves = 0;
      let black = 0;
      for (let at = 0; at < data.length; at += 4) {
        leaves += isLeaf(...data.subarray(at, at + 3)) ? 1 : 0;
        black += Math.max(...data.subarray(at, at + 3)) < 8 ? 1 : 0;
      }
      assert.ok(leaves > 200, `${coloring}: ${leaves} pixels of leaves`);
      // The transparent half of the picture is black: it must not be seen.
      assert.ok(black < 50, `${coloring}: ${black} black pixels`);
    }
  }),
);

test("plots with coordinates of their own are shown one at a time", { skip }, () => {
  const data = sceneExample();
  const [first] = data.plots;
  const shift = first.outline[0].map((value, axis) => value - data.plots[1].outline[0][axis]);
  data.plots[1].outline = first.outline;
  data.trees.x = data.trees.x.map((x, tree) => (data.trees.plot[tree] === 1 ? x + shift[0] : x));
  data.trees.y = data.trees.y.map((y, tree) => (data.trees.plot[tree] === 1 ? y + shift[1] : y));
  return withScene(data, {}, async (page) => {
    assert.equal((await page.evaluate(() => window.silvafitView.draw())).trees, 9);
    assert.equal(await page.locator("[data-tree]").count(), 9);
    assert.ok(await page.getByText("Plots cover each other").isVisible());
    const outlined = () => page.evaluate(() => window.silvafitView.outlined());
    assert.deepEqual(await outlined(), ["1"]);
    const choose = (label) => page.getByLabel("Plot", { exact: true }).selectOption({ label });
    await choose("2");
    assert.deepEqual(await outlined(), ["2"]);
    await choose("all");
    assert.equal(await page.locator("[data-tree]").count(), 14);
    assert.deepEqual(await outlined(), ["1", "2"]);
  });
});

/** The example as a scene of another program: no trees, but whatever is in the file. */
function sceneAlone(glb) {
  const data = sceneExample();
  const none = Object.fromEntries(Object.keys(data.trees).map((name) => [name, []]));
  return { ...data, scene: glb ?? data.models.glb, models: null, variants: [], plots: [], species: [], trees: none };
}

test("what is told of a chosen tree is seen at once", { skip }, async () => {
  for (const viewport of [{ width: 320, height: 640 }, { width: 1440, height: 700 }, { width: 3840, height: 2160 }]) {
    await withScene(sceneExample(), { viewport, pixelRatio: 0.25 }, async (page) => {
      const isSeen = () =>
        page.evaluate(() => {
          const panel = document.getElementById("panel").getBoundingClientRect();
          const { top, height } = document.querySelector("#details .chosen").getBoundingClientRect();
          return top >= panel.top && top + height <= panel.bottom && panel.bottom <= innerHeight + 1;
        });
      const at = await page.evaluate(() => window.silvafitView.whereIs(6));
      const canvas = await page.locator("#canvas").boundingBox();
      await page.mouse.click(canvas.x + at.x, canvas.y + at.y);
      assert.notEqual(await page.evaluate(() => window.silvafitView.chosen()), null);
      assert.ok(await isSeen(), `a click at ${viewport.width}`);
      await page.getByRole("button", { name: "Choose plot 2, tree 990" }).click();
      assert.ok(await isSeen(), `the list at ${viewport.width}`);
      await page.getByRole("button", { name: "Hide controls" }).click();
      assert.match(await page.locator(".card").innerText(), /plot 2, tree 990/);
    });
  }
});

test("the whole stand is seen from orbit, whatever was before", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    const isPressed = (name) => page.getByRole("button", { name, exact: true }).getAttribute("aria-pressed");
    const leave = [() => page.getByRole("button", { name: "Whole stand" }).click(), () => page.getByLabel("Plot", { exact: true }).selectOption({ label: "2" })];
    for (const next of leave) {
      await page.getByRole("button", { name: "Walk", exact: true }).click();
      // Keys walk at once.
      assert.equal(await page.evaluate(() => document.activeElement.id), "canvas");
      assert.ok(await page.locator(".pad").isVisible());
      await next();
      assert.deepEqual([await isPressed("Walk"), await isPressed("Orbit")], ["false", "true"]);
      assert.ok(!(await page.locator(".pad").isVisible()));
    }
  }),
);

test("a scene without measurements keeps its ground, and one walks on it", { skip }, () =>
  withScene(sceneAlone(), { reducedMotion: "reduce" }, async (page) => {
    await page.evaluate(() => window.silvafitView.draw());
    const floor = await page.evaluate(() => window.silvafitView.hasObject("ground"));
    assert.ok(floor);
    await page.getByRole("button", { name: "Walk", exact: true }).click();
    const [x, eye, z] = await page.evaluate(() => window.silvafitView.camera());
    // The ground of the example has a relief: eyes are 1.7 m above its height at that place, or its lowest point.
    const ground = await page.evaluate(([east, south]) => window.silvafitView.groundAt(east, south), [x, z]);
    assert.ok(Math.abs(eye - ground - 1.7) < 1e-6, `${eye} over ${ground}`);
    assert.ok(drawnShare(await pixels(page)) > 0.05);
    // The link leads to the same place, still walking.
    const ahead = await pixels(page);
    await page.locator("#link").click();
    assert.match(page.url(), /mode=walk/);
    await page.reload();
    await ready(page);
    const again = await page.evaluate(() => window.silvafitView.camera());
    for (const [i, value] of [x, eye, z].entries()) assert.ok(Math.abs(again[i] - value) < 2e-3, `${again} after ${[x, eye, z]}`);
    assert.equal(await page.getByRole("button", { name: "Walk", exact: true }).getAttribute("aria-pressed"), "true");
    assert.ok(Math.abs(drawnShare(await pixels(page)) - drawnShare(ahead)) < 0.02);
  }),
);

/** A GLB whose nodes have half their size in 2021, and grow until 2026. */
function growing(base64) {
  const glb = Buffer.from(base64, "base64");
  const jsonBytes = glb.readUInt32LE(12);
  const json = JSON.parse(glb.subarray(20, 20 + jsonBytes));
  const parts = [glb.subarray(28 + jsonBytes)];
  const add = (values, type, more) => {
    const bytes = Buffer.from(new Float32Array(values).buffer);
    const byteOffset = parts.reduce((sum, { length }) => sum + length, 0);
    parts.push(bytes);
    const bufferView = json.bufferViews.push({ buffer: 0, byteOffset, byteLength: bytes.length }) - 1;
    return json.accessors.push({ bufferView, componentType: 5126, count: 2, type, ...more }) - 1;
  };
  const input = add([0, 1], "SCALAR", { min: [0], max: [1] });
  // Positions are quantized, so that nodes have a scale.
  const { nodes } = json.scenes[0];
  json.animations = [{
    samplers: nodes.map((node) => ({ input, output: add([...json.nodes[node].scale.map((one) => one / 2), ...json.nodes[node].scale], "VEC3"), interpolation: "LINEAR" })),
    channels: nodes.map((node, sampler) => ({ sampler, target: { node, path: "scale" } })),
    extras: { times: [{ time: 0, name: "2021" }, { time: 1, name: "2026" }] },
  }];
  const binary = Buffer.concat(parts);
  json.buffers[0].byteLength = binary.length;
  const text = Buffer.from(JSON.stringify(json));
  const padded = Buffer.concat([text, Buffer.alloc(-text.length & 3, 32)]);
  const word = (value) => Buffer.from(new Uint32Array([value]).buffer);
  return Buffer.concat([glb.subarray(0, 8), word(28 + padded.length + binary.length), word(padded.length), Buffer.from("JSON"), padded,
    word(binary.length), Buffer.from("BIN\0"), binary]).toString("base64");
}

test("growth is played, and moved by hand", { skip }, () =>
  withScene(sceneAlone(growing(sceneExample().models.glb)), { reducedMotion: "reduce" }, async (page) => {
    const clock = page.locator("#clock");
    assert.equal(await clock.textContent(), "2026");
    const grown = await pixels(page);
    await page.getByLabel("Time").fill("0");
    assert.equal(await clock.textContent(), "2021");
    const young = await pixels(page);
    assert.ok(difference(young, grown).changed > 1e-4);
    await page.getByRole("button", { name: "Play" }).click();
    await page.getByRole("button", { name: "Pause" }).waitFor();
    await page.getByRole("button", { name: "Play" }).waitFor();
    assert.equal(await clock.textContent(), "2026");
    assert.ok(difference(await pixels(page), grown).changed < 1e-4);
  }),
);

test("a scene that cannot be read is told of, without an error", { skip }, () =>
  withScene(sceneAlone(Buffer.from("glTF and nothing else that could be read").toString("base64")), {}, async (page) => {
    assert.match(await page.getByRole("alert").innerText(), /cannot be drawn/);
  }),
);

test("a tree of the list is looked at from where nothing hides it", { skip }, () =>
  withScene(sceneExample(), { reducedMotion: "reduce" }, async (page) => {
    const data = sceneExample();
    const canvas = await page.locator("#canvas").boundingBox();
    for (let tree = 0; tree < data.trees.tree.length; ++tree) {
      await page.locator(`[data-tree="${tree}"]`).click();
      await page.mouse.click(canvas.x + canvas.width / 2, canvas.y + canvas.height / 2);
      assert.equal(await page.evaluate(() => window.silvafitView.chosen()), tree);
    }
  }),
);

test("legends and headline count the trees that are shown", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    const counted = async () => (await page.locator("#colors .keys li").allInnerTexts()).reduce((sum, text) => sum + Number(/\((\d+)\)/.exec(text)[1]), 0);
    for (const coloring of ["species", "layer"]) {
      await page.getByLabel("Plot", { exact: true }).selectOption({ label: "all" });
      await page.getByLabel("Color by").selectOption(coloring);
      assert.equal(await counted(), 14);
      await page.getByLabel("Plot", { exact: true }).selectOption({ label: "2" });
      assert.equal(await counted(), 5);
      assert.match(await page.locator("#about").innerText(), /^Plot 2: 5 of 14 trees/);
    }
  }),
);

test("overlaps are told of each half", { skip }, () =>
  withScene(sceneExample(), {}, async (page) => {
    await page.getByLabel("Sizes", { exact: true }).selectOption("ols");
    await page.getByLabel("Compare with").selectOption("conditional");
    await page.getByLabel("Overlapping crowns").click();
    const lines = await page.getByText(/crowns overlap/).allInnerTexts();
    assert.deepEqual(lines.filter((line) => /^(OLS|NLME, plot): \d+ pair/.test(line)).length, 2, `${lines}`);
  }),
);

test("keys that are let go and pressed again within a picture walk no faster", { skip }, () =>
  withScene(sceneExample(), { reducedMotion: "reduce" }, async (page) => {
    await page.getByRole("button", { name: "Walk", exact: true }).click();
    /** Rows of steps and pictures that key events begin at once. */
    const begun = (...types) =>
      page.evaluate(async (all) => {
        const canvas = document.getElementById("canvas");
        const press = (type) => canvas.dispatchEvent(new KeyboardEvent(type, { code: "KeyW", key: "w", bubbles: true }));
        const pictures = async () => {
          for (let count = 0; count < 3; ++count) await new Promise((resolve) => requestAnimationFrame(resolve));
        };
        await pictures();
        const ask = window.requestAnimationFrame;
        let asked = 0;
        window.requestAnimationFrame = (next) => {
          asked += 1;
          return ask.call(window, next);
        };
        all.forEach(press);
        window.requestAnimationFrame = ask;
        press("keyup");
        await pictures();
        return asked;
      }, types);
    const once = await begun("keydown");
    assert.equal(once, 2, "a row of steps, and a picture");
    assert.equal(await begun("keydown", "keyup", "keydown", "keyup", "keydown"), once);
  }),
);

test("a loss of the graphics is said, and the picture comes back with them", { skip }, () =>
  withScene(sceneExample(), {}, async (page, problems) => {
    const before = await pixels(page);
    await page.evaluate(() => {
      window.graphics = document.getElementById("canvas").getContext("webgl2").getExtension("WEBGL_lose_context");
      window.graphics.loseContext();
    });
    assert.match(await page.getByRole("alert").innerText(), /withdrawn the graphics/);
    await page.getByRole("button", { name: "Choose plot 2, tree 990" }).click();
    assert.match(await page.locator("#details").innerText(), /Chosen: plot 2, tree 990/);
    await page.keyboard.press("Escape");
    await page.evaluate(() => window.graphics.restoreContext());
    await page.getByRole("alert").waitFor({ state: "detached" });
    await page.getByRole("button", { name: "Whole stand" }).click();
    const { changed } = difference(before, await pixels(page));
    assert.ok(changed < 0.01, `${changed} of the pixels differ`);
    // What the browser itself says of the loss.
    assert.ok(problems.every((problem) => /context.?lost/i.test(problem)), `${problems}`);
    problems.length = 0;
  }),
);

const plain = inBrowser(launchWithoutWebGl);
test("without WebGL each plot of those that lie on each other can be listed", { skip }, () => {
  const data = sceneExample();
  data.plots[1].outline = data.plots[0].outline;
  return plain.withPage(data, {}, async (page) => {
    await ready(page);
    assert.equal(await page.locator("[data-tree]").count(), 9);
    await page.getByLabel("Plot", { exact: true }).selectOption({ label: "2" });
    assert.equal(await page.locator("[data-tree]").count(), 5);
    await page.getByRole("button", { name: "Choose plot 2, tree 990" }).click();
    await page.getByLabel("Plot", { exact: true }).selectOption({ label: "all" });
    assert.equal(await page.locator("[data-tree]").count(), 14);
    assert.ok(!(await page.getByRole("button", { name: "Whole stand" }).isVisible()));
  });
});

test("without WebGL the page says so, and the trees can still be looked up", { skip }, () =>
  plain.withPage(sceneExample(), {}, async (page) => {
    await ready(page);
    assert.match(await page.getByRole("alert").innerText(), /no WebGL 2/);
    await page.getByRole("button", { name: "Choose plot 2, tree 990" }).click();
    assert.match(await page.locator("#details").innerText(), /Chosen: plot 2, tree 990/);
  }),
);
