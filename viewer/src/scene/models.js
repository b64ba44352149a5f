// SPDX-License-Identifier: MIT
// Models from the GLB in the page, and stand-ins (crown curve and stem) for trees that are far away.
import { BufferAttribute, BufferGeometry, DynamicDrawUsage, InstancedBufferAttribute, InstancedBufferGeometry, LoadingManager, MeshStandardMaterial } from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { MeshoptDecoder } from "three/examples/jsm/libs/meshopt_decoder.module.js";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { ringTriangles, surfaceRings } from "./crown.js";
import { glbOf } from "./data.js";
import { KIND, toUnit } from "./shape.js";

/**
 * @typedef {object} Part
 * @property {BufferGeometry} geometry
 * @property {import("three").Material} material
 * @property {boolean} isFoliage  takes the color that a coloring gives its tree
 */
/**
 * @typedef {object} Model
 * @property {Part[][]} levels   parts of each level of detail, the finest first
 * @property {number[]} triangles  of each level
 * @property {number} preset     index
 */

/** A GLB in the page; it may not refer to anything outside. */
export async function parseGlb(base64) {
  const manager = new LoadingManager();
  manager.setURLModifier((url) => {
    if (/^(data|blob):/.test(url)) return url;
    throw new Error(`the scene refers to ${url}, which is not in the page`);
  });
  return new GLTFLoader(manager).setMeshoptDecoder(MeshoptDecoder).parseAsync(await glbOf(base64), "");
}

export const partNameOf = (mesh) => mesh.geometry.userData.part ?? mesh.userData.part ?? "";
export const trianglesOf = (geometry) => (geometry.index ? geometry.index.count : geometry.attributes.position.count) / 3;

/** Numbers as floats, for any component type in the file, with the node's scale. */
function floats(attribute, matrix) {
  const size = attribute.itemSize;
  const values = new Float32Array(attribute.count * size);
  for (let index = 0; index < attribute.count; ++index) {
    for (let axis = 0; axis < size; ++axis) values[index * size + axis] = attribute.getComponent(index, axis);
  }
  const result = new BufferAttribute(values, size);
  return matrix ? result.applyMatrix4(matrix) : result;
}

/** A mesh of a model in normalized coordinates. */
function unitGeometry(mesh, shape, kind) {
  mesh.updateWorldMatrix(true, false);
  const { position, normal, ...others } = mesh.geometry.attributes;
  const positions = floats(position, mesh.matrixWorld);
  const normals = floats(normal);
  toUnit(positions.array, normals.array, shape, kind);
  const geometry = new BufferGeometry();
  geometry.setIndex(mesh.geometry.index);
  geometry.setAttribute("position", positions);
  geometry.setAttribute("normal", normals);
  for (const [name, attribute] of Object.entries(others)) geometry.setAttribute(name, floats(attribute));
  geometry.setAttribute("treeKind", new BufferAttribute(new Float32Array(position.count).fill(kind), 1));
  return geometry;
}

const attributeNames = (geometry) => Object.keys(geometry.attributes).sort().join();

/** Merges parts with one material, so that a level needs one draw call per material. */
function merged(meshes, shape) {
  const byMaterial = new Map();
  for (const mesh of meshes) {
    const list = byMaterial.get(mesh.material) ?? [];
    byMaterial.set(mesh.material, [...list, mesh]);
  }
  return [...byMaterial].flatMap(([material, list]) => {
    const geometries = list.map((mesh) => unitGeometry(mesh, shape, partNameOf(mesh) === "stem" ? KIND.stem : KIND.crown));
    const isFoliage = list.every((mesh) => partNameOf(mesh) === "foliage");
    const canMerge = geometries.every((geometry) => attributeNames(geometry) === attributeNames(geometries[0]) && Boolean(geometry.index) === Boolean(geometries[0].index));
    return (canMerge ? [mergeGeometries(geometries)] : geometries).map((geometry) => ({ geometry, material, isFoliage }));
  });
}

/** The models that the program grew for this page, and the ground. */
export async function grownModels(data) {
  const { scene } = await parseGlb(data.models.glb);
  const presetNames = data.presets.map(({ name }) => name);
  const models = data.models.shapes.map((shape, number) => {
    const levels = data.models.levels.map((level) => {
      const node = scene.getObjectByName(`model-${number}-level-${level}`);
      const meshes = [];
      node.traverse((object) => object.isMesh && meshes.push(object));
      return merged(meshes, shape);
    });
    return modelOf(levels, presetNames.indexOf(shape.preset));
  });
  return { models, ground: scene.getObjectByName("ground") };
}

export function modelOf(levels, preset) {
  const triangles = levels.map((parts) => parts.reduce((sum, { geometry }) => sum + trianglesOf(geometry), 0));
  return { levels, triangles, preset };
}

/** A surface of rings of points around the axis; see surfaceRings of crown.js. */
function ringGeometry(rings, kind) {
  const positions = new Float32Array(rings.flat(2));
  const geometry = new BufferGeometry();
  geometry.setIndex(ringTriangles(rings).flat());
  geometry.setAttribute("position", new BufferAttribute(positions, 3));
  geometry.computeVertexNormals();
  geometry.setAttribute("treeKind", new BufferAttribute(new Float32Array(positions.length / 3).fill(kind), 1));
  return geometry;
}

/** The crown curve of a preset in normalized coordinates. */
export const unitCrown = ({ up, down }, sides, steps) => surfaceRings({ hcb: 1, hc: 2, h: 3, east: 1, west: 1, south: 1, north: 1, up, down }, sides, steps);

/** A geometry that is drawn once for each tree of a list, of as many numbers as there is space for. */
export function listed(geometry, trees) {
  const own = new InstancedBufferGeometry();
  own.setIndex(geometry.index);
  for (const [name, attribute] of Object.entries(geometry.attributes)) own.setAttribute(name, attribute);
  own.setAttribute("treeIndex", new InstancedBufferAttribute(new Float32Array(trees), 1).setUsage(DynamicDrawUsage));
  own.instanceCount = trees.length;
  return own;
}

/** A quad, whose corners are at -1 and 1. */
function quad() {
  const geometry = new BufferGeometry();
  geometry.setIndex([0, 1, 2, 0, 2, 3]);
  geometry.setAttribute("position", new BufferAttribute(new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0]), 3));
  geometry.setAttribute("normal", new BufferAttribute(new Float32Array([0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1]), 3));
  return geometry;
}

/**
 * The stand-in of a tree that is far away: a quad with pictures (see impostors.js), and its crown curve on a stem as the caster of its shadow.
 * `views.value` is the atlas of the pictures, once it is drawn.
 */
export function standInOf(preset) {
  const circle = (height, radius) => Array.from({ length: 4 }, (_, side) => [radius * Math.cos((side * Math.PI) / 2), height, radius * Math.sin((side * Math.PI) / 2)]);
  const views = { value: null };
  const parts = [{ geometry: quad(), views }];
  const material = new MeshStandardMaterial();
  const casters = [
    { geometry: ringGeometry(shrunken(unitCrown(preset, 7, 2)), KIND.crown), material, isFoliage: true },
    { geometry: ringGeometry([circle(0, 1), circle(1.5, 0.7)], KIND.pole), material, isFoliage: false },
  ];
  return { parts, views, triangles: parts.reduce((sum, { geometry }) => sum + trianglesOf(geometry), 0), casters };
}

/** The inner part of a crown: the shadow caster of a tree must not shade the tree's own leaves. */
const shrunken = (rings) => rings.map((ring) => ring.map(([x, y, z]) => [0.65 * x, 2 + 0.65 * (y - 2), 0.65 * z]));
