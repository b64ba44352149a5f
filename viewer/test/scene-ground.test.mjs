// SPDX-License-Identifier: MIT
// Heights of the ground, and outlines that follow it.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Box3, Group, Mesh, PlaneGeometry, Raycaster, Vector3 } from "three";
import { Ground } from "../src/scene/ground.js";
import { Heights } from "../src/scene/heights.js";

const reliefAt = (x, z) => 3 * Math.sin(x / 9) + 2 * Math.cos(z / 7);

/** A square of an uneven ground round the origin. */
function relief(size, pieces) {
  const geometry = new PlaneGeometry(size, size, pieces, pieces).rotateX(-Math.PI / 2);
  const { position } = geometry.attributes;
  for (let index = 0; index < position.count; ++index) position.setY(index, reliefAt(position.getX(index), position.getZ(index)));
  return new Mesh(geometry);
}

/** Places without a pattern, the same in every run: multiples of the golden ratio. */
const places = (count, size) => Array.from({ length: count }, (_, index) => [0.618034, 0.754878].map((step) => (((index + 1) * step) % 1 - 0.5) * size));

test("heights are those that a ray from above meets", () => {
  const surface = relief(60, 30);
  surface.position.set(5, 100, -8);
  surface.scale.set(1, 2, 1);
  const group = new Group();
  group.add(surface);
  const heights = new Heights(group);
  const raycaster = new Raycaster();
  for (const [x, z] of places(500, 80)) {
    raycaster.set(new Vector3(x, 1000, z), new Vector3(0, -1, 0));
    const hit = raycaster.intersectObject(group, true)[0];
    const height = heights.at(x, z);
    if (!hit) assert.equal(height, null);
    // The ray's own rounding at 1000 m.
    else assert.ok(Math.abs(height - hit.point.y) < 1e-6, `${x}, ${z}: ${height}, expected ${hit.point.y}`);
  }
  assert.equal(heights.at(NaN, 0), null);
});

test("the highest of surfaces that lie above each other counts, and the grid takes triangles of any size", () => {
  const group = new Group();
  const low = new Mesh(new PlaneGeometry(1000, 1000).rotateX(-Math.PI / 2));
  const high = relief(10, 60);
  high.position.y = 50;
  group.add(low, high);
  const heights = new Heights(group);
  assert.ok(Math.abs(heights.at(100, 100)) < 1e-9);
  assert.ok(Math.abs(heights.at(0, 0) - 50 - reliefAt(0, 0)) < 0.01);
  assert.ok(heights.listed.length <= 8 * (2 + 2 * 60 * 60), `${heights.listed.length} entries`);
  assert.equal(new Heights(new Group()).at(0, 0), null);
});

/** Square plots in rows, 25 m wide. */
const plotsInRows = (count) => {
  const side = Math.ceil(Math.sqrt(count));
  return Array.from({ length: count }, (_, index) => {
    const [x, y] = [30 * (index % side) - 15 * side, 30 * Math.floor(index / side) - 15 * side];
    return { name: String(index), outline: [[x, y], [x + 25, y], [x + 25, y + 25], [x, y + 25]] };
  });
};

test("outlines follow the ground, one plot after the other, of thousands of plots at once", () => {
  const plots = plotsInRows(3000);
  const surface = relief(1800, 180);
  const box = new Box3(new Vector3(-900, -5, -900), new Vector3(900, 20, 900));
  const before = performance.now();
  const ground = new Ground(surface, { plots, origin: { x: 0, y: 0, z: 0 } }, box);
  // A fifth of a second; a ray for each point through all triangles took minutes.
  assert.ok(performance.now() - before < 20_000);
  const { position } = ground.outlines.geometry.attributes;
  // Thirteen pieces of at most 2 m a side, two ends each.
  assert.deepEqual(ground.outlineStarts, Array.from({ length: 3001 }, (_, plot) => 104 * plot));
  assert.equal(position.count, 104 * 3000);
  for (const [plot, vertex] of [[0, 0], [1234, 57], [2999, 103]]) {
    const at = ground.outlineStarts[plot] + vertex;
    const [x, y, z] = [position.getX(at), position.getY(at), position.getZ(at)];
    assert.ok(Math.abs(y - ground.heightAt(x, z) - 0.15) < 1e-3);
    const [[west, south]] = plots[plot].outline;
    assert.ok(x >= west - 1e-3 && x <= west + 25.001 && -z >= south - 1e-3 && -z <= south + 25.001);
  }
  for (let at = 0; at < position.count; at += 2) {
    assert.ok(Math.hypot(position.getX(at) - position.getX(at + 1), position.getZ(at) - position.getZ(at + 1)) <= 2);
  }
});
