// SPDX-License-Identifier: MIT
// The table of contents beside the page.
import { pairId, pairName } from "./comparison.js";
import { element } from "./dom.js";
import { responseName } from "./format.js";
import { themeSwitch } from "./theme.js";

export const resultId = (index) => `result-${index + 1}`;

/** @returns {[string, {result: object, index: number}[]][]} */
function bySpecies(results) {
  const groups = new Map();
  results.forEach((result, index) => {
    if (!groups.has(result.species)) groups.set(result.species, []);
    groups.get(result.species).push({ result, index });
  });
  return [...groups];
}

function entry({ result, index }) {
  const reason = result.converged ? "doubtful" : "not converged";
  const warning = (result.sound ?? result.converged) ? null : element("span", { class: "bad", title: reason }, " \u26a0");
  return element("li", {}, element("a", { href: `#${resultId(index)}` }, responseName(result.response), warning));
}

const link = ([href, text]) => element("li", {}, element("a", { href }, text));
/** Beside the report if the page is wide enough; else a menu above it. */
const wide = matchMedia("(min-width: 76rem)");

function frame(...entries) {
  const menu = element("details", { class: "menu", open: wide.matches }, element("summary", {}, "Contents"), element("ul", {}, ...entries));
  wide.addEventListener("change", () => (menu.open = wide.matches));
  menu.addEventListener("click", ({ target }) => {
    if (target.closest("a") && !wide.matches) menu.open = false;
  });
  return element("nav", { "aria-label": "Report" }, menu, themeSwitch());
}

/** @param {Report} report */
export function reportNavigation(report) {
  const groups = bySpecies(report.results).map(([species, entries]) =>
    element("li", { class: "group" }, element("span", { class: "species" }, species), element("ul", {}, ...entries.map(entry))),
  );
  const models = report.results.length > 0 || !report.stand;
  const start = [
    ...(report.stand ? [["#stand", "Stand"]] : []),
    ...(models ? [["#verdict", "Sound and doubtful models"], ["#summary", "Summary"]] : []),
    ...(models && (report.tables ?? []).length > 0 ? [["#models", "Species and models"]] : []),
    ...(report.results.length > 0 ? [["#convergence", "Convergence"]] : []),
    ["#done", "What was done"],
    ...(report.map ? [["#map", "Plot map"]] : []),
  ];
  const end = [
    ...(models ? [["#tables", "Tables of the study"]] : []),
    ...(report.notes.length > 0 ? [["#notes", "Notes"]] : []),
    ["#repeat", "Reproducing this study"],
  ];
  return frame(...start.map(link), ...groups, ...end.map(link));
}

/** @param {Comparison} comparison */
export function comparisonNavigation({ pairs }) {
  const entries = pairs.map((pair, index) => element("li", { class: "group" }, element("a", { href: `#${pairId(index)}` }, pairName(pair))));
  return frame(...[["#libraries", "Libraries"], ["#overview", "Overview"]].map(link), ...entries);
}
