// SPDX-License-Identifier: MIT
// Controls of the shown trees.
import { element } from "../dom.js";
import { residualsOf } from "./filters.js";
import { choice, numberField } from "./panel.js";

const listed = (names, all) => [{ label: null, choices: [{ value: "", text: all }, ...names.map((name, index) => ({ value: String(index), text: name || "none" }))] }];
const indexOf = (value) => (value === "" ? null : Number(value));

/**
 * @param {object} data  of the page
 * @param {(change: Partial<import("./filters.js").Filter>) => void} change
 */
export function filterControls(data, change) {
  const residuals = residualsOf(data).map(({ text }) => text);
  return element(
    "details",
    { id: "filters" },
    element("summary", { id: "filters-summary" }, "Shown trees"),
    ...(data.species.length > 1 ? [choice("only-species", "Species", listed(data.species, "all"), (value) => change({ species: indexOf(value) }))] : []),
    ...(data.layers.length > 1 ? [choice("only-layer", "Layer", listed(data.layers, "all"), (value) => change({ layer: indexOf(value) }))] : []),
    numberField("least-height", "Height from [m]", (least) => change({ least }), "0"),
    numberField("most-height", "Height to [m]", (most) => change({ most }), "0"),
    ...(residuals.length > 0
      ? [
          choice("only-residual", "Residual of", listed(residuals, "none"), (value) => change({ residual: indexOf(value) })),
          numberField("lowest-residual", "Residual from [m]", (lowest) => change({ lowest })),
          numberField("highest-residual", "Residual to [m]", (highest) => change({ highest })),
        ]
      : []),
  );
}

/** Shows a filter in its controls. */
export function showFilter(node, { species, layer, least, most, residual, lowest, highest }) {
  const values = {
    "only-species": species,
    "only-layer": layer,
    "least-height": least,
    "most-height": most,
    "only-residual": residual,
    "lowest-residual": lowest,
    "highest-residual": highest,
  };
  for (const [id, value] of Object.entries(values)) {
    const control = node.querySelector(`#${id}`);
    if (control) control.value = value === null ? "" : String(value);
  }
}
