// SPDX-License-Identifier: MIT
// The sizes of all trees of a variant as a texture for vertex shaders; layout in shape.js.
import { DataTexture, FloatType, NearestFilter, RGBAFormat } from "three";
import { TEXEL, TEXELS, TREES_PER_ROW, turnOf } from "./shape.js";

export class TreeTexture {
  constructor(count) {
    const rows = Math.max(1, Math.ceil(count / TREES_PER_ROW));
    this.values = new Float32Array(TREES_PER_ROW * TEXELS * rows * 4);
    this.texture = new DataTexture(this.values, TREES_PER_ROW * TEXELS, rows, RGBAFormat, FloatType);
    this.texture.minFilter = this.texture.magFilter = NearestFilter;
    this.texture.needsUpdate = true;
  }

  set(tree, texel, values) {
    this.values.set(values, 4 * (TEXELS * tree + texel));
  }

  setSizes(tree, place, crown, girth, dbh) {
    this.set(tree, TEXEL.place, [place.x, place.y, place.z, girth]);
    this.set(tree, TEXEL.heights, [crown.h, crown.hcb, crown.hc, turnOf(tree)]);
    this.set(tree, TEXEL.radii, [crown.east, crown.west, crown.south, crown.north]);
    this.set(tree, TEXEL.color, [1, 1, 1, dbh / 200]);
  }

  /** @param {import("three").Matrix4} matrix */
  setMatrix(tree, { elements }) {
    for (let row = 0; row < 3; ++row) this.set(tree, TEXEL.matrix + row, [0, 4, 8, 12].map((column) => elements[column + row]));
  }

  /** Linear RGB of each tree. */
  setColors(colorOf, count) {
    for (let tree = 0; tree < count; ++tree) this.values.set(colorOf(tree), 4 * (TEXELS * tree + TEXEL.color));
    this.texture.needsUpdate = true;
  }
}
