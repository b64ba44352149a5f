// SPDX-License-Identifier: MIT
// Residuals: in classes as box plots, against fitted values, and against the normal distribution.
import { boxClasses, classWidth, drawnAlone, equalClasses, extent, FEWEST_TREES } from "./classes.js";
import { figure, titled } from "./figure.js";
import { capital, count, decimals, plural, responseInText, significant } from "./format.js";
import { isNumber, lineLayer, pointLayer, points, shownTrees, sides } from "./observations.js";
import { numeric, table } from "./table.js";
import { quantileNormal } from "./vega-parts.js";

const three = (value) => decimals(value, 3);

/** Boxes of the two methods are side by side within a class: their middle and width, relative to the class width. */
const PLACE = { ols: 0.28, nlme: 0.72 };
const BOX_WIDTH = 0.34;

/** @param {Result} result */
export function boxFigure(result) {
  const { observations, unit, response } = result;
  const shown = sides(result);
  const width = classWidth(extent(observations.observed));
  const by = [
    { name: "predicted", of: ({ fitted }) => fitted },
    { name: "observed", of: () => observations.observed },
  ].map(({ name, of }) => ({ name, groups: shown.map((side) => ({ side, classes: boxClasses(of(side), side.residual, width) })) }));
  const reach = extent(...shown.map(({ residual }) => residual));
  const subject = responseInText(response);
  return figure({
    title: `Standardized residuals by class of ${subject}`,
    legend: shown.map(({ kind, name }) => [`box ${kind}`, name]),
    note:
      `Classes of ${width} ${unit}. Box: middle half of the trees; line: median; cross: mean; whiskers: up to 1.5 box lengths; points: trees beyond, and classes with fewer than ${FEWEST_TREES} trees. ` +
      `In classes of observed ${subject} the residuals of every model increase. ${shownTrees(result)}`,
    charts: by.map(({ name, groups }) => titled(`By ${name} ${subject}`, boxChart({ name, groups, width, reach, result }))),
    behind: () => by.flatMap(({ name, groups }) => groups.map(({ side, classes }) => boxTable(`Standardized residuals of ${side.name} by ${name} ${subject}`, name, unit, classes))),
  });
}

function boxChart({ name, groups, width, reach, result }) {
  const { unit, response } = result;
  const all = groups.flatMap(({ classes }) => classes);
  const domain = all.length > 0 ? [Math.min(...all.map(({ from }) => from)), Math.max(...all.map(({ to }) => to))] : [0, 1];
  const layers = groups.flatMap(({ side, classes }) => {
    const middle = ({ from }) => from + PLACE[side.kind] * width;
    const boxes = classes
      .filter(({ number }) => number >= FEWEST_TREES)
      .map(({ outliers, values, ...one }) => ({
        ...one,
        x: middle(one),
        left: middle(one) - (BOX_WIDTH * width) / 2,
        right: middle(one) + (BOX_WIDTH * width) / 2,
        tip: `${side.name}, ${decimals(one.from, 2)} to ${decimals(one.to, 2)} ${unit}: median ${three(one.median)}, mean ${three(one.mean)}, ${plural(one.number, "tree")}`,
      }));
    const beyond = classes.flatMap((one) => drawnAlone(one).map((y) => ({ x: middle(one), y })));
    return [
      { mark: "points", kind: side.kind, values: beyond },
      { mark: "boxes", kind: side.kind, values: boxes },
    ];
  });
  return {
    label: `Box plots of standardized residuals by classes of ${name} ${responseInText(response)}, ${groups.map(({ side }) => side.name).join(" beside ")}. The tables behind the chart have the quartiles.`,
    x: { title: `${capital(name)} (${unit})`, domain, ticks: edges(domain, width) },
    y: { title: "Standardized residual", domain: reach },
    layers: [lineLayer("guide", domain, [0, 0]), ...layers],
  };
}

/** Grid lines are the limits of the classes. */
const edges = ([from, to], width) => Array.from({ length: Math.round((to - from) / width) + 1 }, (_, index) => Number((from + index * width).toPrecision(9)));

function boxTable(caption, name, unit, classes) {
  const columns = [
    { title: `${capital(name)}, ${unit}`, value: ({ from, to }) => `${Number(from.toPrecision(6))} to ${Number(to.toPrecision(6))}` },
    numeric("Trees", ({ number }) => number, count),
    numeric("Lower whisker", ({ low }) => low, three),
    numeric("First quartile", ({ q1 }) => q1, three),
    numeric("Median", ({ median }) => median, three),
    numeric("Mean", (one) => one.mean, three),
    numeric("Third quartile", ({ q3 }) => q3, three),
    numeric("Upper whisker", ({ high }) => high, three),
    numeric("Trees beyond", ({ outliers }) => outliers.length, count),
  ];
  return table(caption, columns, classes);
}

/** @param {Result} result */
export function residualFigure(result) {
  const { observations, unit } = result;
  const shown = sides(result).map((side) => ({ ...side, classes: equalClasses(side.fitted, side.residual) }));
  const xDomain = extent(...shown.map(({ fitted }) => fitted));
  const reach = Math.max(3, ...extent(...shown.map(({ residual }) => residual)).map(Math.abs));
  const guide = (kind, y) => lineLayer(kind, xDomain, [y, y]);
  const chart = (side) => ({
    label: `Standardized residuals of ${side.name} against fitted values; the table behind the chart gives them in classes.`,
    x: { title: `Fitted (${unit})`, domain: xDomain },
    y: { title: "Standardized residual", domain: [-reach, reach] },
    layers: [
      guide("guide", 0),
      guide("limit", -2),
      guide("limit", 2),
      pointLayer("point", points(observations, side.fitted, side.residual, (index) => `fitted ${significant(side.fitted[index], 4)} ${unit}, residual ${decimals(side.residual[index], 2)}`)),
      lineLayer(side.kind, side.classes.map(({ x }) => x), side.classes.map(({ y }) => y)),
    ],
  });
  return figure({
    title: "Standardized residuals against fitted values",
    legend: [["point", "trees"], ["limit", "two standard deviations"], ...shown.map(({ kind, name }) => [kind, `${name}: mean of trees in classes`])],
    note: "A good fit has no trend and the same spread everywhere.",
    charts: shown.map((side) => titled(side.name, chart(side))),
    behind: () => shown.map((side) => classTable(`Residuals of ${side.name}, in classes of fitted values`, `Fitted, ${unit}`, "Mean residual", side.classes)),
  });
}

/** Standard errors on each side of the band of order statistics: 95 % at each point. */
const BAND = 1.96;
const density = (z) => Math.exp(-0.5 * z * z) / Math.sqrt(2 * Math.PI);

/** Sorted residuals with the expected normal quantiles, and a pointwise 95 % band. */
export function normalQuantiles(residuals) {
  const sorted = residuals.filter(isNumber).sort((a, b) => a - b);
  return sorted.map((y, index) => {
    const share = (index + 0.5) / sorted.length;
    const x = quantileNormal(share, 0, 1);
    const error = Math.sqrt((share * (1 - share)) / sorted.length) / density(x);
    return { x, y, low: x - BAND * error, high: x + BAND * error };
  });
}

/** @param {Result} result */
export function quantileFigure(result) {
  const shown = sides(result).map((side) => ({ ...side, quantiles: normalQuantiles(side.residual) }));
  const xDomain = extent(...shown.map(({ quantiles }) => quantiles.map(({ x }) => x)));
  const yDomain = extent(xDomain, ...shown.map(({ quantiles }) => quantiles.map(({ y }) => y)));
  const chart = (side) => ({
    label: `Normal Q-Q plot of the standardized residuals of ${side.name}: ${outside(side.quantiles)} The table behind the chart gives both at fixed shares of the trees.`,
    x: { title: "Normal quantile", domain: xDomain },
    y: { title: "Standardized residual", domain: yDomain },
    layers: [
      { mark: "band", kind: "guide", values: side.quantiles },
      lineLayer("guide", xDomain, xDomain),
      pointLayer(side.kind, side.quantiles.map(({ x, y }) => ({ x, y, tip: `normal ${decimals(x, 2)}, residual ${decimals(y, 2)}` }))),
    ],
  });
  return figure({
    title: "Q-Q plot of standardized residuals",
    legend: [["guide", "normal distribution"], ["shade", "95 % of samples, at each point"]],
    note: "Where the points leave the band, the residuals are not normal: steep ends mean more extreme trees than a normal distribution has.",
    charts: shown.map((side) => titled(side.name, chart(side))),
    behind: () => shown.map((side) => quantileTable(`Quantiles of the residuals of ${side.name}`, side.quantiles)),
  });
}

function outside(quantiles) {
  const number = quantiles.filter(({ y, low, high }) => y < low || y > high).length;
  return `${count(number)} of ${plural(quantiles.length, "tree")} lie outside the 95 % band.`;
}

const SHARES = [0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95, 0.975, 0.99];

function quantileTable(caption, quantiles) {
  const rows = quantiles.length === 0 ? [] : SHARES.map((share) => ({ share, ...quantiles[Math.min(quantiles.length - 1, Math.floor(share * quantiles.length))] }));
  const columns = [
    { title: "Share of trees", value: ({ share }) => `${significant(100 * share, 2)} %` },
    numeric("Normal quantile", ({ x }) => x, three),
    numeric("Residual", ({ y }) => y, three),
    numeric("Band from", ({ low }) => low, three),
    numeric("Band to", ({ high }) => high, three),
  ];
  return table(caption, columns, rows);
}

export function classTable(caption, x, y, classes) {
  const columns = [
    numeric(x, (row) => row.x, (value) => decimals(value, 2)),
    numeric("Trees", ({ number }) => number, count),
    numeric(y, (row) => row.y, three),
    numeric("Standard deviation", ({ sd }) => sd, three),
  ];
  return table(caption, columns, classes);
}
