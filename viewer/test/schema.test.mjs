// SPDX-License-Identifier: MIT
// The example obeys the schema of the report data, and the schema refuses what it should.
import assert from "node:assert/strict";
import { test } from "node:test";
import { comparison, example, schemaErrors } from "./template.mjs";

test("the example obeys the schema", () => {
  assert.deepEqual(schemaErrors(example()), []);
});

test("a study without positions and without mixed models obeys it as well", () => {
  const data = example();
  const result = data.results[0];
  Object.assign(result, { covariates: [], random: [], variance: [], curves: null, converged: false });
  Object.assign(result.fits, { covariates: null, nlme: null });
  Object.assign(result.gain, { population: null, conditional: null });
  data.inventory.species.forEach((species) => (species.core = null));
  assert.deepEqual(schemaErrors(data), []);
});

test("a comparison obeys its own schema, which refuses a difference without its reason", () => {
  const data = comparison();
  assert.deepEqual(schemaErrors(data), []);
  delete data.pairs[0].differences[0].reason;
  assert.notDeepEqual(schemaErrors(data), []);
});

test("standard errors of random effects may be there", () => {
  const data = example();
  data.results[0].fits.nlme.random[0].eblup_se = { 1: { a: 0.4, b: null } };
  assert.deepEqual(schemaErrors(data), []);
  data.results[0].fits.nlme.random[0].eblup_se = { 1: { a: "0.4" } };
  assert.notDeepEqual(schemaErrors(data), []);
});

test("a missing or misspelled member, and a number as text, are refused", () => {
  const change = (edit) => {
    const data = example();
    edit(data);
    return schemaErrors(data);
  };
  assert.notDeepEqual(change((data) => delete data.results[0].verdict), []);
  assert.notDeepEqual(change((data) => (data.results[0].base[0].log_likelihod = -1)), []);
  assert.notDeepEqual(change((data) => (data.results[0].base[0].aic = "6576.2")), []);
  assert.notDeepEqual(change((data) => (data.results[0].variance[0].function = 3)), []);
});
