// SPDX-License-Identifier: MIT
// Colorings of trees. All scales are distinguishable with color vision deficiencies, and also increase or decrease in lightness.
import { roundUp } from "../format.js";
import { predictions, residualOf, RESPONSES, treeCount } from "./data.js";

/** Colors of Okabe and Ito, with a slightly lighter black. */
export const SPECIES_COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#f0e442", "#303030"];
export const OTHER_COLOR = "#8a8a8a";
/** From viridis: lightness rises with the layer. */
export const LAYER_COLORS = ["#46327e", "#1f9e89", "#fde725"];
/** viridis (van der Walt and Smith). */
export const SEQUENTIAL = ["#440154", "#3b528b", "#21918c", "#5ec962", "#fde725"];
/** Orange below, blue above, light in the middle (ColorBrewer's ends of PuOr and RdBu). */
export const DIVERGING = ["#b35806", "#f1a340", "#f2f0e8", "#67a9cf", "#2166ac"];
export const MISSING_COLOR = "#9a9a9a";

const SIZES = { dbh: ["DBH", "cm"], h: ["Height", "m"], hcb: ["Crown base", "m"], cw: ["Crown width", "m"] };
const INDICES = { W: "W, uniform angle", M: "M, mingling", U: "U, dominance", C: "C, crowding" };

export const rgb = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255);
const hexOf = (color) => `#${color.map((value) => Math.round(value * 255).toString(16).padStart(2, "0")).join("")}`;

/** The color at a position, 0 to 1, of a scale. */
export function along(scale, share) {
  const place = Math.min(1, Math.max(0, share)) * (scale.length - 1);
  const below = Math.min(scale.length - 2, Math.floor(place));
  const [a, b] = [rgb(scale[below]), rgb(scale[below + 1])];
  return hexOf(a.map((value, index) => value + (place - below) * (b[index] - value)));
}

const everyTree = () => true;

const categoryColor = (code) => SPECIES_COLORS[code] ?? OTHER_COLOR;

/** Legend of categories, which are listed by falling number of trees. */
function categoryKeys(names, codes, passes, what) {
  const counts = names.map(() => 0);
  codes.forEach((code, tree) => {
    if (code !== null && passes(tree)) counts[code] += 1;
  });
  const keys = names.slice(0, SPECIES_COLORS.length).map((name, code) => ({ color: categoryColor(code), text: `${name || `no ${what}`} (${counts[code]})`, count: counts[code] })).filter(({ count }) => count > 0);
  const others = counts.slice(SPECIES_COLORS.length).reduce((sum, count) => sum + count, 0);
  if (others > 0) keys.push({ color: OTHER_COLOR, text: `other ${what} (${others})` });
  return keys;
}

function speciesColoring(data, passes) {
  const { species } = data.trees;
  return { title: "Species", told: "Trees are colored by species.", of: (tree) => categoryColor(species[tree]), keys: categoryKeys(data.species, species, passes, "species") };
}

function layerColoring(data, passes) {
  const [low, high] = data.layer_bounds;
  const ranges = [`below ${low} m`, `${low} to below ${high} m`, `${high} m and more`];
  const counts = data.layers.map((_, layer) => data.trees.layer.filter((own, tree) => own === layer && passes(tree)).length);
  const keys = data.layers.map((name, layer) => ({ color: LAYER_COLORS[layer], text: `${name}, ${ranges[layer] ?? ""} (${counts[layer]})` }));
  return withMissing(data, {
    title: "Layer",
    told: "Trees are colored by the layer of their observed height; higher layers are lighter.",
    of: (tree) => (data.trees.layer[tree] === null ? null : LAYER_COLORS[data.trees.layer[tree]]),
    keys,
  }, passes);
}

function withMissing(data, coloring, passes) {
  let missing = 0;
  for (let tree = 0; tree < treeCount(data); ++tree) missing += passes(tree) && coloring.of(tree) === null ? 1 : 0;
  const keys = missing > 0 ? [...(coloring.keys ?? []), { color: MISSING_COLOR, text: `unknown (${missing})` }] : coloring.keys;
  return { ...coloring, keys, of: (tree, shown) => coloring.of(tree, shown) ?? MISSING_COLOR };
}

function indexColoring(data, index, passes) {
  const values = data.trees[index];
  return withMissing(data, {
    title: INDICES[index],
    told: `Trees are colored by ${INDICES[index]}: dark is 0, light is 1.`,
    of: (tree) => (values[tree] === null ? null : along(SEQUENTIAL, values[tree])),
    scale: { colors: SEQUENTIAL, labels: ["0", "0.5", "1"] },
  }, passes);
}

/** Numbers on a scale that has 95 % of them, so that one very large value does not darken all others. */
function scaleColoring(data, values, { title, what, unit }, passes) {
  const known = values.filter((value) => value !== null).sort((a, b) => a - b);
  const at = (share) => known[Math.round(share * (known.length - 1))];
  const [low, high] = [at(0.025), at(0.975)];
  // Three digits of the range: those that tell colors apart.
  const digits = high > low ? Math.max(0, 2 - Math.floor(Math.log10(high - low))) : 1;
  const text = (value) => `${Number(value.toFixed(Math.min(digits, 20)))}${unit}`;
  return withMissing(data, {
    title,
    told: `Trees are colored by ${what}: dark is ${text(low)} or less, light is ${text(high)} or more.`,
    of: (tree) => (values[tree] === null ? null : along(SEQUENTIAL, high > low ? (values[tree] - low) / (high - low) : 0.5)),
    scale: { colors: SEQUENTIAL, labels: [text(low), text((low + high) / 2), text(high)] },
  }, passes);
}

function sizeColoring(data, name, passes) {
  const [title, unit] = SIZES[name];
  return scaleColoring(data, data.trees[name], { title, what: `their observed ${title === "DBH" ? title : title.toLowerCase()}`, unit: ` ${unit}` }, passes);
}

/** Any other column of the table. */
function columnColoring(data, { name, texts, values }, passes) {
  if (!texts) return scaleColoring(data, values, { title: name, what: `the column ${name}`, unit: "" }, passes);
  const of = (tree) => (values[tree] === null ? null : categoryColor(values[tree]));
  return withMissing(data, { title: name, told: `Trees are colored by the column ${name}.`, of, keys: categoryKeys(texts, values, passes, name) }, passes);
}

/** Limits of the scale: the residuals of all variants contain 95 % between them. */
function residualLimit(data, variants, response) {
  const sizes = variants.flatMap((variant) => variant[response].map((_, tree) => residualOf(data, variant, response, tree))).filter((value) => value !== null).map(Math.abs).sort((a, b) => a - b);
  return roundUp(Math.max(0.1, sizes[Math.floor(0.95 * (sizes.length - 1))] ?? 0.1));
}

/** @param {object | null} variant  null: the sizes shown on each side */
function residualColoring(data, variant, response, passes) {
  const limit = residualLimit(data, predictions(data), response);
  const residual = (tree, shown) => (shown && predictions(data).includes(shown) ? residualOf(data, shown, response, tree) : null);
  const whose = variant ? variant.title : "the shown sizes";
  const coloring = {
    title: `Residual of ${RESPONSES[response]}, ${whose}`,
    told: `Observed minus predicted ${RESPONSES[response]} of ${whose}: orange trees are smaller than predicted, blue ones larger, light ones as predicted; beyond ${limit} m the color does not change.`,
    of: (tree, shown) => {
      const value = residual(tree, variant ?? shown);
      return value === null ? null : along(DIVERGING, 0.5 + value / (2 * limit));
    },
    scale: { colors: DIVERGING, labels: [`−${limit} m`, "0", `+${limit} m`] },
  };
  if (variant) return withMissing(data, coloring, passes);
  return { ...coloring, keys: [{ color: MISSING_COLOR, text: "unknown; observed sizes have no residual" }], of: (tree, shown) => coloring.of(tree, shown) ?? MISSING_COLOR };
}

const hasValues = (values) => values.some((value) => value !== null);

/** Groups of colorings available for these data: `{label, choices: [{value, text, make}]}`; the first one is the neutral one. `make` counts the trees that pass its test. */
export function colorings(data) {
  const choice = (value, text, make) => ({ value, text, make: (passes = everyTree) => make(passes) });
  const known = (names) => Object.keys(names).filter((name) => hasValues(data.trees[name]));
  const hasResiduals = (variant) => (response) => variant[response].some((_, tree) => residualOf(data, variant, response, tree) !== null);
  const responses = Object.keys(RESPONSES);
  const general = [choice("natural", "Natural", () => null)];
  if (treeCount(data) === 0) return [{ label: null, choices: general }];
  general.push(choice("species", "Species", (passes) => speciesColoring(data, passes)));
  if (hasValues(data.trees.layer)) general.push(choice("layer", "Layer", (passes) => layerColoring(data, passes)));
  return [
    { label: null, choices: general },
    { label: "Observed size", choices: known(SIZES).map((name) => choice(`size-${name}`, SIZES[name][0], (passes) => sizeColoring(data, name, passes))) },
    { label: "Structural index", choices: known(INDICES).map((index) => choice(index, INDICES[index], (passes) => indexColoring(data, index, passes))) },
    { label: "Other column", choices: data.columns.map((column) => choice(`column-${column.name}`, column.name, (passes) => columnColoring(data, column, passes))) },
    {
      label: "Residual of the sizes shown",
      choices: predictions(data).length === 0 ? [] : responses.map((response) => choice(`shown-${response}`, `Residual ${response}, as shown`, (passes) => residualColoring(data, null, response, passes))),
    },
    ...predictions(data).map((variant) => ({
      label: `Residual, ${variant.title}`,
      choices: responses.filter(hasResiduals(variant)).map((response) => choice(`${variant.name}-${response}`, `Residual ${response}, ${variant.title}`, (passes) => residualColoring(data, variant, response, passes))),
    })),
  ].filter(({ choices }) => choices.length > 0);
}
