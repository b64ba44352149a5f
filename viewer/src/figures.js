// SPDX-License-Identifier: MIT
// The charts of one species and response, each with a legend and the numbers behind it.
import { chartElement } from "./chart-view.js";
import { equalClasses, extent } from "./classes.js";
import { disclosure, element } from "./dom.js";
import { columnName, count, decimals, listing, plural, r2, responseName, significant } from "./format.js";
import { table } from "./table.js";

/** @typedef {import("./types.js").Result} Result */

const isNumber = (value) => value !== null;
const points = (observations, x, y, tip) =>
  x
    .map((value, index) => ({ x: value, y: y[index], tip: `plot ${observations.plot[index]}, tree ${observations.tree[index]}\n${tip(index)}` }))
    .filter((point) => isNumber(point.x) && isNumber(point.y));
const line = (kind, x, y) => ({ kind, values: x.map((value, index) => ({ x: value, y: y[index] })) });
const trend = (kind, classes) => ({ kind, values: classes.map(({ x, y }) => ({ x, y })) });
const hasNumbers = (column) => column.some(isNumber);

/** @param {Result} result */
export function figures(result) {
  const { observations } = result;
  if (observations.observed.length === 0) return [element("p", { class: "note" }, "There are no trees to draw.")];
  return [curveFigure(result), residualFigure(result), predictionFigure(result)];
}

function figure(title, charts, legend, note, ...behind) {
  const entries = legend.map(([kind, text]) => element("li", {}, element("span", { class: `key ${kind}`, "aria-hidden": "true" }), text));
  return element(
    "figure",
    {},
    element("figcaption", {}, element("h3", {}, title), element("ul", { class: "legend" }, ...entries), note ? element("p", { class: "small" }, note) : null),
    element("div", { class: charts.length > 1 ? "charts pair" : "charts" }, ...charts),
    disclosure("The numbers behind this chart", ...behind),
  );
}

/** A chart under its own small heading. */
const titled = (title, chart) => element("div", {}, element("h4", {}, title), chartElement(chart));

function shownTrees({ observations, n }) {
  const shown = observations.observed.length;
  return shown < n ? `${count(shown)} of ${plural(n, "tree")} are shown.` : `${plural(shown, "tree")}.`;
}

function heldAt(curves) {
  const held = Object.entries(curves.held_at).map(([column, value]) => `${columnName(column)} ${significant(value, 3)}${column === "h" ? " m" : ""}`);
  const means = held.length > 0 ? `${listing(held)} (means)` : "";
  const heights = curves.h ? "the height that the height model gives at each DBH" : "";
  const given = listing([means, heights].filter((text) => text !== ""));
  return given === "" ? "" : ` Curves for ${given}.`;
}

/** @param {Result} result */
function curveFigure(result) {
  const { observations, curves, unit } = result;
  const name = responseName(result.response);
  const lines = curves === null ? [] : curveLines(curves);
  const chart = {
    label: curveLabel(result),
    x: "DBH (cm)",
    y: `${name} (${unit})`,
    points: points(observations, observations.dbh, observations.observed, (index) => `DBH ${observations.dbh[index]} cm, ${observations.observed[index]} ${unit}`),
    lines,
    xDomain: extent(observations.dbh),
    yDomain: extent(observations.observed, ...lines.map(({ values }) => values.map(({ y }) => y))),
  };
  const drawn = (kind) => lines.some((one) => one.kind === kind);
  const legend = [
    ["point", "trees"],
    drawn("ols") ? ["ols", "OLS"] : null,
    drawn("nlme") ? ["nlme", "NLME, population"] : null,
    drawn("plot") ? ["plot", "NLME, each plot"] : null,
  ].filter((entry) => entry !== null);
  const behind = curves === null ? [] : [curveTable(result)];
  return figure(`${name} against DBH`, [chartElement(chart)], legend, shownTrees(result) + (curves === null ? "" : heldAt(curves)), ...behind);
}

function curveLines(curves) {
  return [
    ...Object.values(curves.plots).map((values) => line("plot", curves.dbh, values)),
    line("nlme", curves.dbh, curves.population),
    line("ols", curves.dbh, curves.ols),
  ].filter(({ values }) => values.some(({ y }) => isNumber(y)));
}

function curveLabel({ observations, response, unit, fits }) {
  const [least, greatest] = extent(observations.dbh).map((value) => decimals(value, 1));
  const [low, high] = extent(observations.observed).map((value) => decimals(value, 1));
  return (
    `Scatter chart of ${responseName(response).toLowerCase()}, ${low} to ${high} ${unit}, against DBH, ${least} to ${greatest} cm, ` +
    `with the fitted curves. R² of OLS ${r2(fits.ols?.statistics.population?.r2)}, of NLME conditional ${r2(fits.nlme?.statistics.conditional?.r2)}.`
  );
}

/** About a dozen points of the curves. */
function curveTable({ curves, unit }) {
  const step = Math.max(1, Math.ceil(curves.dbh.length / 12));
  const rows = curves.dbh.map((dbh, index) => ({ dbh, index })).filter(({ index }) => index % step === 0 || index === curves.dbh.length - 1);
  const at = (values) => (row) => decimals(values[row.index], 2);
  const columns = [
    { title: "DBH, cm", value: ({ dbh }) => decimals(dbh, 1) },
    ...(curves.h ? [{ title: "Height, m", value: at(curves.h) }] : []),
    { title: `OLS, ${unit}`, value: at(curves.ols) },
    { title: `NLME population, ${unit}`, value: at(curves.population) },
    ...Object.entries(curves.plots).map(([plot, values]) => ({ title: `Plot ${plot}, ${unit}`, value: at(values) })),
  ];
  return table("Curves", columns, rows);
}

const accuracyText = (accuracy, unit) => `R² ${r2(accuracy?.r2)}, RMSE ${decimals(accuracy?.rmse, 3)} ${unit}`;

/** The two fits that are compared side by side, without one that is not there. */
function sides({ observations, fits }) {
  return [
    { kind: "ols", name: "OLS", accuracy: fits.ols?.statistics.population, fitted: observations.ols, residual: observations.residual_ols },
    { kind: "nlme", name: "NLME, conditional", accuracy: fits.nlme?.statistics.conditional, fitted: observations.conditional, residual: observations.residual_nlme },
  ].filter(({ fitted }) => hasNumbers(fitted));
}

/** @param {Result} result */
function residualFigure(result) {
  const shown = sides(result).map((side) => ({ ...side, classes: equalClasses(side.fitted, side.residual) }));
  const xDomain = extent(...shown.map(({ fitted }) => fitted));
  const reach = Math.max(3, ...extent(...shown.map(({ residual }) => residual)).map(Math.abs));
  const guide = (kind, y) => line(kind, xDomain, [y, y]);
  const chart = (side) => ({
    label: `Standardized residuals of ${side.name} against fitted values; the table behind the chart gives them in classes.`,
    x: `Fitted (${result.unit})`,
    y: "Standardized residual",
    points: points(result.observations, side.fitted, side.residual, (index) => `fitted ${significant(side.fitted[index], 4)} ${result.unit}, residual ${decimals(side.residual[index], 2)}`),
    lines: [guide("guide", 0), guide("limit", -2), guide("limit", 2), trend(side.kind, side.classes)],
    xDomain,
    yDomain: [-reach, reach],
  });
  return figure(
    "Residuals against fitted values",
    shown.map((side) => titled(side.name, chart(side))),
    [["point", "trees"], ["limit", "two standard deviations"], ...shown.map(({ kind, name }) => [kind, `${name}: mean of trees in classes`])],
    "A good fit has no trend and the same spread everywhere.",
    ...shown.map((side) => classTable(`Residuals of ${side.name}, in classes of fitted values`, `Fitted, ${result.unit}`, "Mean residual", side.classes)),
  );
}

/** @param {Result} result */
function predictionFigure(result) {
  const { observations, unit } = result;
  const shown = sides(result);
  const domain = extent(observations.observed, ...shown.map(({ fitted }) => fitted));
  const chart = (side) => ({
    label: `Observed against predicted values of ${side.name}; the table behind the chart gives them in classes.`,
    x: `Predicted (${unit})`,
    y: `Observed (${unit})`,
    points: points(observations, side.fitted, observations.observed, (index) => `predicted ${significant(side.fitted[index], 4)} ${unit}, observed ${observations.observed[index]} ${unit}`),
    pointKind: side.kind,
    lines: [line("guide", domain, domain)],
    xDomain: domain,
    yDomain: domain,
  });
  return figure(
    "Observed against predicted",
    shown.map((side) => titled(`${side.name}: ${accuracyText(side.accuracy, unit)}`, chart(side))),
    [["guide", "observed = predicted"]],
    null,
    ...shown.map((side) => classTable(`Observed values in classes of what ${side.name} predicts`, `Predicted, ${unit}`, `Observed, ${unit}`, equalClasses(side.fitted, observations.observed))),
  );
}

function classTable(caption, x, y, classes) {
  const columns = [
    { title: x, value: (row) => decimals(row.x, 2) },
    { title: "Trees", value: ({ number }) => count(number) },
    { title: y, value: (row) => decimals(row.y, 3) },
    { title: "Standard deviation", value: ({ sd }) => decimals(sd, 3) },
  ];
  return table(caption, columns, classes);
}
