// SPDX-License-Identifier: MIT
// The response against DBH: the trees, the curves of both methods, and the curves for classes of each covariate.
import { chartElement } from "./chart-view.js";
import { extent } from "./classes.js";
import { figure, titled } from "./figure.js";
import { capital, columnName, decimals, listing, plural, r2, responseName, significant } from "./format.js";
import { gridRows, hasValues, isNumber, lineLayer, pointLayer, points, shownTrees } from "./observations.js";
import { numeric, table } from "./table.js";

const ORDINALS = ["first", "second", "third", "fourth", "fifth"];
/** A class with fewer trees is drawn thin, because its curve depends mostly on the form of the equation. */
const FEW_TREES = 5;

const unitOf = (column) => ({ h: " m", dbh: " cm" })[column] ?? "";
const holding = (held) => Object.entries(held).map(([column, value]) => `${columnName(column)} ${significant(value, 3)}${unitOf(column)}`);

function heldAt(curves, except) {
  const others = Object.fromEntries(Object.entries(curves.held_at).filter(([column]) => column !== except));
  const means = holding(others);
  const parts = [means.length > 0 ? `${listing(means)} (${means.length > 1 ? "means" : "mean"})` : "", curves.h ? "the height that the height model gives at each DBH" : ""].filter((text) => text !== "");
  return parts.length === 0 ? "" : `Curves for ${listing(parts)}.`;
}

const tipOf = ({ observations, unit }) => (index) => `DBH ${observations.dbh[index]} cm, ${observations.observed[index]} ${unit}`;

const axes = ({ observations, curves, response, unit }, layers) => ({
  x: { title: "DBH (cm)", domain: extent(observations.dbh, curves?.dbh ?? []) },
  y: { title: `${responseName(response)} (${unit})`, domain: extent(observations.observed, ...layers.filter(({ mark }) => mark === "line").map(({ values }) => values.map(({ y }) => y))) },
});

function lastLabel(layer, text) {
  const last = [...layer.values].reverse().find(({ y }) => isNumber(y));
  return { ...last, text, kind: layer.kind };
}

/** @param {Result} result */
export function curveFigure(result) {
  const { observations, curves } = result;
  const lines = curves === null ? [] : curveLines(result);
  const bands = curves === null ? [] : curveBands(curves);
  const named = lines.filter(({ kind }) => kind !== "plot");
  const labels = named.map((layer) => lastLabel(layer, layer.kind.toUpperCase()));
  const trees = pointLayer("point", points(observations, observations.dbh, observations.observed, tipOf(result)));
  const chart = {
    label: curveLabel(result),
    ...axes(result, lines),
    layers: [trees, ...bands, ...lines, { mark: "labels", kind: "nlme", values: labels }],
    labelSpace: labels.length > 0 ? 42 : 0,
  };
  const drawn = (kind) => lines.some((one) => one.kind === kind);
  const legend = [
    ["point", "trees"],
    drawn("ols") ? ["ols", "OLS"] : null,
    drawn("nlme") ? ["nlme", "NLME, population (b = 0)"] : null,
    drawn("plot") ? ["plot", "NLME, each plot (conditional)"] : null,
    ...bands.map(({ kind }) => [`shade ${kind}`, `95 % confidence band, ${kind.toUpperCase()}`]),
  ].filter((entry) => entry !== null);
  return figure({
    title: `${responseName(result.response)} against DBH`,
    legend,
    note: `${shownTrees(result)} ${curves === null ? "" : heldAt(curves)}`.trim(),
    charts: [chartElement(chart)],
    behind: () => (curves === null ? [treeTable(result)] : [curveTable(result)]),
  });
}

function curveLines({ curves, unit }) {
  const told = (layer, name) => ({ ...layer, values: layer.values.map((datum) => (isNumber(datum.y) ? { ...datum, tip: `${name}: ${decimals(datum.y, 2)} ${unit} at DBH ${decimals(datum.x, 1)} cm` } : datum)) });
  return [
    ...Object.entries(curves.plots).map(([plot, values]) => told(lineLayer("plot", curves.dbh, values), `Plot ${plot}`)),
    told(lineLayer("nlme", curves.dbh, curves.population), "NLME, population"),
    told(lineLayer("ols", curves.dbh, curves.ols), "OLS"),
  ].filter(hasValues);
}

/** Confidence bands of the mean; data of earlier versions have none. */
function curveBands({ dbh, ols_band: ols, population_band: population }) {
  const band = (kind, ends) => ({ mark: "band", kind, values: dbh.map((x, index) => ({ x, low: ends?.low[index], high: ends?.high[index] })).filter(({ low, high }) => isNumber(low) && isNumber(high)) });
  return [band("ols", ols), band("nlme", population)].filter(({ values }) => values.length > 0);
}

function curveLabel({ observations, response, unit, fits }) {
  const [least, greatest] = extent(observations.dbh).map((value) => decimals(value, 1));
  const [low, high] = extent(observations.observed).map((value) => decimals(value, 1));
  return (
    `Scatter chart of ${responseName(response).toLowerCase()}, ${low} to ${high} ${unit}, against DBH, ${least} to ${greatest} cm, ` +
    `with the fitted curves. R² of OLS ${r2(fits.ols?.statistics.population?.r2)}, of NLME conditional ${r2(fits.nlme?.statistics.conditional?.r2)}.`
  );
}

const short = (value) => decimals(value, 2);
const DBH = numeric("DBH, cm", ({ dbh }) => dbh, (value) => decimals(value, 1));
const along = (title, values) => numeric(title, ({ index }) => values[index], short);

/** Columns of the ends of a confidence band, if there is one. */
const ends = (name, band) => (band?.low.length > 0 ? [along(`${name}, 95 % from`, band.low), along(`${name}, 95 % to`, band.high)] : []);

function curveTable({ curves, unit }) {
  const columns = [
    DBH,
    ...(curves.h ? [along("Height, m", curves.h)] : []),
    along(`OLS, ${unit}`, curves.ols),
    ...ends("OLS", curves.ols_band),
    along(`NLME population, ${unit}`, curves.population),
    ...ends("NLME", curves.population_band),
    ...Object.entries(curves.plots).map(([plot, values]) => along(`Plot ${plot}, ${unit}`, values)),
  ];
  return table("Curves", columns, gridRows(curves.dbh));
}

function treeTable({ observations, unit }) {
  const rows = observations.dbh.map((dbh, index) => ({ dbh, index }));
  return table("Trees", [DBH, along(`Observed, ${unit}`, observations.observed)], rows);
}

/** @param {Result} result  one figure for all covariates of the chosen model, or null without any */
export function classFigure(result) {
  const byClass = result.curves?.by_class ?? [];
  if (byClass.length === 0) return null;
  const hasOls = byClass.some((one) => one.covariates.some((values) => values.some(isNumber)) && one.population.some((values) => values.some(isNumber)));
  const few = byClass.some(({ trees }) => trees.some((number) => number < FEW_TREES));
  return figure({
    title: `Curves by classes of ${listing(byClass.map(({ covariate }) => columnName(covariate)))}`,
    legend: [["plot strong", "NLME, population"], ...(hasOls ? [["limit", "OLS with covariates"]] : [])],
    note:
      "Each tree has the color of the class that it is nearest to; the other covariates are at their means." +
      (few ? ` Thin curves: classes with fewer than ${FEW_TREES} trees, where the curve extrapolates.` : ""),
    charts: byClass.map((one) => titled(classTitle(one), classChart(result, one))),
    behind: () => byClass.map((one) => classTable(result, one)),
  });
}

function classTitle({ covariate }) {
  const name = columnName(covariate);
  return name === covariate ? covariate : `${capital(name)} ${covariate}`;
}

const kindOf = (index, number) => ORDINALS[number > 1 ? Math.round((index * (ORDINALS.length - 1)) / (number - 1)) : 0];
const className = (value) => String(Number(value.toPrecision(3)));

function nearest(classes, value) {
  const distances = classes.map((center) => Math.abs(center - value));
  return distances.indexOf(Math.min(...distances));
}

function classChart(result, one) {
  const { observations, curves } = result;
  const { classes, covariate } = one;
  const values = observations.covariates?.[covariate] ?? [];
  const hasMixed = one.population.some((column) => column.some(isNumber));
  const tip = tipOf(result);
  const trees = observations.dbh
    .map((x, index) => ({ x, y: observations.observed[index], value: values[index], index }))
    .filter(({ x, y, value }) => isNumber(x) && isNumber(y) && isNumber(value))
    .map(({ x, y, value, index }) => ({ x, y, kind: kindOf(nearest(classes, value), classes.length), tip: `${tip(index)}, ${covariate} ${significant(value, 3)}` }));
  const curve = (columns, more) => classes.map((_, index) => lineLayer(kindOf(index, classes.length), curves.dbh, columns[index], { thin: one.trees[index] < FEW_TREES, ...more })).filter(hasValues);
  const mixed = curve(one.population, {});
  const ols = curve(one.covariates, hasMixed ? { dash: true, thin: true } : {});
  const main = hasMixed ? mixed : ols;
  const labels = main.map((layer, index) => lastLabel(layer, `${covariate} ${className(classes[index])}`));
  const layers = [{ mark: "points", kind: "point", values: trees }, ...ols, ...mixed, { mark: "labels", kind: "point", values: labels }].filter((layer) => layer.values.length > 0);
  return {
    label:
      `${responseName(result.response)} against DBH for ${classes.length} classes of ${columnName(covariate)}. ` +
      `${spread(result, one, main)} The table behind the chart has the curves.`,
    ...axes(result, layers),
    layers,
    labelSpace: 8 + 7.2 * Math.max(0, ...labels.map(({ text }) => text.length)),
  };
}

/** "At DBH 22.0 cm the curves go from 15.3 m (C 0) to 12.1 m (C 1)." */
function spread({ curves, unit }, { classes, covariate }, layers) {
  if (layers.length < 2) return "";
  const middle = Math.floor(curves.dbh.length / 2);
  const end = (layer, value) => `${decimals(layer.values[middle].y, 2)} ${unit} (${covariate} ${className(value)})`;
  return `At DBH ${decimals(curves.dbh[middle], 1)} cm the curves go from ${end(layers[0], classes[0])} to ${end(layers.at(-1), classes.at(-1))}.`;
}

function classTable({ curves, unit }, one) {
  const column = (name, columns) => one.classes.map((value, index) => along(`${name}, ${one.covariate} ${className(value)}, ${unit}`, columns[index]));
  const hasAny = (columns) => columns.some((values) => values.some(isNumber));
  const parts = [DBH, ...(hasAny(one.population) ? column("NLME", one.population) : []), ...(hasAny(one.covariates) ? column("OLS", one.covariates) : [])];
  const numbers = one.classes.map((value, index) => `${className(value)}: ${plural(one.trees[index], "tree")}`);
  return table(`Curves by classes of ${columnName(one.covariate)} (${listing(numbers)})`, parts, gridRows(curves.dbh));
}

