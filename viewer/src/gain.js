// SPDX-License-Identifier: MIT
// The gain of the mixed models over least squares, for all species and responses in one chart.
import { chartElement } from "./chart-view.js";
import { extent } from "./classes.js";
import { figure } from "./figure.js";
import { plural, points, r2, responseName } from "./format.js";
import { numeric, table } from "./table.js";

const ROW_HEIGHT = 24;
const AXIS_HEIGHT = 64;

const accuracy = (fit, level) => fit?.statistics[level]?.r2 ?? null;

function rowOf(result) {
  return {
    y: `${result.species} ${responseName(result.response).toLowerCase()}`,
    ols: accuracy(result.fits.ols, "population"),
    population: accuracy(result.fits.nlme, "population"),
    conditional: accuracy(result.fits.nlme, "conditional"),
    gain: result.gain,
  };
}

/** @param {Report} report  null if there is nothing to compare */
export function gainFigure({ results }) {
  const rows = results.filter(({ converged }) => converged).map(rowOf).filter(({ ols, conditional }) => ols !== null && conditional !== null);
  if (rows.length === 0) return null;
  const dots = (kind, name, large) => ({ mark: "points", kind, large, values: rows.filter((row) => row[name] !== null).map((row) => ({ x: row[name], y: row.y, tip: `${row.y}: R² ${r2(row[name])}` })) });
  const right = (row) => Math.max(row.ols, row.conditional, row.population ?? -Infinity);
  const best = rows.reduce((a, b) => (b.gain.conditional > a.gain.conditional ? b : a));
  const chart = {
    label: `R² of least squares and of the mixed models, for ${plural(rows.length, "species and response", "pairs of species and response")}. The largest gain is ${points(best.gain.conditional)} percentage points, ${best.y}.`,
    x: { title: "R²", domain: extent(rows.flatMap(({ ols, population, conditional }) => [ols, population, conditional])) },
    y: { title: null, domain: rows.map(({ y }) => y) },
    layers: [
      { mark: "intervals", kind: "nlme", values: rows.map((row) => ({ y: row.y, low: row.ols, high: row.conditional })) },
      dots("ols", "ols", true),
      dots("guide", "population", false),
      dots("nlme", "conditional", true),
      { mark: "labels", kind: "text", values: rows.map((row) => ({ x: right(row), y: row.y, text: points(row.gain.conditional) })) },
    ],
    labelSpace: 40,
    height: AXIS_HEIGHT + ROW_HEIGHT * rows.length,
  };
  const columns = [
    { title: "Species, response", text: true, value: ({ y }) => y },
    numeric("R² OLS", ({ ols }) => ols, r2),
    numeric("R² NLME population", ({ population }) => population, r2),
    numeric("R² NLME conditional", ({ conditional }) => conditional, r2),
    numeric("Gain population, percentage points", ({ gain }) => gain.population, points),
    numeric("Gain conditional, percentage points", ({ gain }) => gain.conditional, points),
  ];
  return figure({
    title: "Gain of the mixed models",
    legend: [["dot-ols", "OLS"], ["dot-guide", "NLME, population (b = 0)"], ["dot-nlme", "NLME, conditional (EBLUP)"]],
    note: "Numbers at the lines: gain of the conditional prediction in percentage points of R².",
    charts: [chartElement(chart)],
    behind: () => [table("Gains of the mixed models over least squares", columns, rows)],
  });
}
