// SPDX-License-Identifier: MIT
// Sky, ground and shadows for walking.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Box3, Vector3 } from "three";
import { inWebGl, pixels } from "./scene-page.mjs";
import { sceneExample } from "./template.mjs";

const { skip, withScene } = inWebGl();

test("shadows are those of all trees, and while walking in a large stand those near the camera", async () => {
  globalThis.self ??= globalThis;
  globalThis.ProgressEvent ??= class extends Event {};
  const { View } = await import("../src/scene/view.js");
  const position = new Vector3(40, 1.7, -30);
  const shadowed = (side, isWalking) => View.prototype.shadowed.call({ box: new Box3(new Vector3(0, 0, 0), new Vector3(side, 0, side)), isWalking, camera: { position } });
  for (const [side, isWalking] of [[300, false], [20, true]]) {
    assert.deepEqual(shadowed(side, isWalking).center.toArray(), [side / 2, 0, side / 2]);
    assert.ok(Math.abs(shadowed(side, isWalking).radius - side / Math.SQRT2) < 1e-9);
  }
  assert.deepEqual(shadowed(300, true), { center: position, radius: 60 });
  const isBehind = (from, radius) => View.prototype.shadowsAreBehind.call({ isWalking: true, shadowCenter: new Vector3(from, 0, 0), shadowRadius: radius, camera: { position: new Vector3() } });
  assert.deepEqual([isBehind(10, 60), isBehind(16, 60), isBehind(16, 25)], [false, true, false]);
});

test("the sky is there for walking only, and bluer above", { skip }, () =>
  withScene(sceneExample(), { reducedMotion: "reduce", colorScheme: "light" }, async (page) => {
    const hasSky = () => page.evaluate(() => window.silvafitView.hasObject("sky"));
    assert.equal(await hasSky(), false);
    const from = await pixels(page);
    await page.getByRole("button", { name: "Walk", exact: true }).click();
    assert.equal(await hasSky(), true);
    const walking = await pixels(page);
    const blueness = ([red, , blue]) => blue - red;
    const most = (picture, row) => Math.max(...Array.from({ length: picture.width }, (_, column) => blueness(picture.data.subarray(4 * (picture.width * row + column), 4 * (picture.width * row + column) + 3))));
    // From outside, the sky has the color of the page's picture.
    assert.ok(most(walking, 0) > most(from, 0) + 20, `${most(walking, 0)} ${most(from, 0)}`);
    await page.getByRole("button", { name: "Orbit", exact: true }).click();
    assert.equal(await hasSky(), false);
  }));
