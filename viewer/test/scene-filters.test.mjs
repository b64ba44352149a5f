// SPDX-License-Identifier: MIT
// Trees that are shown, and the state of the view in an address.
import assert from "node:assert/strict";
import { test } from "node:test";
import { ALL, isNarrow, passesOf, residualsOf } from "../src/scene/filters.js";
import { fragmentOf, stateOf } from "../src/scene/link.js";

const data = { trees: { plot: [0, 0, 1, 1], species: [0, 1, 0, 1], layer: [0, 2, null, 1], h: [5, 20, null, 12] } };
const shown = (filter) => [0, 1, 2, 3].filter(passesOf(data, { ...ALL, ...filter }));

test("trees are shown by plot, species, layer and height", () => {
  assert.deepEqual(shown({}), [0, 1, 2, 3]);
  assert.deepEqual(shown({ plot: 1 }), [2, 3]);
  assert.deepEqual(shown({ species: 0 }), [0, 2]);
  assert.deepEqual(shown({ layer: 2 }), [1]);
  assert.deepEqual(shown({ least: 12 }), [1, 3]);
  assert.deepEqual(shown({ most: 12 }), [0, 3]);
  assert.deepEqual(shown({ species: 1, least: 10, most: 15 }), [3]);
  assert.deepEqual(shown({ plot: 0, layer: 1 }), []);
  assert.equal(isNarrow({ ...ALL, plot: 1 }), false);
  assert.equal(isNarrow({ ...ALL, least: 0 }), true);
});

test("trees are shown by a residual, observed minus predicted", () => {
  const observed = { name: "observed", title: "Observed", h: data.trees.h };
  const ols = { name: "ols", title: "OLS", h: [6, 17, 9, null], hcb: [null, null, null, null], cw: [null, null, null, null] };
  const own = { trees: { ...data.trees, hcb: [null, null, null, null], cw: [null, null, null, null] }, variants: [observed, ols] };
  assert.deepEqual(residualsOf(own).map(({ text }) => text), ["height, OLS"]);
  const shownBy = (filter) => [0, 1, 2, 3].filter(passesOf(own, { ...ALL, ...filter }));
  // The residuals are -1 and 3; two trees have none.
  assert.deepEqual(shownBy({ residual: 0 }), [0, 1, 2, 3]);
  assert.deepEqual(shownBy({ residual: 0, lowest: 0 }), [1]);
  assert.deepEqual(shownBy({ residual: 0, highest: -1 }), [0]);
  assert.deepEqual(shownBy({ residual: 0, lowest: -5, highest: 5 }), [0, 1]);
  assert.deepEqual(shownBy({ lowest: 0 }), [0, 1, 2, 3]);
  assert.equal(isNarrow({ ...ALL, residual: 0 }), false);
  assert.equal(isNarrow({ ...ALL, residual: 0, highest: 1 }), true);
});

test("a link has the whole state", () => {
  const state = { camera: [1.25, -3, 40.123], target: [0, 8.5, 0], isWalking: true, color: "residual:h", filter: { ...ALL, plot: 0, species: 3, most: 17.5, residual: 2, lowest: -0.5 } };
  const fragment = fragmentOf(state);
  assert.ok(fragment.startsWith("#camera=1.25,-3,40.123&target=0,8.5,0"), fragment);
  assert.deepEqual(stateOf(fragment), state);
});

test("what a fragment does not say, or says wrongly, is null", () => {
  const nothing = { camera: null, target: null, isWalking: false, color: null, filter: ALL };
  assert.deepEqual(stateOf(""), nothing);
  assert.deepEqual(stateOf("#camera=1,2&target=a,b,c&plot=x&least="), nothing);
  assert.deepEqual(stateOf("#somewhere"), nothing);
});
