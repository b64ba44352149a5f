// SPDX-License-Identifier: MIT
// The plot map: stems by species and layer, crowns to scale, the buffer zone, and the structural unit of a tree.
import { element } from "./dom.js";
import { decimals, listing, plural } from "./format.js";
import { rectangleOf, wayAround } from "./torus.js";

/** @typedef {import("./types.js").PlotMap} PlotMap */

const SVG = "http://www.w3.org/2000/svg";
const COLORS = 8;
const MARGIN = 2;

function svg(tag, attributes = {}, ...children) {
  const node = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, String(value));
  node.append(...children);
  return node;
}

/** Species by falling number of trees have colors of their own; those beyond the eighth share one. */
function speciesClasses(map) {
  const counts = map.species_names.map(() => 0);
  for (const code of map.species) if (code !== null) counts[code] += 1;
  const order = counts.map((_, code) => code).sort((a, b) => counts[b] - counts[a] || a - b);
  const classes = new Map();
  order.forEach((code, rank) => classes.set(code, `species-${rank < COLORS ? rank + 1 : "other"}`));
  return { order, classes };
}

const treesOf = (map, area) => map.area.flatMap((own, tree) => (own === area && map.x[tree] !== null && map.y[tree] !== null ? [tree] : []));

function bounds(map, area, trees) {
  const corners = [...map.areas[area].rings.flat(), ...trees.map((tree) => [map.x[tree], map.y[tree]])];
  if (corners.length === 0) return { x: 0, y: 0, width: 1, height: 1 };
  const low = [Infinity, Infinity];
  const high = [-Infinity, -Infinity];
  for (const corner of corners) {
    for (const axis of [0, 1]) {
      low[axis] = Math.min(low[axis], corner[axis]);
      high[axis] = Math.max(high[axis], corner[axis]);
    }
  }
  return { x: low[0] - MARGIN, y: -high[1] - MARGIN, width: high[0] - low[0] + 2 * MARGIN, height: high[1] - low[1] + 2 * MARGIN };
}

/** North is up: y is drawn downwards with its sign turned. */
const pathOf = (rings) => rings.map((ring) => `M${ring.map(([x, y]) => `${x},${-y}`).join("L")}Z`).join("");

/** The zone within the buffer of the boundary: a line of twice its width, of which the window shows the inner half. */
function ground(map, area) {
  const { rings } = map.areas[area];
  if (rings.length === 0) return [];
  const outline = pathOf(rings);
  const inside = svg("clipPath", { id: "map-inside" }, svg("path", { d: outline, "clip-rule": "evenodd" }));
  const window = svg("path", { d: outline, class: "window", "fill-rule": "evenodd" });
  if (!(map.buffer > 0)) return [window];
  const zone = svg("path", { d: outline, class: "buffer", "clip-path": "url(#map-inside)", "stroke-width": 2 * map.buffer });
  return [svg("defs", {}, inside), window, zone];
}

function stemRadius(map, tree, unit) {
  const layer = map.layer[tree];
  return unit * (layer === null ? 1 : 0.7 + 0.45 * layer);
}

function stem(map, tree, classes, unit) {
  const code = map.species[tree];
  const kind = code === null ? "species-other" : classes.get(code);
  const layer = map.layer[tree] === null ? "" : ` layer-${map.layer[tree]}`;
  const at = { cx: map.x[tree], cy: -map.y[tree] };
  const parts = [svg("circle", { ...at, r: stemRadius(map, tree, unit), class: `stem ${kind}${layer}${map.core[tree] ? "" : " neighbor-only"}`, "data-tree": tree })];
  if (map.cw[tree] !== null) parts.unshift(svg("circle", { ...at, r: map.cw[tree] / 2, class: `crown ${kind}`, "data-tree": tree }));
  return parts;
}

const name = (map, tree) => `plot ${map.plot[tree]}, tree ${map.tree[tree]}`;
const measure = (label, value, digits, unit) => (value === null ? null : `${label} ${decimals(value, digits)}${unit}`);

/** What is said of a tree and its neighbors. */
function sentence(map, tree) {
  const species = map.species[tree] === null ? "no species" : map.species_names[map.species[tree]];
  const sizes = [measure("DBH", map.dbh[tree], 1, " cm"), measure("height", map.h[tree], 1, " m"), measure("crown width", map.cw[tree], 1, " m")];
  const indices = ["W", "M", "U", "C"].map((index) => measure(index, map[index][tree], 2, ""));
  const known = (parts) => parts.filter((part) => part !== null).join(", ");
  const neighbors = map.nearest[tree].map((other) => map.tree[other]);
  const place = map.core[tree] ? "" : " Near the edge: a neighbor only.";
  const unit = neighbors.length === 0 ? "It has no neighbors." : `${known(indices)}. Neighbors: trees ${listing(neighbors)}.`;
  return `${name(map, tree)}: ${species}, ${known(sizes)}.${place} ${unit}`.replace(/^p/, "P");
}

/** The way to a neighbor in pieces: one, or more where the edge is a torus and its nearest image lies beyond it. */
function wayTo(map, tree, other) {
  const [from, to] = [tree, other].map((one) => [map.x[one], map.y[one]]);
  const rings = map.areas[map.area[tree]]?.rings ?? [];
  return map.torus && rings.length > 0 ? wayAround(rectangleOf(rings), from, to) : [[from, to]];
}

/** Lines to the neighbors and a ring around the tree. */
function drawUnit(layer, map, tree, unit) {
  const pieces = map.nearest[tree].flatMap((other) => wayTo(map, tree, other));
  const lines = pieces.map(([[x1, y1], [x2, y2]]) => svg("line", { x1, y1: -y1, x2, y2: -y2, class: "unit" }));
  layer.replaceChildren(...lines, svg("circle", { cx: map.x[tree], cy: -map.y[tree], r: 4 * unit, class: "unit" }));
}

function legend(map, { order, classes }) {
  const shown = order.slice(0, COLORS).map((code) => [classes.get(code), map.species_names[code]]);
  if (order.length > COLORS) shown.push(["species-other", "other species"]);
  const key = (kind, text) => element("li", {}, element("span", { class: `dot ${kind}`, "aria-hidden": "true" }), text);
  const layers = map.layer_names.map((layer, index) => key(`layer-${index}`, `${layer} layer`));
  const buffer = map.buffer > 0 ? [key("zone", `buffer of ${map.buffer} m`)] : [];
  return element("ul", { class: "legend" }, ...shown.map(([kind, text]) => key(kind, text)), ...layers, ...buffer);
}

function drawing(map, area, palette, tell) {
  const trees = treesOf(map, area);
  const box = bounds(map, area, trees);
  const unit = Math.max(box.width, box.height) / 500;
  const overlay = svg("g");
  const stems = [...trees].sort((a, b) => (map.cw[b] ?? 0) - (map.cw[a] ?? 0)).map((tree) => stem(map, tree, palette.classes, unit));
  const crowns = stems.flatMap((parts) => parts.slice(0, -1));
  const dots = stems.flatMap((parts) => parts.slice(-1));
  const picture = svg(
    "svg",
    { viewBox: `${box.x} ${box.y} ${box.width} ${box.height}`, role: "img", "aria-label": `Map of ${plural(trees.length, "tree")} of ${areaName(map, area)}, north up; crowns to scale. The table indices.csv holds the same trees.` },
    ...ground(map, area),
    svg("g", {}, ...crowns),
    svg("g", {}, ...dots),
    overlay,
  );
  const show = (tree) => {
    drawUnit(overlay, map, tree, unit);
    tell(sentence(map, tree));
  };
  const pointed = (event) => {
    const tree = event.target.dataset?.tree;
    if (tree !== undefined) show(Number(tree));
  };
  picture.addEventListener("pointerover", pointed);
  picture.addEventListener("click", pointed);
  return { picture, trees, show };
}

const areaName = (map, area) => (map.areas[area].name === null ? "the stand" : `plot ${map.areas[area].name}`);

/** @param {PlotMap|undefined} map */
export function mapSection(map) {
  if (!map) return null;
  const palette = speciesClasses(map);
  const told = element("p", { class: "small told", "aria-live": "polite" }, "Point at a tree, or type its number, to see its structural unit.");
  const frame = element("div", { class: "map" });
  const select = element("select", {}, ...map.areas.map((_, area) => element("option", { value: area }, areaName(map, area))));
  const input = element("input", { type: "text", size: 8, autocomplete: "off" });
  let shown;
  const draw = () => {
    shown = drawing(map, Number(select.value), palette, (text) => (told.textContent = text));
    frame.replaceChildren(shown.picture);
  };
  select.addEventListener("change", draw);
  input.addEventListener("input", () => {
    const tree = shown.trees.find((one) => map.tree[one] === input.value.trim());
    if (tree !== undefined) shown.show(tree);
  });
  draw();
  return element(
    "section",
    { id: "map", "aria-labelledby": "map-title" },
    element("h2", { id: "map-title" }, "Plot map"),
    element("p", { class: "map-controls" }, element("label", {}, "Map of ", select), " ", element("label", {}, "Tree ", input)),
    legend(map, palette),
    frame,
    told,
  );
}
