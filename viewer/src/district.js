// SPDX-License-Identifier: MIT
// The first part of the report: the stand table, diameters, the height curves to use, and what was left out.
import { chartElement } from "./chart-view.js";
import { extent } from "./classes.js";
import { disclosure, element, section } from "./dom.js";
import { figure } from "./figure.js";
import { count, decimals, plural, withMinusSigns } from "./format.js";
import { madeTable } from "./study-tables.js";
import { numeric, table } from "./table.js";

/** Curves that differ in color; further ones are gray. */
const KINDS = ["first", "second", "third", "fourth", "fifth", "ols", "nlme"];

/** @param {Report} report */
export function district({ stand, notes, map }) {
  if (!stand) return null;
  const [species, ...others] = stand.tables;
  const links = [map ? ["#map", "plot map"] : null, notes.length > 0 ? ["#notes", `${plural(notes.length, "note")} on how the table was read and what was assumed`] : null].filter((one) => one !== null);
  return section(
    "stand",
    "Stand",
    {},
    madeTable(species),
    ...others.map((made) => disclosure([element("span", { class: "level" }, made.caption)], () => [madeTable(made)], 1)),
    element("div", { class: "figures" }, diameterFigure(stand.diameters), curveFigure(stand.curves)),
    formulas(stand.curves),
    ...stand.left_out.map((sentence) => element("p", { class: "small" }, withMinusSigns(sentence))),
    links.length > 0 ? element("p", { class: "small" }, "See also: ", ...links.flatMap(([href, text], place) => [place > 0 ? "; " : "", element("a", { href }, text)]), ".") : null,
  );
}

function diameterFigure(classes) {
  if (classes.length === 0) return null;
  const perHa = classes.some(({ stems_per_ha: stems }) => stems !== null);
  const value = (one) => (perHa ? one.stems_per_ha : one.trees);
  const most = Math.max(...classes.map(value));
  // Each class is a bar: a rectangle between its limits.
  const bars = classes.map((one) => ({ mark: "band", kind: "ols", values: [{ x: one.low, low: 0, high: value(one) }, { x: one.high, low: 0, high: value(one) }] }));
  const unit = perHa ? "Stems per ha" : "Trees";
  const chart = {
    label: `Diameter distribution: ${unit.toLowerCase()} by classes of DBH from ${classes[0].low} to ${classes.at(-1).high} cm, at most ${decimals(most, 1)}.`,
    x: { title: "DBH (cm)", domain: [classes[0].low, classes.at(-1).high] },
    y: { title: unit, domain: [0, most] },
    layers: bars,
  };
  const columns = [
    { title: "DBH, cm", text: true, value: ({ low, high }) => `${low}\u2013${high}` },
    numeric("Trees", ({ trees }) => trees, count),
    numeric("N/ha", ({ stems_per_ha: stems }) => stems, (number) => decimals(number, 1)),
    numeric("G/ha, m²", ({ basal_area_per_ha: area }) => area, (number) => decimals(number, 2)),
  ];
  return figure({ title: "Diameter distribution", charts: [chartElement(chart)], behind: () => [table("Diameter classes", columns, classes)] });
}

const kindOf = (index) => KINDS[index] ?? "point";

function curveFigure(curves) {
  if (curves.length === 0) return null;
  const lines = curves.map(({ dbh, h, species }, index) => ({ mark: "line", kind: kindOf(index), values: dbh.map((x, at) => ({ x, y: h[at], tip: `${species}: ${decimals(h[at], 1)} m at DBH ${decimals(x, 1)} cm` })) }));
  const labels = lines.map((line, index) => ({ ...line.values.at(-1), text: curves[index].species, kind: line.kind }));
  const chart = {
    label: `Height curves of ${plural(curves.length, "species", "species")} against DBH.`,
    x: { title: "DBH (cm)", domain: extent(...curves.map(({ dbh }) => dbh)) },
    y: { title: "Height (m)", domain: extent([1.3], ...curves.map(({ h }) => h)) },
    layers: [...lines, { mark: "labels", kind: "text", values: labels }],
    labelSpace: 64,
  };
  const rows = curves.flatMap(({ species, dbh, h }) => dbh.map((x, at) => ({ species, dbh: x, h: h[at] })).filter((_, at) => at % 5 === 0));
  const columns = [
    { title: "Species", text: true, value: ({ species }) => species },
    numeric("DBH, cm", ({ dbh }) => dbh, (number) => decimals(number, 1)),
    numeric("Height, m", ({ h }) => h, (number) => decimals(number, 2)),
  ];
  return figure({ title: "Height curves", charts: [chartElement(chart)], behind: () => [table("Heights by the curves", columns, rows)] });
}

/** The curves as text for a spreadsheet with DBH in cell A2. */
function formulas(curves) {
  if (curves.length === 0) return null;
  const columns = [
    { title: "Species", text: true, value: ({ species }) => species },
    { title: "Height in m for a spreadsheet, with DBH in cm in cell A2", text: true, value: ({ formula }) => element("code", {}, formula) },
    { title: "DBH from", value: ({ dbh }) => decimals(dbh[0], 1) },
    { title: "to, cm", value: ({ dbh }) => decimals(dbh.at(-1), 1) },
    numeric("RMSE, m", ({ rmse }) => rmse, (number) => decimals(number, 2)),
    numeric("Trees", ({ trees }) => trees, count),
  ];
  return table("Height curves to use: means of all plots, valid in the range of DBH of the measured trees", columns, curves);
}

/** The notes, behind a line. */
export function noteList({ notes }) {
  if (notes.length === 0) return null;
  return section(
    "notes",
    "Notes",
    {},
    disclosure(`${plural(notes.length, "note")} on how the table was read and what was assumed`, () => [element("ul", {}, ...notes.map((note) => element("li", {}, withMinusSigns(note))))]),
  );
}
