// SPDX-License-Identifier: MIT
// The cross-section: which trees it has, where, and their outlines.
import assert from "node:assert/strict";
import { test } from "node:test";
import { roundUp } from "../src/format.js";
import { distanceOf, profileOf, usualStrip } from "../src/scene/profile.js";

const all = () => true;
// Three trees of known crowns; the origin is that of the page.
const data = {
  origin: { x: 100, y: 200, z: 0 },
  presets: [{ up: 2, down: 2 }],
  trees: { tree: ["a", "b", "c"], preset: [0, 0, 0], dbh: [20, null, 40], x: [110, 112, 114], y: [205, 207, 230], z: [0, 0, 0] },
};
const variant = {
  h: [10, 12, 14], hcb: [2, 3, 4], hc: [4, 6, 6], cw: [4, 5, 6],
  radii: { east: [1, 2, 3], west: [3, 3, 3], south: [2, 2.5, 3], north: [2, 2.5, 3] },
};

test("a strip has the trees whose stems are in it, the farthest first", () => {
  const east = profileOf(data, variant, { direction: "east", middle: 206, width: 4 }, all);
  // The viewer is in the south: tree b is behind tree a.
  assert.deepEqual(east.map(({ tree, at }) => [tree, at]), [[1, 112], [0, 110]]);
  const north = profileOf(data, variant, { direction: "north", middle: 112, width: 4 }, all);
  // The viewer is in the east: the westernmost tree is the farthest.
  assert.deepEqual(north.map(({ tree, at }) => [tree, at]), [[0, 205], [1, 207], [2, 230]]);
  assert.deepEqual(profileOf(data, variant, { direction: "east", middle: 206, width: 4 }, (tree) => tree === 0).map(({ tree }) => tree), [0]);
  const unknown = { ...variant, hc: [null, 6, 6] };
  assert.deepEqual(profileOf(data, unknown, { direction: "east", middle: 206, width: 4 }, all).map(({ tree }) => tree), [1]);
});

test("an outline has the height, the crown base and both radii of its tree", () => {
  const [tree] = profileOf(data, variant, { direction: "east", middle: 205, width: 1 }, all);
  const across = tree.outline.map(([x]) => x);
  const up = tree.outline.map(([, y]) => y);
  assert.equal(Math.max(...up), 10);
  assert.equal(Math.min(...up), 2);
  // The widest height, 4 m, is one of the 24 steps of the crown.
  assert.ok(Math.abs(Math.max(...across) - 1) < 1e-9);
  assert.ok(Math.abs(Math.min(...across) + 3) < 1e-9);
  assert.deepEqual(tree.stem, { radius: 0.1, height: 10 });
});

test("the first strip is through the middle of the shown trees", () => {
  assert.deepEqual(usualStrip(data, "east", all), { direction: "east", middle: 217.5, width: 10 });
  assert.deepEqual(usualStrip(data, "north", (tree) => tree < 2), { direction: "north", middle: 111, width: 10 });
});

test("distances and the scale", () => {
  assert.deepEqual(distanceOf([1, 2], [4, 6]), { horizontal: 3, vertical: 4, straight: 5 });
  assert.equal(roundUp(27 / 8), 5);
  assert.equal(roundUp(100 / 12), 10);
  assert.equal(roundUp(1.9 / 8), 0.5);
});
