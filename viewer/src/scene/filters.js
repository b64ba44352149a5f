// SPDX-License-Identifier: MIT
// Which trees are shown: by plot, species, layer, observed height and residual.
import { predictions, residualOf, RESPONSES } from "./data.js";

/**
 * @typedef {object} Filter
 * @property {number | null} plot     index, or null for all
 * @property {number | null} species  index
 * @property {number | null} layer    index
 * @property {number | null} least    height [m]
 * @property {number | null} most     height [m]
 * @property {number | null} residual  index in residualsOf()
 * @property {number | null} lowest    residual [m]
 * @property {number | null} highest   residual [m]
 */

export const ALL = { plot: null, species: null, layer: null, least: null, most: null, residual: null, lowest: null, highest: null };

/** The residuals of the page: `{text, variant, response}`. */
export function residualsOf(data) {
  const all = predictions(data).flatMap((variant) => Object.keys(RESPONSES).map((response) => ({ text: `${RESPONSES[response]}, ${variant.title}`, variant, response })));
  return all.filter(({ variant, response }) => variant[response].some((_, tree) => residualOf(data, variant, response, tree) !== null));
}

const hasResidual = ({ residual, lowest, highest }) => residual !== null && (lowest !== null || highest !== null);

/** Whether trees are hidden besides those of other plots. */
export const isNarrow = (filter) => hasResidual(filter) || [filter.species, filter.layer, filter.least, filter.most].some((value) => value !== null);

const isBetween = (value, least, most) => (least === null && most === null) || (value !== null && value >= (least ?? -Infinity) && value <= (most ?? Infinity));

/**
 * A tree without a layer, a height or the residual passes only if the filter has none.
 * @param {object} data  of the page
 * @param {Filter} filter
 * @returns {(tree: number) => boolean}
 */
export function passesOf(data, filter) {
  const { trees } = data;
  const { plot, species, layer, least, most, lowest, highest } = filter;
  const shown = hasResidual(filter) ? residualsOf(data)[filter.residual] : null;
  return (tree) =>
    (plot === null || trees.plot[tree] === plot) &&
    (species === null || trees.species[tree] === species) &&
    (layer === null || trees.layer[tree] === layer) &&
    isBetween(trees.h[tree], least, most) &&
    (!shown || isBetween(residualOf(data, shown.variant, shown.response, tree), lowest, highest));
}
