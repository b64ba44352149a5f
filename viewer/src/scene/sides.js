// SPDX-License-Identifier: MIT
// Sides of the view: a variant of the stand, or an unchanged scene, from the page's data.
import { Matrix4 } from "three";
import { crownOf, placeOf, treeCount } from "./data.js";
import { lightBothSides } from "./materials.js";
import { grownModels, modelOf, parseGlb, partNameOf, standInOf } from "./models.js";
import { Stand } from "./stand.js";
import { TreeTexture } from "./tree-texture.js";

/** Layers of three.js: 0 is for both sides, and each side has one for its trees and sun, and one for shadow casters. */
export const layersOf = (side) => ({ own: 1 + side, caster: 3 + side });

const reachOf = ({ east, west, south, north }) => Math.max(east, west, south, north);

/** @returns {({crown: object, place: object} | null)[]} of all trees of a variant */
export function bodiesOf(data, variant) {
  return Array.from({ length: treeCount(data) }, (_, tree) => {
    const crown = crownOf(data, variant, tree);
    return crown && { crown, place: placeOf(data, tree) };
  });
}

/** The trees of a GLB file that have measurements: their models, and the matrices that place them. Everything else is shown unchanged. */
class PlacedTrees {
  constructor(data, { scene, animations, parser }) {
    this.data = data;
    this.rest = scene;
    this.animations = animations;
    scene.updateMatrixWorld(true);
    this.collect({ scene, parser });
  }

  collect({ scene, parser }) {
    const { node, number } = this.data.trees;
    const byNode = new Map(node.flatMap((own, tree) => (own === null ? [] : [[own, tree]])));
    const byNumber = new Map(number.flatMap((own, tree) => (own === null ? [] : [[own, tree]])));
    this.models = [];
    this.placed = Array(treeCount(this.data)).fill(null);
    const known = new Map();
    const taken = [];
    scene.traverse((object) => {
      const tree = byNode.get(parser.associations.get(object)?.nodes);
      const meshes = object.isMesh ? [object] : object.children.filter(({ isMesh }) => isMesh);
      if (tree !== undefined && this.placed[tree] === null && meshes.length > 0 && !meshes[0].isInstancedMesh) {
        this.placed[tree] = { model: this.modelOf(meshes, tree, known), matrix: meshes[0].matrixWorld };
        taken.push(...meshes);
      } else if (object.isInstancedMesh && object.geometry.attributes._TREE && byNumber.size > 0) {
        this.collectInstances(object, byNumber, known);
        taken.push(object);
      }
    });
    taken.forEach((object) => object.removeFromParent());
    scene.traverse((object) => {
      if (!object.isMesh) return;
      Object.assign(object, { castShadow: true, receiveShadow: true });
      [object.material].flat().forEach(lightBothSides);
    });
    // The page adapts the ground to trees with measurements; any other ground is unchanged.
    this.ground = treeCount(this.data) > 0 ? (scene.getObjectByName("ground") ?? null) : null;
    this.ground?.removeFromParent();
  }

  /** Instances are listed by part; trees of an instanced node share the model that its parts form. */
  collectInstances(mesh, byNumber, known) {
    const key = mesh.parent?.uuid ?? mesh.uuid;
    const numbers = mesh.geometry.attributes._TREE;
    const part = { geometry: mesh.geometry, material: mesh.material, isFoliage: partNameOf(mesh) === "foliage" };
    const first = byNumber.get(numbers.getX(0));
    const model = known.get(key);
    if (model !== undefined) {
      const levels = [[...this.models[model].levels[0], part]];
      this.models[model] = modelOf(levels, this.models[model].preset);
      return;
    }
    known.set(key, this.models.length);
    this.models.push(modelOf([[part]], this.data.trees.preset[first ?? 0]));
    for (let index = 0; index < mesh.count; ++index) {
      const tree = byNumber.get(numbers.getX(index));
      if (tree === undefined) continue;
      const matrix = new Matrix4();
      mesh.getMatrixAt(index, matrix);
      this.placed[tree] = { model: known.get(key), matrix: matrix.premultiply(mesh.matrixWorld) };
    }
  }

  modelOf(meshes, tree, known) {
    const key = meshes.map(({ geometry }) => geometry.uuid).join();
    if (!known.has(key)) {
      const parts = meshes.map((mesh) => ({ geometry: mesh.geometry, material: mesh.material, isFoliage: partNameOf(mesh) === "foliage" }));
      known.set(key, this.models.length);
      this.models.push(modelOf([parts], this.data.trees.preset[tree]));
    }
    return known.get(key);
  }
}

/** What is drawn: the models of a page, its ground, the rest of a scene with animations, and a function that makes a side, 0 or 1, of a variant. */
export async function loadStand(data) {
  const loaded = data.models ? { ...(await grownModels(data)), rest: null } : new PlacedTrees(data, await parseGlb(data.scene));
  const { models, placed } = loaded;
  const standIns = data.presets.map(standInOf);
  const side = (variant, number) => {
    const bodies = variant ? bodiesOf(data, variant) : [];
    const texture = new TreeTexture(bodies.length);
    const trees = bodies.map((body, tree) => {
      const { model = null, matrix } = placed ? placed[tree] ?? {} : { model: variant.model[tree] };
      if (body === null || model === null) return null;
      const dbh = data.trees.dbh[tree];
      texture.setSizes(tree, body.place, body.crown, placed ? 1 : dbh / data.models.shapes[model].dbh, dbh);
      if (placed) texture.setMatrix(tree, matrix);
      return { model, place: body.place, height: body.crown.h, reach: reachOf(body.crown) };
    });
    return { variant, bodies, stand: new Stand(trees, models, standIns, texture, layersOf(number), Boolean(placed)) };
  };
  return { ground: loaded.ground, rest: loaded.rest, animations: loaded.animations, side };
}
