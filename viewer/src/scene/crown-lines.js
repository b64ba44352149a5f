// SPDX-License-Identifier: MIT
// Crown curves as lines: vertical through the stem in four directions, and around the widest crown. One draw call per preset.
import { BufferAttribute, BufferGeometry, DoubleSide, Float32BufferAttribute, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial, RingGeometry } from "three";
import { treeLineMaterial } from "./materials.js";
import { listed, unitCrown } from "./models.js";
import { sharedSpace } from "./crown.js";
import { KIND } from "./shape.js";

const MERIDIANS = 4;
const STEPS = 8;
const RING = 24;

/** @returns {number[]} end points of the pieces in normalized coordinates */
export function unitLines(preset) {
  const points = [];
  const rings = unitCrown(preset, MERIDIANS, STEPS);
  for (let ring = 0; ring + 1 < rings.length; ++ring) {
    for (let side = 0; side < MERIDIANS; ++side) points.push(...rings[ring][side], ...rings[ring + 1][side]);
  }
  const at = (side) => [Math.cos((2 * Math.PI * side) / RING), 2, Math.sin((2 * Math.PI * side) / RING)];
  for (let side = 0; side < RING; ++side) points.push(...at(side), ...at(side + 1));
  return points;
}

/** @param {boolean} isSeenThrough  whether lines are drawn in front of everything */
export const crownLineMaterial = ({ stand }, isSeenThrough) => treeLineMaterial(new LineBasicMaterial({ toneMapped: false, depthTest: !isSeenThrough, transparent: isSeenThrough }), stand.uniforms);
export const footMaterial = () => new MeshBasicMaterial({ side: DoubleSide, depthTest: false, transparent: true, opacity: 0.9, toneMapped: false });
export const overlapMaterial = () => new MeshBasicMaterial({ transparent: true, opacity: 0.55, side: DoubleSide, depthWrite: false, toneMapped: false });

/**
 * Lines around the crowns of some trees of a side.
 * @param {{stand: import("./stand.js").Stand}} side
 * @param {number[]} trees
 * @param {import("three").Material} material  of crownLineMaterial
 */
export function crownLines(data, { stand }, trees, material) {
  return data.presets.flatMap((preset, index) => {
    const own = trees.filter((tree) => stand.trees[tree] && data.trees.preset[tree] === index);
    if (own.length === 0) return [];
    const points = unitLines(preset);
    const geometry = new BufferGeometry();
    geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
    geometry.setAttribute("treeKind", new BufferAttribute(new Float32Array(points.length / 3).fill(KIND.crown), 1));
    const lines = new LineSegments(listed(geometry, own), material);
    lines.frustumCulled = false;
    lines.layers.set(stand.layers.own);
    return [lines];
  });
}

/** A ring on the ground around the stem of a tree. */
export function footRing({ stand, bodies }, tree, material) {
  const { place, crown } = bodies[tree];
  const radius = (crown.east + crown.west + crown.south + crown.north) / 4;
  const ring = new Mesh(new RingGeometry(radius * 0.93, radius, 48).rotateX(-Math.PI / 2), material);
  ring.position.set(place.x, place.y + 0.1, place.z);
  ring.layers.set(stand.layers.own);
  return ring;
}

/** The overlaps of pairs of crowns. */
export function overlapMesh({ stand, bodies }, pairs, material) {
  const sides = pairs.length > 200 ? 12 : 24;
  const points = pairs.flatMap(({ first, second }) => sharedSpace(bodies[first], bodies[second], sides, sides / 3).flat(2));
  const geometry = new BufferGeometry().setAttribute("position", new Float32BufferAttribute(points, 3));
  const mesh = new Mesh(geometry, material);
  mesh.renderOrder = 1;
  mesh.layers.set(stand.layers.own);
  return mesh;
}
