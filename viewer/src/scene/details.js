// SPDX-License-Identifier: MIT
// The data of the selected tree, as a table.
import { element } from "../dom.js";
import { capital, columnName, decimals } from "../format.js";
import { predictions, presetOf, residualOf, RESPONSES, speciesOf, treeName } from "./data.js";

const NAMES = Object.entries(RESPONSES).map(([response, name]) => [response, capital(name)]);

const number = (value) => element("td", { class: "number" }, value === null ? "–" : decimals(value, 2));
const row = (title, valueOf) => element("tr", {}, element("th", { scope: "row" }, title), ...NAMES.map(([response]) => number(valueOf(response))));

/** Observed and predicted sizes, each prediction with its residual below. */
function sizesTable(data, tree) {
  const head = element("tr", {}, element("th", { scope: "col" }, "[m]"), ...NAMES.map(([, title]) => element("th", { scope: "col", class: "number" }, title)));
  const rows = predictions(data).flatMap((variant) => [row(variant.title, (response) => variant[response][tree]), row("– residual", (response) => residualOf(data, variant, response, tree))]);
  return element("table", { class: "sizes" }, element("thead", {}, head), element("tbody", {}, row("Observed", (response) => data.trees[response][tree]), ...rows));
}

/** The label of a tree in one line. */
export function cardText(data, tree) {
  const sizes = NAMES.filter(([response]) => data.trees[response][tree] !== null).map(([response, title]) => `${title.toLowerCase()} ${decimals(data.trees[response][tree], 2)} m`);
  return [`Chosen: ${treeName(data, tree)}`, speciesOf(data, tree), ...sizes].filter((text) => text !== "").join(", ");
}

/** @returns {Node[]} */
export function details(data, tree) {
  if (tree === null) return [element("p", { class: "quiet" }, "No tree is selected. Click a tree in the view or in the list.")];
  const layer = data.trees.layer[tree];
  const facts = [
    ["Plot", data.plots[data.trees.plot[tree]].name],
    ["Tree", data.trees.tree[tree]],
    ["Species", speciesOf(data, tree) || "–"],
    ["Preset", presetOf(data, tree).title],
    ["DBH", data.trees.dbh[tree] === null ? "–" : `${decimals(data.trees.dbh[tree], 1)} cm`],
    ["Layer", layer === null ? "–" : data.layers[layer]],
    ...["W", "M", "U", "C"].filter((index) => data.trees[index][tree] !== null).map((index) => [`${capital(columnName(index))} ${index}`, decimals(data.trees[index][tree], 2)]),
  ];
  if (data.trees.core[tree] !== null) facts.push(["Core tree", data.trees.core[tree] ? "yes" : "no"]);
  return [
    element("p", { class: "chosen" }, `Chosen: ${treeName(data, tree)}`),
    element("dl", {}, ...facts.flatMap(([title, value]) => [element("dt", {}, title), element("dd", {}, value)])),
    sizesTable(data, tree),
  ];
}
