// SPDX-License-Identifier: MIT
// The data in the page, and functions that read them. Schema: scene-data.schema.json.

import { areaOf, hullOf, sharedArea } from "./hulls.js";

export const readData = () => JSON.parse(document.getElementById("view-data").textContent);

export const treeCount = (data) => data.trees.tree.length;

/** "1 tree", "2 trees" */
export const counted = (count, what) => `${count} ${what}${count === 1 ? "" : "s"}`;

/** "plot 1, tree 12" */
export function treeName(data, tree) {
  return `plot ${data.plots[data.trees.plot[tree]].name}, tree ${data.trees.tree[tree]}`;
}

export const speciesOf = (data, tree) => data.species[data.trees.species[tree]];
export const presetOf = (data, tree) => data.presets[data.trees.preset[tree]];

/** Position in the page's frame: x east, y up, z south, from the origin [m]. */
export function placeOf(data, tree) {
  const { x, y, z } = data.trees;
  return { x: x[tree] - data.origin.x, y: z[tree] - data.origin.z, z: -(y[tree] - data.origin.y) };
}

/**
 * The crown of a tree of a variant, or null if its sizes are impossible.
 * @returns {{h: number, hcb: number, hc: number, east: number, west: number, south: number, north: number, up: number, down: number} | null}
 */
export function crownOf(data, variant, tree) {
  const hc = variant.hc[tree];
  if (hc === null) return null;
  const half = variant.cw[tree] / 2;
  const radius = (side) => (variant.radii ? variant.radii[side][tree] : half);
  const { up, down } = presetOf(data, tree);
  return {
    h: variant.h[tree],
    hcb: variant.hcb[tree],
    hc,
    east: radius("east"),
    west: radius("west"),
    south: radius("south"),
    north: radius("north"),
    up,
    down,
  };
}

/** A GLB from a text in base64, of the file itself or compressed by zlib. @returns {Promise<ArrayBuffer>} */
export async function glbOf(base64) {
  const file = await fetch(`data:application/octet-stream;base64,${base64}`);
  const isPlain = base64.startsWith("Z2xUR");
  return isPlain ? file.arrayBuffer() : new Response(file.body.pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

/** The measured and predicted sizes. */
export const RESPONSES = { h: "height", hcb: "crown base", cw: "crown width" };

/** Residual of a tree: observed minus predicted [m], or null. */
export function residualOf(data, variant, response, tree) {
  const observed = data.trees[response][tree];
  const predicted = variant[response][tree];
  return observed === null || predicted === null ? null : observed - predicted;
}

/** Whether plots cover each other because each has its own coordinate system: two share more than half of the smaller one's area. */
export function plotsCoincide({ plots }) {
  const hulls = plots.map(({ outline }) => hullOf(outline)).filter((hull) => hull.length > 2);
  const placed = hulls.map((hull) => ({ hull, area: areaOf(hull), west: Math.min(...hull.map(([x]) => x)), east: Math.max(...hull.map(([x]) => x)) }));
  placed.sort((a, b) => a.west - b.west);
  // Sweep from west to east: only plots whose interval has begun and not ended can overlap the next one.
  let open = [];
  return placed.some((own) => {
    open = open.filter(({ east }) => east > own.west);
    const coincides = open.some((other) => sharedArea(other.hull, own.hull) > 0.5 * Math.min(other.area, own.area));
    open.push(own);
    return coincides;
  });
}

/** The plots whose boundaries are drawn: the selected one, or all. */
export const outlinedPlots = ({ plots }, shownPlot) => plots.filter((_, plot) => shownPlot === null || plot === shownPlot);

/** The stand after a thinning, which is compared with the one before from the start; null without. */
export const thinnedVariant = (data) => data.variants.find(({ name }) => name === "thinned") ?? null;

/** The variants with predictions. */
export const predictions = (data) => data.variants.filter(({ name }) => ["ols", "population", "conditional"].includes(name));
