// SPDX-License-Identifier: MIT
// What is known of the chosen tree, as a table.
import { element } from "../dom.js";
import { decimals } from "../format.js";
import { presetOf, residualOf, speciesOf, treeName } from "./data.js";

const RESPONSES = [
  ["h", "Height", "m"],
  ["hcb", "Crown base", "m"],
  ["cw", "Crown width", "m"],
];
const INDICES = [
  ["W", "Uniform angle W"],
  ["M", "Mingling M"],
  ["U", "Dominance U"],
  ["C", "Crowding C"],
];

const number = (text, value) => element("td", { class: "number" }, value === null ? text : decimals(value, 2));

function sizesTable(data, tree) {
  const others = data.variants.filter(({ name }) => name !== "observed" && name !== "scene");
  const head = element("tr", {}, element("th", { scope: "col" }, "m"), element("th", { scope: "col", class: "number" }, "Observed"), ...others.flatMap(({ title }) => [element("th", { scope: "col", class: "number" }, title), element("th", { scope: "col", class: "number" }, "Residual")]));
  const rows = RESPONSES.map(([response, title]) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, title),
      number("–", data.trees[response][tree]),
      ...others.flatMap((variant) => [number("–", variant[response][tree]), number("–", residualOf(data, variant, response, tree))]),
    ),
  );
  return element("div", { class: "scroll", tabindex: "0", role: "region", "aria-label": "Sizes of the chosen tree" }, element("table", { class: "sizes" }, element("thead", {}, head), element("tbody", {}, ...rows)));
}

/** @returns {Node[]} */
export function details(data, tree) {
  if (tree === null) return [element("p", { class: "quiet" }, "None. Click a tree in the picture or in the list.")];
  const layer = data.trees.layer[tree];
  const facts = [
    ["Plot", data.plots[data.trees.plot[tree]].name],
    ["Tree", data.trees.tree[tree]],
    ["Species", speciesOf(data, tree) || "–"],
    ["Drawn as", presetOf(data, tree).title],
    ["DBH", data.trees.dbh[tree] === null ? "–" : `${decimals(data.trees.dbh[tree], 1)} cm`],
    ["Layer", layer === null ? "–" : data.layers[layer]],
    ...INDICES.filter(([index]) => data.trees[index][tree] !== null).map(([index, title]) => [title, decimals(data.trees[index][tree], 2)]),
  ];
  if (data.trees.core[tree] !== null) facts.push(["In the buffer zone", data.trees.core[tree] ? "no" : "yes"]);
  return [
    element("p", { class: "chosen" }, `Chosen: ${treeName(data, tree)}`),
    element("dl", {}, ...facts.flatMap(([title, value]) => [element("dt", {}, title), element("dd", {}, value)])),
    sizesTable(data, tree),
  ];
}
