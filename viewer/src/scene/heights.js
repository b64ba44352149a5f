// SPDX-License-Identifier: MIT
// Height of a surface at a position: its triangles, found by a horizontal grid.
import { Matrix4, Vector3 } from "three";

/** A triangle is listed in every cell that it overlaps; above this mean number per triangle, cells become larger. */
const MOST_CELLS_OF_A_TRIANGLE = 8;

/** Corners of all triangles in the page's frame, nine numbers each. */
function trianglesOf(surface) {
  const numbers = [];
  const corner = new Vector3();
  const own = new Matrix4();
  surface.updateWorldMatrix(true, true);
  surface.traverse((object) => {
    if (!object.isMesh) return;
    const { index, attributes } = object.geometry;
    const corners = index?.count ?? attributes.position.count;
    for (let copy = 0; copy < (object.isInstancedMesh ? object.count : 1); ++copy) {
      if (object.isInstancedMesh) object.getMatrixAt(copy, own);
      else own.identity();
      own.premultiply(object.matrixWorld);
      for (let at = 0; at + 2 < corners; at += 3) {
        for (let k = at; k < at + 3; ++k) {
          corner.fromBufferAttribute(attributes.position, index ? index.getX(k) : k).applyMatrix4(own);
          numbers.push(corner.x, corner.y, corner.z);
        }
      }
    }
  });
  return Float64Array.from(numbers);
}

/** Height of a triangle at a position, or null outside it and if it is vertical. */
function heightOf(numbers, at, x, z) {
  const [ax, ay, az] = [numbers[at], numbers[at + 1], numbers[at + 2]];
  const [bx, by, bz] = [numbers[at + 3] - ax, numbers[at + 4] - ay, numbers[at + 5] - az];
  const [cx, cy, cz] = [numbers[at + 6] - ax, numbers[at + 7] - ay, numbers[at + 8] - az];
  const area = bx * cz - bz * cx;
  if (area === 0) return null;
  const second = ((x - ax) * cz - (z - az) * cx) / area;
  const third = ((z - az) * bx - (x - ax) * bz) / area;
  // Positions on an edge belong to both triangles; the tolerance covers rounding.
  const slack = 1e-9;
  return second >= -slack && third >= -slack && second + third <= 1 + slack ? ay + second * by + third * cy : null;
}

export class Heights {
  /** @param {import("three").Object3D} surface  with meshes of triangles */
  constructor(surface) {
    this.numbers = trianglesOf(surface);
    const count = this.numbers.length / 9;
    this.measure(count);
    let share = 1;
    do {
      this.layCells(count * share);
      share /= 2;
    } while (this.entries() > MOST_CELLS_OF_A_TRIANGLE * count && this.columns * this.rows > 1);
    this.fill(count);
  }

  measure(count) {
    const { numbers } = this;
    this.least = [Infinity, Infinity];
    this.most = [-Infinity, -Infinity];
    for (let corner = 0; corner < 3 * count; ++corner) {
      [numbers[3 * corner], numbers[3 * corner + 2]].forEach((value, axis) => {
        this.least[axis] = Math.min(this.least[axis], value);
        this.most[axis] = Math.max(this.most[axis], value);
      });
    }
  }

  /** About the requested number of cells, nearly square. */
  layCells(wanted) {
    const [width, depth] = [0, 1].map((axis) => Math.max(1e-6, this.most[axis] - this.least[axis]));
    const side = Math.sqrt((width * depth) / Math.max(1, wanted));
    const along = (length) => (Number.isFinite(length) ? Math.min(4096, Math.max(1, Math.ceil(length / side))) : 1);
    this.columns = along(width);
    this.rows = along(depth);
    this.perCell = [this.columns / width, this.rows / depth];
  }

  column(x) {
    return Math.min(this.columns - 1, Math.max(0, Math.floor((x - this.least[0]) * this.perCell[0])));
  }

  row(z) {
    return Math.min(this.rows - 1, Math.max(0, Math.floor((z - this.least[1]) * this.perCell[1])));
  }

  /** Columns and rows of a triangle's box: [first, last, first, last]. */
  span(triangle) {
    const at = 9 * triangle;
    const { numbers } = this;
    const [a, b, c] = [numbers[at], numbers[at + 3], numbers[at + 6]];
    const [d, e, f] = [numbers[at + 2], numbers[at + 5], numbers[at + 8]];
    return [this.column(Math.min(a, b, c)), this.column(Math.max(a, b, c)), this.row(Math.min(d, e, f)), this.row(Math.max(d, e, f))];
  }

  entries() {
    let sum = 0;
    for (let triangle = 0; triangle < this.numbers.length / 9; ++triangle) {
      const [left, right, top, bottom] = this.span(triangle);
      sum += (right - left + 1) * (bottom - top + 1);
    }
    return sum;
  }

  /** Lists the triangles of each cell one after the other; `starts` has the start of each list. */
  fill(count) {
    this.starts = new Uint32Array(this.columns * this.rows + 1);
    this.eachCell(count, (cell) => (this.starts[cell + 1] += 1));
    for (let cell = 0; cell + 1 < this.starts.length; ++cell) this.starts[cell + 1] += this.starts[cell];
    this.listed = new Uint32Array(this.starts.at(-1));
    const next = this.starts.slice();
    this.eachCell(count, (cell, triangle) => (this.listed[next[cell]++] = triangle));
  }

  eachCell(count, use) {
    for (let triangle = 0; triangle < count; ++triangle) {
      const [left, right, top, bottom] = this.span(triangle);
      for (let row = top; row <= bottom; ++row) {
        for (let column = left; column <= right; ++column) use(row * this.columns + column, triangle);
      }
    }
  }

  /** @returns {number | null}  the highest triangle's height at a position, or null if there is none [m] */
  at(x, z) {
    if (!(x >= this.least[0] - 1e-6 && x <= this.most[0] + 1e-6 && z >= this.least[1] - 1e-6 && z <= this.most[1] + 1e-6)) return null;
    const cell = this.row(z) * this.columns + this.column(x);
    let highest = null;
    for (let entry = this.starts[cell]; entry < this.starts[cell + 1]; ++entry) {
      const height = heightOf(this.numbers, 9 * this.listed[entry], x, z);
      if (height !== null && (highest === null || height > highest)) highest = height;
    }
    return highest;
  }
}
