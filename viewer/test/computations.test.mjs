// SPDX-License-Identifier: MIT
// What the page computes by itself, against textbook values.
import assert from "node:assert/strict";
import { test } from "node:test";
import { apart } from "../src/chart-spec.js";
import { quantileSorted as quantile } from "d3-array";
import { boxClasses, classWidth, drawnAlone } from "../src/classes.js";
import { rectangleOf, wayAround } from "../src/torus.js";

test("quantiles are those of R's default (type 7)", () => {
  // quantile(c(1, 2, 4, 8, 16), c(0.1, 0.25, 0.9)) of R: 1.4, 2, 12.8
  const values = [1, 2, 4, 8, 16];
  [[0.1, 1.4], [0.25, 2], [0.9, 12.8], [1, 16]].forEach(([share, expected]) => assert.ok(Math.abs(quantile(values, share) - expected) < 1e-12));
});

test("whiskers end at trees within 1.5 quartile ranges, those beyond are listed", () => {
  // Of 1, ..., 9 and 40: quartiles 3.25 and 7.75, so whiskers may reach 14.5.
  const y = [1, 2, 3, 4, 5, 6, 7, 8, 9, 40];
  const [box] = boxClasses(y.map(() => 3), y, 2);
  assert.deepEqual([box.from, box.to, box.number, box.low, box.q1, box.median, box.q3, box.high], [2, 4, 10, 1, 3.25, 5.5, 7.75, 9]);
  assert.deepEqual(box.outliers, [40]);
});

test("a class of fewer than five trees shows its trees, a larger one those beyond the whiskers", () => {
  const classes = boxClasses([1, 1, 3, 3, 3, 5, 5, 5, 5, 7, 7, 7, 7, 7, 7], [0, 10, -1, 0, 8, -4, 0, 2, 9, 1, 2, 3, 4, 5, 40], 2);
  // Of 1, ..., 5 and 40: quartiles 2.25 and 4.75, so whiskers may reach 8.5.
  assert.deepEqual(classes.map(drawnAlone), [[0, 10], [-1, 0, 8], [-4, 0, 2, 9], [40]]);
});

test("on a torus the way to a neighbor is the shortest, and cut at the borders that it crosses", () => {
  const rectangle = rectangleOf([[[10, 0], [30, 0], [30, 10], [10, 10]]]);
  const ways = (from, to) => wayAround(rectangle, from, to).map((piece) => piece.map((end) => end.map((value) => Number(value.toFixed(9)))));
  assert.deepEqual(ways([12, 5], [18, 6]), [[[12, 5], [18, 6]]]);
  assert.deepEqual(ways([11, 5], [29, 5]), [[[11, 5], [10, 5]], [[30, 5], [29, 5]]]);
  assert.deepEqual(ways([29, 9], [13, 1]), [[[29, 9], [30, 9.5]], [[10, 9.5], [11, 10]], [[11, 0], [13, 1]]]);
  // From a tree on the border.
  assert.deepEqual(ways([30, 5], [11, 5]), [[[10, 5], [11, 5]]]);
});

test("a tree on a limit belongs to the class above, and missing values to none", () => {
  const classes = boxClasses([1.9, 2, 3.9, 4, null, 5], [0, 0, 0, 0, 0, null], 2);
  assert.deepEqual(classes.map(({ from, number }) => [from, number]), [[0, 1], [2, 2], [4, 1]]);
});

test("classes are 2 wide unless that gives too few or too many", () => {
  assert.equal(classWidth([1.3, 24]), 2);
  assert.equal(classWidth([0.4, 3.1]), 0.2);
  assert.equal(classWidth([0, 90]), 10);
});

test("labels keep their order and their distance, and stay under the top", () => {
  const moved = apart([{ y: 9.9 }, { y: 5 }, { y: 9.8 }], 1, 10).map(({ y }) => y);
  assert.deepEqual(moved, [5, 9, 10]);
});
