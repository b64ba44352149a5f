// SPDX-License-Identifier: MIT
// The list of species and responses beside the report.
import { element } from "./dom.js";
import { responseName } from "./format.js";

export const resultId = (index) => `result-${index + 1}`;

function bySpecies(results) {
  const groups = new Map();
  results.forEach((result, index) => {
    if (!groups.has(result.species)) groups.set(result.species, []);
    groups.get(result.species).push({ result, index });
  });
  return [...groups];
}

function entry({ result, index }) {
  const warning = result.converged ? null : element("span", { class: "bad", title: "not converged" }, " \u26a0");
  return element("li", {}, element("a", { href: `#${resultId(index)}` }, responseName(result.response), warning));
}

export function navigation(report) {
  const groups = bySpecies(report.results).map(([species, entries]) =>
    element("li", { class: "group" }, element("span", { class: "species" }, species), element("ul", {}, ...entries.map(entry))),
  );
  const start = [
    ["#verdict", "Verdict"],
    ["#summary", "Summary"],
    ["#done", "What was done"],
    ...(report.map ? [["#map", "Plot map"]] : []),
  ].map(([href, text]) => element("li", {}, element("a", { href }, text)));
  return element("nav", { "aria-label": "Report" }, element("ul", {}, ...start, ...groups));
}
