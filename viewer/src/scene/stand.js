// SPDX-License-Identifier: MIT
// One side of the view: all trees of a variant, drawn by model and level of detail; a drawn tree costs one number per frame.
import { Box3, Group, Mesh, Sphere, Vector3 } from "three";
import { detailFactor, levelFor } from "./levels.js";
import { drawViews, impostorMaterial } from "./impostors.js";
import { listed } from "./models.js";
import { placingOf, treeDepthMaterial, treeMaterial } from "./materials.js";

const CELL_M = 16;
/** Triangles of shadow casters; fast with a graphics card, but takes seconds without one. */
const MOST_CASTING = 1_000_000;
const sphere = new Sphere();

/** Meshes that draw the same list of trees: the parts of one level of one model. */
class Batch {
  constructor(parts, capacity, triangles, isPlaced, side) {
    this.triangles = triangles;
    this.count = 0;
    this.meshes = parts.map((part) => side.meshOf(part, listed(part.geometry, new Float32Array(capacity)), isPlaced));
  }

  begin() {
    this.count = 0;
  }

  add(tree) {
    for (const mesh of this.meshes) mesh.geometry.attributes.treeIndex.array[this.count] = tree;
    this.count += 1;
  }

  end() {
    for (const mesh of this.meshes) {
      mesh.visible = this.count > 0;
      mesh.geometry.instanceCount = this.count;
      const { treeIndex } = mesh.geometry.attributes;
      treeIndex.clearUpdateRanges();
      treeIndex.addUpdateRange(0, this.count);
      treeIndex.needsUpdate = this.count > 0;
    }
  }
}

/**
 * @typedef {object} StandTree
 * @property {number} model
 * @property {{x: number, y: number, z: number}} place
 * @property {number} height
 * @property {number} reach  the largest crown radius
 */
export class Stand {
  /**
   * @param {(StandTree | null)[]} trees
   * @param {import("./models.js").Model[]} models
   * @param {{parts: object[], triangles: number}[] | null} standIns  by preset, or null for none
   * @param {import("./tree-texture.js").TreeTexture} texture
   * @param {{own: number, caster: number}} layers  of three.js, for what is drawn and what casts shadows
   */
  constructor(trees, models, standIns, texture, layers, isPlaced = false) {
    this.trees = trees;
    this.models = models;
    this.standIns = standIns;
    this.texture = texture;
    this.layers = layers;
    this.isPlaced = isPlaced;
    this.uniforms = { treeData: { value: texture.texture }, treeTint: { value: 0 } };
    this.barkUniforms = { treeData: this.uniforms.treeData, treeTint: { value: 0 } };
    this.materials = new Map();
    this.group = new Group();
    this.levelCount = Math.max(...models.map(({ levels }) => levels.length), 0);
    this.batches = models.map(({ levels, triangles }, model) => {
      const capacity = trees.filter((tree) => tree?.model === model).length;
      return levels.map((parts, level) => new Batch(parts, capacity, triangles[level], isPlaced, this));
    });
    this.farBatches = (standIns ?? []).map(({ parts, triangles }, preset) => {
      const capacity = trees.filter((tree) => tree && models[tree.model].preset === preset).length;
      return new Batch(capacity > 0 ? parts : [], capacity, triangles, false, this);
    });
    this.casters = this.castersOf(isPlaced);
    this.pixels = new Float32Array(trees.length);
    this.inView = new Uint32Array(trees.length);
    this.show(() => true);
  }

  /** Materials are shared by all batches of the side. */
  materialOf({ material, isFoliage, views }, isPlaced) {
    const key = views ?? material;
    const known = this.materials.get(key);
    if (known) return known;
    const copy = views ? impostorMaterial(views, this.uniforms) : treeMaterial(material, isFoliage ? this.uniforms : this.barkUniforms, isPlaced);
    this.materials.set(key, copy);
    return copy;
  }

  meshOf(part, geometry, isPlaced) {
    const mesh = new Mesh(geometry, this.materialOf(part, isPlaced));
    mesh.frustumCulled = false;
    mesh.receiveShadow = true;
    mesh.layers.set(this.layers.own);
    this.group.add(mesh);
    return mesh;
  }

  /** Shadows are those of the coarsest level, in large stands those of stand-ins; they are drawn once, not in every frame. */
  castersOf(isPlaced) {
    const whole = this.trees.reduce((sum, tree) => sum + (tree ? this.models[tree.model].triangles.at(-1) : 0), 0);
    if (this.standIns && whole > MOST_CASTING) {
      return this.castersFrom(this.standIns.map(({ casters }) => casters), ({ model }) => this.models[model].preset, false);
    }
    return this.castersFrom(this.models.map(({ levels }) => levels.at(-1)), ({ model }) => model, isPlaced);
  }

  /** @param {object[][]} shapes  parts  @param {(tree: StandTree) => number} shapeOf */
  castersFrom(shapes, shapeOf, isPlaced) {
    const depths = new Map();
    const depthOf = (material) => {
      if (!depths.has(material)) depths.set(material, treeDepthMaterial(this.uniforms, isPlaced, material));
      return depths.get(material);
    };
    return shapes.flatMap((parts, number) => {
      const members = this.trees.flatMap((tree, index) => (tree && shapeOf(tree) === number ? [index] : []));
      if (members.length === 0) return [];
      return parts.map((part) => {
        const mesh = new Mesh(listed(part.geometry, members), this.materialOf(part, isPlaced));
        mesh.customDepthMaterial = depthOf(part.material);
        mesh.frustumCulled = false;
        mesh.castShadow = true;
        mesh.layers.set(this.layers.caster);
        this.group.add(mesh);
        return { mesh, members };
      });
    });
  }

  /** Shows the trees that pass the test. */
  show(passes) {
    this.shown = this.trees.map((tree, index) => tree !== null && passes(index));
    const cells = new Map();
    this.box = new Box3();
    this.trees.forEach((tree, index) => {
      if (!this.shown[index]) return;
      const { x, y, z } = tree.place;
      const key = `${Math.floor(x / CELL_M)},${Math.floor(z / CELL_M)}`;
      const cell = cells.get(key) ?? { box: new Box3(), trees: [] };
      const own = new Box3(new Vector3(x - tree.reach, y, z - tree.reach), new Vector3(x + tree.reach, y + tree.height, z + tree.reach));
      cell.box.union(own);
      cell.trees.push(index);
      cells.set(key, cell);
      this.box.union(own);
    });
    this.cells = [...cells.values()];
    for (const { mesh, members } of this.casters) {
      const kept = members.filter((index) => this.shown[index]);
      mesh.geometry.attributes.treeIndex.array.set(kept);
      mesh.geometry.attributes.treeIndex.needsUpdate = true;
      mesh.geometry.instanceCount = kept.length;
      mesh.visible = kept.length > 0;
    }
  }

  /** Draws the pictures of far trees of presets that are shown and have none. */
  drawFarViews(renderer) {
    this.farBatches.forEach(({ count }, preset) => {
      const { views } = this.standIns[preset];
      if (count === 0 || views.value) return;
      const index = this.usualTree(preset);
      const tree = this.trees[index];
      views.value = drawViews(renderer, this.models[tree.model], { index, place: tree.place, height: tree.height, radius: tree.reach }, this.barkUniforms, placingOf(this.isPlaced)).texture;
    });
  }

  /** Pictures are lost with the graphics context. */
  forgetFarViews() {
    this.standIns?.forEach(({ views }) => (views.value = null));
  }

  /** The tree of a preset with the median height. */
  usualTree(preset) {
    const own = this.trees.flatMap((tree, index) => (tree && this.models[tree.model].preset === preset ? [index] : []));
    own.sort((a, b) => this.trees[a].height - this.trees[b].height);
    return own[Math.floor(own.length / 2)];
  }

  /** Colors of trees, or null for the materials' colors. */
  paint(colorOf) {
    this.uniforms.treeTint.value = colorOf ? 1 : 0;
    if (colorOf) this.texture.setColors(colorOf, this.trees.length);
  }

  batchOf(tree, level) {
    const { model } = this.trees[tree];
    const own = this.batches[model];
    if (level < own.length) return own[level];
    return this.standIns ? this.farBatches[this.models[model].preset] : own.at(-1);
  }

  /**
   * Selects the trees to draw and their levels of detail.
   * @param {import("three").Frustum} frustum
   * @param {Vector3} eye
   * @param {number} pixelsPerRadian  CSS pixels of a small angle
   * @param {number} budget           triangles
   */
  update(frustum, eye, pixelsPerRadian, budget) {
    let count = 0;
    for (const cell of this.cells) {
      if (!frustum.intersectsBox(cell.box)) continue;
      for (const index of cell.trees) {
        const { place, height, reach } = this.trees[index];
        const extent = Math.max(height / 2, reach);
        sphere.center.set(place.x, place.y + height / 2, place.z);
        sphere.radius = Math.hypot(height / 2, reach);
        if (!frustum.intersectsSphere(sphere)) continue;
        const distance = Math.max(0.1, Math.hypot(place.x - eye.x, place.y + height / 2 - eye.y, place.z - eye.z) - extent / 2);
        this.inView[count] = index;
        this.pixels[count] = (height / distance) * pixelsPerRadian;
        count += 1;
      }
    }
    const levels = this.levelCount;
    const triangles = (position, level) => this.batchOf(this.inView[position], level).triangles;
    const factor = detailFactor(this.pixels, count, levels, triangles, budget);
    this.eachBatch((batch) => batch.begin());
    for (let position = 0; position < count; ++position) {
      this.batchOf(this.inView[position], levelFor(this.pixels[position] * factor, levels)).add(this.inView[position]);
    }
    this.eachBatch((batch) => batch.end());
    return { trees: count, factor };
  }

  eachBatch(use) {
    this.batches.forEach((levels) => levels.forEach(use));
    this.farBatches.forEach(use);
  }

  /** Number of trees drawn at each level; the last number is that of stand-ins. */
  treesByLevel() {
    const counts = Array(this.levelCount + 1).fill(0);
    this.batches.forEach((levels) => levels.forEach((batch, level) => (counts[level] += batch.count)));
    this.farBatches.forEach((batch) => (counts[this.levelCount] += batch.count));
    return counts;
  }

  dispose() {
    for (const mesh of this.group.children) mesh.geometry.dispose();
    for (const material of this.materials.values()) material.dispose();
    this.texture.texture.dispose();
  }
}
