// SPDX-License-Identifier: MIT
// The variogram of the residuals: do neighboring trees deviate alike?
import { extent } from "./classes.js";
import { figure, titled } from "./figure.js";
import { count, decimals, plural } from "./format.js";
import { lineLayer, pointLayer } from "./observations.js";
import { numeric, table } from "./table.js";

const three = (value) => decimals(value, 3);

/** @param {Result} result */
export function variogramFigure({ variogram = [] }) {
  if (variogram.length < 2) return null;
  const pairs = variogram.reduce((sum, one) => sum + one.pairs, 0);
  const mean = variogram.reduce((sum, one) => sum + one.pairs * one.semivariance, 0) / pairs;
  const reach = [0, Math.max(...variogram.map(({ distance }) => distance)) * 1.05];
  const values = variogram.map((one) => ({ x: one.distance, y: one.semivariance, tip: `${decimals(one.distance, 1)} m: ${three(one.semivariance)}, ${plural(one.pairs, "pair")}` }));
  const chart = {
    label: `Semivariance of the standardized residuals in ${variogram.length} classes of distance; the table behind the chart has the numbers.`,
    x: { title: "Distance between trees (m)", domain: reach },
    y: { title: "Semivariance", domain: extent([0, mean], values.map(({ y }) => y)) },
    layers: [lineLayer("guide", reach, [mean, mean]), lineLayer("nlme", values.map(({ x }) => x), values.map(({ y }) => y), { thin: true }), pointLayer("nlme", values)],
  };
  const columns = [
    numeric("Distance, m", ({ distance }) => distance, (value) => decimals(value, 2)),
    numeric("Semivariance", ({ semivariance }) => semivariance, three),
    numeric("Pairs", (one) => one.pairs, count),
  ];
  return figure({
    title: "Variogram of standardized residuals",
    legend: [["nlme", "half the mean squared difference of two trees of a plot"], ["guide", "mean of all pairs"]],
    note: "Independent residuals have no trend. Where near trees are below the mean they deviate alike, and the model needs a correlation by distance.",
    charts: [titled("Chosen model", chart)],
    behind: () => [table("Variogram of standardized residuals", columns, variogram)],
  });
}
