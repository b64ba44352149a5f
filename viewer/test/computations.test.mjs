// SPDX-License-Identifier: MIT
// What the page computes by itself, against textbook values.
import assert from "node:assert/strict";
import { test } from "node:test";
import { apart } from "../src/chart-spec.js";
import { boxClasses, classWidth, quantile } from "../src/classes.js";

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
