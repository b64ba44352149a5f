// SPDX-License-Identifier: MIT
// One species and response: convergence, charts, chosen models, and candidates.
import { figures } from "./figures.js";
import { element, section, verdictMark } from "./dom.js";
import { isSound } from "./head.js";
import { plural, responseName, withMinusSigns } from "./format.js";
import { levels } from "./levels.js";
import { chosenModels } from "./models.js";

/** @param {Result} result */
export function resultSection(result, id) {
  const title = `${result.species}: ${responseName(result.response).toLowerCase()}`;
  return section(
    id,
    title,
    { class: isSound(result) ? "result" : "result failed" },
    element("p", {}, verdictMark(result.converged, isSound(result)), ` ${plural(result.n, "tree")} on ${plural(result.plots, "plot")}`),
    element("p", { class: result.converged ? "small" : "note bad" }, withMinusSigns(result.verdict)),
    ...(result.doubts ?? []).map((doubt) => element("p", { class: "note bad" }, withMinusSigns(doubt))),
    ...result.notes.map((note) => element("p", { class: "note" }, withMinusSigns(note))),
    element("div", { class: "figures" }, ...figures(result)),
    element("h3", {}, "Chosen models"),
    ...chosenModels(result),
    element("h3", {}, "Candidates"),
    ...levels(result),
  );
}
