// SPDX-License-Identifier: MIT
// Ten thousand trees: drawing calls, triangles and the page's own time for a picture, without drawing it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Frustum, Matrix4, PerspectiveCamera, Vector3 } from "three";
import { BUDGETS } from "../src/scene/levels.js";
import { sceneExample } from "./template.mjs";

const COUNT = 10_000;
const SPACING_M = 2.5;

/** The trees of the example again and again, on a square. */
function largeStand() {
  const data = sceneExample();
  const again = (values) => Array.from({ length: COUNT }, (_, tree) => values[tree % values.length]);
  const side = Math.ceil(Math.sqrt(COUNT));
  data.trees = Object.fromEntries(Object.entries(data.trees).map(([name, values]) => [name, again(values)]));
  data.trees.x = data.trees.x.map((_, tree) => data.origin.x + SPACING_M * ((tree % side) - side / 2));
  data.trees.y = data.trees.y.map((_, tree) => data.origin.y + SPACING_M * (Math.floor(tree / side) - side / 2));
  for (const variant of data.variants) {
    for (const name of ["h", "hcb", "cw", "hc", "model"]) variant[name] = again(variant[name]);
    if (variant.radii) variant.radii = Object.fromEntries(Object.entries(variant.radii).map(([name, values]) => [name, again(values)]));
  }
  return data;
}

async function stand() {
  globalThis.self ??= globalThis;
  globalThis.ProgressEvent ??= class extends Event {};
  const { loadStand } = await import("../src/scene/sides.js");
  const data = largeStand();
  return (await loadStand(data)).side(data.variants[0], 0).stand;
}

function seenFrom(position, target) {
  const camera = new PerspectiveCamera(45, 16 / 9, 0.1, 5000);
  camera.position.copy(position);
  camera.lookAt(target);
  camera.updateMatrixWorld();
  const frustum = new Frustum().setFromProjectionMatrix(new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
  return [frustum, position, 900 / (2 * Math.tan(Math.PI / 8))];
}

/** Casters of shadows are drawn once, not in every picture. */
function drawn({ group, layers }) {
  const meshes = group.children.filter((mesh) => mesh.visible && mesh.layers.isEnabled(layers.own));
  return { calls: meshes.length, triangles: meshes.reduce((sum, { geometry }) => sum + (geometry.instanceCount * geometry.index.count) / 3, 0) };
}

const VIEWS = {
  whole: [new Vector3(-120, 140, 280), new Vector3(0, 5, 0)],
  near: [new Vector3(-20, 25, 45), new Vector3(0, 5, 0)],
  walking: [new Vector3(1.2, 1.7, 1.2), new Vector3(30, 5, 0)],
};

test("pictures of 10,000 trees keep to the budget, in few drawing calls", async () => {
  const side = await stand();
  for (const [name, [position, target]] of Object.entries(VIEWS)) {
    const { trees } = side.update(...seenFrom(position, target), BUDGETS.automatic);
    const { calls, triangles } = drawn(side);
    assert.ok(triangles > 0.1 * BUDGETS.automatic && triangles <= BUDGETS.automatic, `${name}: ${triangles} triangles`);
    assert.ok(calls <= 60, `${name}: ${calls} drawing calls`);
    assert.equal(side.treesByLevel().reduce((sum, count) => sum + count), trees);
  }
});

test("all trees are drawn where all are in view, none where none is", async () => {
  const side = await stand();
  const [position, target] = VIEWS.whole;
  const shown = side.shown.filter(Boolean).length;
  assert.ok(shown > 0.9 * COUNT);
  assert.equal(side.update(...seenFrom(new Vector3(0, 900, 1), target), BUDGETS.automatic).trees, shown);
  assert.equal(side.update(...seenFrom(position, position.clone().multiplyScalar(2)), BUDGETS.automatic).trees, 0);
  side.show((tree) => tree < 100);
  assert.equal(side.update(...seenFrom(new Vector3(0, 900, 1), target), BUDGETS.automatic).trees, side.shown.filter(Boolean).length);
  assert.ok(side.shown.filter(Boolean).length <= 100);
});

test("the page's own work leaves most of a sixtieth of a second to the graphics card", async () => {
  const side = await stand();
  const times = Array.from({ length: 40 }, (_, turn) => {
    const [position, target] = VIEWS.whole;
    const view = seenFrom(position.clone().applyAxisAngle(new Vector3(0, 1, 0), turn / 10), target);
    const start = performance.now();
    side.update(...view, BUDGETS.automatic);
    return performance.now() - start;
  });
  // The quickest, since tests share the machine: some 2 ms on a server's core.
  assert.ok(Math.min(...times) < 8, `${Math.min(...times)} ms`);
});
