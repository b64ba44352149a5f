// SPDX-License-Identifier: MIT
// Which trees are shown: by plot, species, layer and observed height.

/**
 * @typedef {object} Filter
 * @property {number | null} plot     index, or null for all
 * @property {number | null} species  index
 * @property {number | null} layer    index
 * @property {number | null} least    height [m]
 * @property {number | null} most     height [m]
 */

export const ALL = { plot: null, species: null, layer: null, least: null, most: null };

/** Whether trees are hidden besides those of other plots. */
export const isNarrow = ({ species, layer, least, most }) => [species, layer, least, most].some((value) => value !== null);

/**
 * A tree without a layer or a height passes only if the filter has neither.
 * @param {object} data  of the page
 * @param {Filter} filter
 * @returns {(tree: number) => boolean}
 */
export function passesOf({ trees }, { plot, species, layer, least, most }) {
  const isWithin = (height) => (least === null && most === null) || (height !== null && height >= (least ?? -Infinity) && height <= (most ?? Infinity));
  return (tree) =>
    (plot === null || trees.plot[tree] === plot) &&
    (species === null || trees.species[tree] === species) &&
    (layer === null || trees.layer[tree] === layer) &&
    isWithin(trees.h[tree]);
}
