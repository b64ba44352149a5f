// SPDX-License-Identifier: MIT
// Marks on the trees: crown curves, overlaps of crowns, the selected tree.
import { overlappingPairs } from "./crown.js";
import { crownLineMaterial, crownLines, footMaterial, footRing, overlapMaterial, overlapMesh } from "./crown-lines.js";

/** In stands with more overlapping pairs, those nearest to the center of the view are shown. */
const MOST_OVERLAPS = 1500;

export class Marks {
  /**
   * @param {import("./view.js").View} view
   * @param {(name: string) => string} color  of the theme, such as --pick
   */
  constructor(data, view, color) {
    this.data = data;
    this.view = view;
    this.color = color;
    this.crowns = false;
    this.overlaps = false;
    this.materials = new Map();
  }

  /**
   * Redraws them on all sides.
   * @param {number | null} chosen  the chosen tree
   * @param {() => {x: number, z: number}} middle  of the picture
   * @returns {string[]}  the notes on overlaps, one sentence per side
   */
  draw(chosen, middle) {
    const { view } = this;
    for (const mark of view.marks) {
      view.scene.remove(mark);
      mark.geometry.dispose();
    }
    this.forgetOldSides();
    const sentences = [];
    view.marks = view.sides.flatMap((side) => this.marksOf(side, chosen, middle, sentences));
    for (const mark of view.marks) view.scene.add(mark);
    return sentences;
  }

  /** Materials of a side are reused: a new one would be compiled, which takes a second without a graphics card. */
  materialOf(side, use, color, make) {
    if (!this.materials.has(side)) this.materials.set(side, new Map());
    const own = this.materials.get(side);
    if (!own.has(use)) own.set(use, make());
    own.get(use).color.set(this.color(color));
    return own.get(use);
  }

  forgetOldSides() {
    for (const [side, own] of this.materials) {
      if (this.view.sides.includes(side)) continue;
      for (const material of own.values()) material.dispose();
      this.materials.delete(side);
    }
  }

  marksOf(side, chosen, middle, sentences) {
    const { data } = this;
    const material = (use, color, make) => this.materialOf(side, use, color, make);
    const shown = side.bodies.flatMap((body, tree) => (body && side.stand.shown[tree] ? [tree] : []));
    const marks = [];
    if (this.crowns) marks.push(...crownLines(data, side, shown, material("crowns", "--line", () => crownLineMaterial(side, false))));
    if (this.overlaps) {
      const { pairs, sentence } = this.overlapsOf(side, middle);
      marks.push(overlapMesh(side, pairs, material("overlaps", "--overlap", overlapMaterial)));
      sentences.push(sentence);
    }
    if (chosen !== null && side.bodies[chosen] && side.stand.shown[chosen]) {
      const lines = material("chosen", "--pick", () => crownLineMaterial(side, true));
      marks.push(...crownLines(data, side, [chosen], lines), footRing(side, chosen, material("foot", "--pick", footMaterial)));
    }
    return marks;
  }

  overlapsOf(side, middle) {
    const { x, z } = middle();
    const pairs = overlappingPairs(side.bodies.map((body, tree) => (body && side.stand.shown[tree] ? body : null)));
    const away = side.bodies.map((body) => (body ? Math.hypot(body.place.x - x, body.place.z - z) : Infinity));
    const near = pairs.length > MOST_OVERLAPS ? pairs.sort((a, b) => away[a.first] - away[b.first]).slice(0, MOST_OVERLAPS) : pairs;
    const whose = this.view.sides.length > 1 ? `${side.variant.title}: ` : "";
    const count = pairs.length === 1 ? "1 pair of crowns overlaps" : `${pairs.length} pairs of crowns overlap`;
    const shown = near.length < pairs.length ? `the ${near.length} nearest to the center of the view are shown.` : "their overlap is shown.";
    return { pairs: near, sentence: `${whose}${count}; ${shown}` };
  }
}
