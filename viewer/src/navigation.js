// SPDX-License-Identifier: MIT
// The table of contents beside the page.
import { group } from "d3-array";
import { element } from "./dom.js";
import { responseName } from "./format.js";
import { themeSwitch } from "./theme.js";

export const resultId = (index) => `result-${index + 1}`;

function entry({ result, index }) {
  const reason = result.converged ? "doubtful" : "not converged";
  const warning = (result.sound ?? result.converged) ? null : element("span", { class: "bad", title: reason }, " \u26a0");
  return element("li", {}, element("a", { href: `#${resultId(index)}` }, responseName(result.response), warning));
}

const link = (section) => element("li", {}, element("a", { href: `#${section.id}` }, section.querySelector("h2").textContent));
const ofSpecies = ([species, entries]) => element("li", { class: "group" }, element("span", { class: "species" }, species), element("ul", {}, ...entries.map(entry)));

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

/**
 * Links to the sections of a page; those of results are grouped by species.
 * @param {Element[]} parts  of the page
 * @param {object[]} results  of a report
 */
export function navigation(parts, results = []) {
  const sections = parts.filter((part) => part.matches("section"));
  const groups = group(results.map((result, index) => ({ result, index })), ({ result }) => result.species);
  const first = results.length > 0 ? sections.findIndex(({ id }) => id === resultId(0)) : sections.length;
  return frame(...sections.slice(0, first).map(link), ...[...groups].map(ofSpecies), ...sections.slice(first + results.length).map(link));
}
