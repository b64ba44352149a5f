// SPDX-License-Identifier: MIT
// Animated scenes at any time.
import assert from "node:assert/strict";
import { test } from "node:test";
import { AnimationClip, Group, InterpolateDiscrete, Object3D, VectorKeyframeTrack } from "three";
import { durationOf, Player } from "../src/scene/player.js";

/** A tree of two stages: the second replaces the first at 1 s, and grows until 3 s. */
function growing() {
  const scene = new Group();
  const [first, second, size] = ["first", "second", "size"].map((name) => Object.assign(new Object3D(), { name }));
  scene.add(first, second);
  second.add(size);
  const steps = (name, values) => new VectorKeyframeTrack(`${name}.scale`, [0, 1], values.flatMap((value) => [value, value, value]), InterpolateDiscrete);
  const clip = new AnimationClip("growth", -1, [
    steps("first", [1, 0]),
    steps("second", [0, 1]),
    new VectorKeyframeTrack("size.scale", [1, 3], [0.5, 0.5, 0.5, 1, 1, 1]),
  ]);
  return { scene, clip, first, second, size };
}

test("a moment shows the stage of its time, forward and backward", () => {
  const { scene, clip, first, second, size } = growing();
  const player = new Player(scene, [clip]);
  assert.equal(player.duration, 3);
  assert.equal(player.time, 3);
  for (const [time, stages, scale] of [[0.4, [1, 0], 0.5], [2, [0, 1], 0.75], [0, [1, 0], 0.5], [3, [0, 1], 1]]) {
    player.show(time);
    assert.deepEqual([first.scale.x, second.scale.x], stages, `${time} s`);
    // The last moment is a millionth before the end.
    assert.ok(Math.abs(size.scale.x - scale) < 1e-5, `${time} s: ${size.scale.x}`);
  }
});

test("times beyond the animation are its ends", () => {
  const { scene, clip, second } = growing();
  const player = new Player(scene, [clip]);
  player.show(-1);
  assert.equal(player.time, 0);
  player.show(99);
  assert.equal(player.time, 3);
  assert.equal(second.scale.x, 1);
});

test("the longest animation counts, and none has no length", () => {
  assert.equal(durationOf([{ duration: 2 }, { duration: 5 }]), 5);
  assert.equal(durationOf([]), 0);
});

test("the time has the name of the last measurement", () => {
  const { scene, clip } = growing();
  const player = new Player(scene, [clip]);
  assert.equal(player.name, null);
  clip.userData = { times: [{ time: 0, name: "2021" }, { time: 1, name: "2026" }] };
  const named = new Player(scene, [clip]);
  for (const [time, name] of [[0, "2021"], [0.9, "2021"], [1, "2026"], [3, "2026"]]) {
    named.show(time);
    assert.equal(named.name, name);
  }
});
