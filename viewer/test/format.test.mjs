// SPDX-License-Identifier: MIT
// Numbers and classes as the page shows them.
import assert from "node:assert/strict";
import { test } from "node:test";
import { equalClasses, extent } from "../src/classes.js";
import { decimals, inUnit, listing, MISSING, points, probability, responseInText, significant, withMinusSigns } from "../src/format.js";
import { comparison } from "../src/sort.js";
import { byRank } from "../src/table.js";

test("a missing number is a dash, never NaN or null", () => {
  for (const format of [(x) => decimals(x, 2), significant, probability, points]) {
    for (const value of [null, undefined, NaN, Infinity]) assert.equal(format(value), MISSING);
  }
});

test("digits are kept where they mean something", () => {
  assert.equal(significant(39.6071768), "39.607");
  assert.equal(significant(-0.00728364743), "\u22120.0072836");
  assert.equal(significant(7.51e-5, 3), "7.51e\u22125");
  assert.equal(significant(4.5e-81, 3), "4.50e\u221281");
  assert.equal(decimals(-0.5, 2), "\u22120.50");
  assert.equal(points(-10.4), "\u221210.40");
  assert.equal(significant(0), "0");
  assert.equal(decimals(-0.0001, 2), "0.00");
  assert.equal(probability(2e-16), "< 0.001");
  assert.equal(probability(0.0496), "0.050");
  assert.equal(points(10.4), "+10.40");
});

test("sentences of the program get the page's minus sign, options and ranges do not", () => {
  assert.equal(withMinusSigns("a correlation of -1 (-0.5), b=-2, 6e-07 errors"), "a correlation of \u22121 (\u22120.5), b=\u22122, 6e\u221207 errors");
  assert.equal(withMinusSigns("try --covariance diagonal, 10-20 m, model-2"), "try --covariance diagonal, 10-20 m, model-2");
});

test("rows compare by number or by text, and what is missing comes last both ways", () => {
  const order = (values, isText, sign) => {
    const compare = comparison(values, isText);
    return values.map((_, index) => index).sort((a, b) => compare(a, b, sign));
  };
  assert.deepEqual(order([10, null, -2, 9], false, 1), [2, 3, 0, 1]);
  assert.deepEqual(order([10, null, -2, 9], false, -1), [0, 3, 2, 1]);
  assert.deepEqual(order(["b: \u22120.0045***", "b: 0.2", ""], false, 1), [0, 1, 2]);
  assert.deepEqual(order(["M10", "M2", ""], true, 1), [1, 0, 2]);
});

test("lists read as sentences", () => {
  assert.equal(listing([]), "");
  assert.equal(listing(["a"]), "a");
  assert.equal(listing(["a", "b", "c"]), "a, b and c");
});

test("classes hold every tree once, in order, and skip missing numbers", () => {
  const x = Array.from({ length: 103 }, (_, index) => (index * 37) % 103);
  const y = x.map((value) => 2 * value);
  x.push(null);
  y.push(5);
  const classes = equalClasses(x, y);
  assert.equal(classes.length, 10);
  assert.equal(classes.reduce((sum, { number }) => sum + number, 0), 103);
  classes.forEach((one) => assert.ok(Math.abs(one.y - 2 * one.x) < 1e-12));
  assert.deepEqual(equalClasses([], []), []);
  assert.deepEqual(equalClasses([1], [3]), [{ number: 1, x: 1, y: 3, sd: null }]);
});

test("an extent is finite whatever is missing", () => {
  assert.deepEqual(extent([3, null, -1], [7]), [-1, 7]);
  assert.deepEqual(extent([null], []), [0, 1]);
});

test("the best candidate comes first and those without a rank last", () => {
  const rows = [{ rank: null }, { rank: 2 }, { rank: 1 }];
  assert.deepEqual(byRank(rows).map(({ rank }) => rank), [1, 2, null]);
});

test("a name without a unit has no comma, and columns keep their capitals", () => {
  assert.equal(inUnit("RMSE", "m"), "RMSE, m");
  assert.equal(inUnit("RMSE", ""), "RMSE");
  assert.equal(responseInText("hcb"), "height to crown base");
  assert.equal(responseInText("V_m3"), "V_m3");
});
