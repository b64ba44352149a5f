// SPDX-License-Identifier: MIT
// The trees of a result as points of charts.
import { count, plural } from "./format.js";

export const isNumber = (value) => value !== null && value !== undefined;

/** Pairs of numbers with the name of their tree; pairs with a missing number are skipped. */
export const points = (observations, x, y, tip) =>
  x
    .map((value, index) => ({ x: value, y: y[index], index }))
    .filter((point) => isNumber(point.x) && isNumber(point.y))
    .map(({ index, ...point }) => ({ ...point, tip: `plot ${observations.plot[index]}, tree ${observations.tree[index]}: ${tip(index)}` }));

export const pointLayer = (kind, values) => ({ mark: "points", kind, values });
export const lineLayer = (kind, x, y, more = {}) => ({ mark: "line", kind, values: x.map((value, index) => ({ x: value, y: y[index] })), ...more });
export const hasValues = ({ values }) => values.some(({ y }) => isNumber(y));

/** A note if not all trees are shown: "4 000 of 9 000 trees are shown, every second or third". */
export function shownTrees({ observations, n }) {
  const shown = observations.observed.length;
  return shown < n ? `A sample of ${count(shown)} of ${plural(n, "tree")} is shown.` : `${plural(shown, "tree")}.`;
}

/** The two compared fits, without a missing one. */
export function sides({ observations, fits }) {
  return [
    { kind: "ols", name: "OLS", accuracy: fits.ols?.statistics.population, fitted: observations.ols, residual: observations.residual_ols },
    { kind: "nlme", name: "NLME, conditional", accuracy: fits.nlme?.statistics.conditional, fitted: observations.conditional, residual: observations.residual_nlme },
  ].filter(({ fitted }) => fitted.some(isNumber));
}

/** About a dozen points of a grid. */
export function gridRows(dbh) {
  const step = Math.max(1, Math.ceil(dbh.length / 12));
  return dbh.map((value, index) => ({ dbh: value, index })).filter(({ index }) => index % step === 0 || index === dbh.length - 1);
}
