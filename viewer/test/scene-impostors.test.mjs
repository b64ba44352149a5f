// SPDX-License-Identifier: MIT
// Trees that are far away: directions and sizes of their pictures, and what is drawn.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { difference, inWebGl, pixels } from "./scene-page.mjs";
import { sceneExample } from "./template.mjs";

const { skip, withScene } = inWebGl();
const COUNT = 2500;

test("directions cover the upper half of the sphere, and the octahedron's map leads back", async () => {
  const { directionOf } = await import("../src/scene/impostors.js");
  for (const u of [-1, -0.6, -0.2, 0.2, 0.6, 1]) {
    for (const v of [-1, -0.6, -0.2, 0.2, 0.6, 1]) {
      const { x, y, z } = directionOf(u, v);
      assert.ok(y >= 0 && Math.abs(Math.hypot(x, y, z) - 1) < 1e-12);
      const sum = Math.abs(x) + y + Math.abs(z);
      assert.ok(Math.abs((x + z) / sum - u) < 1e-12 && Math.abs((x - z) / sum - v) < 1e-12);
    }
  }
  // Corners and edges of the square are level directions, its middle is above.
  assert.deepEqual(directionOf(1, 1).toArray(), [1, 0, 0]);
  assert.ok(Math.abs(directionOf(1, 0.2).y) < 1e-12);
  assert.deepEqual(directionOf(0, 0).toArray(), [0, 1, 0]);
});

test("a picture contains the cylinder around the tree, with a margin of a tenth at most", async () => {
  const { directionOf, extentFrom } = await import("../src/scene/impostors.js");
  const [height, radius] = [18, 2.5];
  for (const [u, v] of [[1, 0.6], [0.6, 0.2], [-0.2, 0.2]]) {
    const toEye = directionOf(u, v);
    const right = new Vector3(0, 1, 0).cross(toEye).normalize();
    const up = toEye.clone().cross(right);
    let [wide, high] = [0, 0];
    for (let step = 0; step < 360; ++step) {
      const angle = (step * Math.PI) / 180;
      for (const y of [-height / 2, height / 2]) {
        const point = new Vector3(radius * Math.cos(angle), y, radius * Math.sin(angle));
        wide = Math.max(wide, Math.abs(point.dot(right)));
        high = Math.max(high, Math.abs(point.dot(up)));
      }
    }
    const extent = extentFrom(toEye, height, radius);
    for (const [own, needed] of [[extent.wide, wide], [extent.high, high]]) assert.ok(own >= needed && own <= 1.1 * needed);
  }
});

/** The trees of the example again and again, 4 m apart: most are impostors. */
function largeStand() {
  const data = sceneExample();
  const again = (values) => Array.from({ length: COUNT }, (_, tree) => values[tree % values.length]);
  const side = Math.ceil(Math.sqrt(COUNT));
  data.trees = Object.fromEntries(Object.entries(data.trees).map(([name, values]) => [name, again(values)]));
  data.trees.x = data.trees.x.map((_, tree) => data.origin.x + 4 * ((tree % side) - side / 2));
  data.trees.y = data.trees.y.map((_, tree) => data.origin.y + 4 * (Math.floor(tree / side) - side / 2));
  for (const variant of data.variants) {
    for (const name of ["h", "hcb", "cw", "hc", "model"]) variant[name] = again(variant[name]);
    if (variant.radii) variant.radii = Object.fromEntries(Object.entries(variant.radii).map(([name, values]) => [name, again(values)]));
  }
  return data;
}

/** Share of pixels that are greener than red and blue. */
function greenShare({ data }) {
  let green = 0;
  for (let at = 0; at < data.length; at += 4) green += data[at + 1] > data[at] && data[at + 1] > data[at + 2] + 20 ? 1 : 0;
  return green / (data.length / 4);
}

test("far trees have the colors of their leaves, and those of a coloring", { skip }, () =>
  withScene(largeStand(), { reducedMotion: "reduce" }, async (page) => {
    const { byLevel, triangles } = await page.evaluate(() => window.silvafitView.draw());
    assert.ok(byLevel[0].at(-1) > COUNT / 4, `${byLevel[0]}`);
    // The least budget, and the ground with two triangles a tree.
    assert.ok(triangles <= 200_000 + 2 * COUNT + 1000, `${triangles}`);
    const natural = await pixels(page);
    assert.ok(greenShare(natural) > 0.08, `${greenShare(natural)}`);
    await page.getByLabel("Color by").selectOption("species");
    const { changed } = difference(natural, await pixels(page));
    assert.ok(changed > 0.04, `${changed}`);
  }));
