// SPDX-License-Identifier: MIT
// The plot map: stems by species and layer, crowns to scale, the buffer zone, and the structural unit of a tree.
import { extent } from "./classes.js";
import { element, section, svg } from "./dom.js";
import { decimals, listing, plural } from "./format.js";
import { drawingText, framed } from "./map-frame.js";
import { pictureButtons } from "./picture.js";
import { inLight } from "./theme.js";
import { hideTip, showTip } from "./tip.js";
import { rectangleOf, wayAround } from "./torus.js";

const COLORS = 8;
const MARGIN = 2;
/** A tree of unknown height has no layer. */
const WITHOUT_HEIGHT = "without";

/** The eight species with the most trees have their own colors; all others share one. */
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
  const [[west, east], [south, north]] = [0, 1].map((axis) => extent(corners.map((corner) => corner[axis])));
  return { x: west - MARGIN, y: -north - MARGIN, width: east - west + 2 * MARGIN, height: north - south + 2 * MARGIN };
}

/** North is up: the sign of y is reversed, because y is drawn downwards. */
const pathOf = (rings) => rings.map((ring) => `M${ring.map(([x, y]) => `${x},${-y}`).join("L")}Z`).join("");

/** The buffer zone: a line of twice its width along the boundary, clipped to the window. */
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
  const kind = code === null ? "species-unknown" : classes.get(code);
  const layer = map.layer[tree] === null ? "" : ` layer-${map.layer[tree]}`;
  const at = { cx: map.x[tree], cy: -map.y[tree] };
  const parts = [svg("circle", { ...at, r: stemRadius(map, tree, unit), class: `stem ${kind}${layer}${map.core[tree] ? "" : " neighbor-only"}`, "data-tree": tree })];
  if (map.cw[tree] !== null) parts.unshift(svg("circle", { ...at, r: map.cw[tree] / 2, class: `crown ${kind}`, "data-tree": tree }));
  return parts;
}

const name = (map, tree) => `plot ${map.plot[tree]}, tree ${map.tree[tree]}`;
const measure = (label, value, digits, unit) => (value === null ? null : `${label} ${decimals(value, digits)}${unit}`);

const speciesOf = (map, tree) => (map.species[tree] === null ? "species unknown" : map.species_names[map.species[tree]]);
const known = (parts) => parts.filter((part) => part !== null).join(", ");

/** The sizes of a tree; missing measurements are shown as unknown. */
function sizes(map, tree) {
  const size = (label, column, unit) => measure(label, map[column][tree], 1, unit) ?? `${label} unknown`;
  return known([size("DBH", "dbh", " cm"), size("height", "h", " m"), size("crown width", "cw", " m")]);
}

/** The text about a tree and its neighbors. */
function sentence(map, tree) {
  const indices = ["W", "M", "U", "C"].map((index) => measure(index, map[index][tree], 2, ""));
  const neighbors = map.nearest[tree].map((other) => map.tree[other]);
  const place = map.core[tree] ? "" : " Near the edge: a neighbor only.";
  const values = known(indices) || "No structural indices";
  const unit = neighbors.length === 0 ? "It has no neighbors." : `${values}. Neighbors: trees ${listing(neighbors)}.`;
  return `${name(map, tree)}: ${speciesOf(map, tree)}, ${sizes(map, tree)}.${place} ${unit}`.replace(/^p/, "P");
}

/** The line to a neighbor in pieces: one, or more if the window is a torus and the nearest image is beyond its border. */
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
  if (map.species.includes(null)) shown.push(["species-unknown", "species unknown"]);
  const key = (kind, text) => element("li", {}, element("span", { class: `dot ${kind}`, "aria-hidden": "true" }), text);
  const layers = map.layer_names.map((layer, index) => key(`layer-${index}`, `${layer} layer`));
  const buffer = map.buffer > 0 ? [key("zone", `buffer of ${map.buffer} m`)] : [];
  return element("ul", { class: "legend" }, ...shown.map(([kind, text]) => key(kind, text)), ...layers, ...buffer);
}

const isInLayer = (map, layer) => (tree) => layer === "" || String(map.layer[tree] ?? WITHOUT_HEIGHT) === layer;

function drawing(map, area, layer, palette, room, tell) {
  const all = treesOf(map, area);
  const trees = all.filter(isInLayer(map, layer));
  // The same frame for every layer.
  const box = bounds(map, area, all);
  const unit = Math.max(box.width, box.height) / 500;
  const overlay = svg("g");
  const stems = [...trees].sort((a, b) => (map.cw[b] ?? 0) - (map.cw[a] ?? 0)).map((tree) => stem(map, tree, palette.classes, unit));
  const crowns = stems.flatMap((parts) => parts.slice(0, -1));
  const dots = stems.flatMap((parts) => parts.slice(-1));
  const label = `Map of ${plural(trees.length, "tree")} of ${areaName(map, area)}, north up, axes in meters; crowns to scale. The table indices.csv has the same trees.`;
  const picture = framed(box, room, { role: "img", "aria-label": label }, [...ground(map, area), svg("g", {}, ...crowns), svg("g", {}, ...dots), overlay]);
  const show = (tree) => {
    drawUnit(overlay, map, tree, unit);
    tell(sentence(map, tree));
  };
  const treeAt = ({ target }) => (target.dataset?.tree === undefined ? null : Number(target.dataset.tree));
  const pointed = (event) => {
    const tree = treeAt(event);
    if (tree !== null) show(tree);
  };
  const tip = (event) => {
    const tree = treeAt(event);
    if (tree === null) hideTip();
    else showTip(`Tree ${map.tree[tree]}: ${speciesOf(map, tree)}, ${sizes(map, tree)}`, event);
  };
  picture.addEventListener("pointerover", pointed);
  picture.addEventListener("click", pointed);
  picture.addEventListener("pointermove", tip);
  picture.addEventListener("pointerleave", hideTip);
  return { picture, trees, show };
}

const areaName = (map, area) => (map.areas[area].name === null ? "the stand" : `plot ${map.areas[area].name}`);

/** A note on trees without height or crown width. */
function unknownText(map, area) {
  const trees = treesOf(map, area);
  const lacking = (column) => trees.filter((tree) => map[column][tree] === null).length;
  const unplaced = map.area.filter((own, tree) => own === area && (map.x[tree] === null || map.y[tree] === null)).length;
  const parts = [
    [lacking("species"), "of unknown species (gray)"],
    [lacking("h"), "of unknown height (in no layer)"],
    [lacking("cw"), "of unknown crown width (no crown drawn)"],
    [unplaced, "without position (not drawn)"],
  ].filter(([number]) => number > 0);
  return parts.length === 0 ? "" : ` Among them: ${listing(parts.map(([number, what]) => `${plural(number, "tree")} ${what}`))}.`;
}

function layerChoice(map) {
  const option = (value, text) => element("option", { value }, text);
  const layers = map.layer_names.map((layer, index) => option(String(index), `${layer} layer`)).reverse();
  const without = map.layer.includes(null) ? [option(WITHOUT_HEIGHT, "unknown height")] : [];
  return element("select", {}, option("", "all layers"), ...layers, ...without);
}

/** The controls and the drawing that depends on them. */
class MapView {
  constructor(map) {
    this.map = map;
    this.palette = speciesClasses(map);
    this.told = element("p", { class: "small told", "aria-live": "polite" }, "Point at a tree, or type its number, to see its structural unit.");
    this.frame = element("div", { class: "map" });
    this.note = element("p", { class: "small" });
    this.area = element("select", {}, ...map.areas.map((_, area) => element("option", { value: area }, areaName(map, area))));
    this.layer = layerChoice(map);
    this.input = element("input", { type: "text", size: 8, autocomplete: "off" });
    [this.area, this.layer].forEach((select) => select.addEventListener("change", () => this.draw()));
    this.input.addEventListener("input", () => this.find(this.input.value.trim()));
    new ResizeObserver(() => this.drawIfResized()).observe(this.frame);
    this.draw();
  }

  room() {
    return { width: Math.min(900, this.frame.clientWidth || 700), height: Math.max(420, Math.min(760, 0.85 * innerHeight)) };
  }

  draw() {
    const room = this.room();
    this.width = room.width;
    this.shown = drawing(this.map, Number(this.area.value), this.layer.value, this.palette, room, (text) => (this.told.textContent = text));
    this.frame.replaceChildren(this.shown.picture);
    const layer = this.layer.value === "" ? "" : `, ${this.layer.selectedOptions[0].textContent}`;
    const what = areaName(this.map, Number(this.area.value)).replace(/^./, (first) => first.toUpperCase());
    this.note.textContent = `${what}${layer}: ${plural(this.shown.trees.length, "tree")}. North is up; crowns are to scale.${unknownText(this.map, Number(this.area.value))}`;
  }

  drawIfResized() {
    if (Math.abs(this.room().width - this.width) > 1) this.draw();
  }

  find(name) {
    const tree = this.shown.trees.find((one) => this.map.tree[one] === name);
    if (tree !== undefined) this.shown.show(tree);
    else if (name !== "") this.told.textContent = `There is no tree ${name} on this map.`;
  }

  panels() {
    const [, , width, height] = this.shown.picture.getAttribute("viewBox").split(" ").map(Number);
    return [{ svg: inLight(() => drawingText(this.shown.picture)), title: null, width, height }];
  }
}

/** @param {PlotMap|undefined} map */
export function mapSection(map) {
  if (!map) return null;
  const view = new MapView(map);
  const title = "Plot map: stems by species and layer, crowns, and structural units";
  const figure = element(
    "figure",
    { "data-panels": 1 },
    element("figcaption", {}, element("h3", {}, element("span", { class: "label" }), title), legend(map, view.palette), view.note),
    element("div", { class: "charts" }, view.frame),
    view.told,
  );
  figure.append(pictureButtons(figure, "Plot map", async () => view.panels()));
  const control = (text, input) => element("label", {}, text, input);
  return section(
    "map",
    "Plot map",
    {},
    element("p", { class: "map-controls" }, control("Map of ", view.area), " ", control("Layer ", view.layer), " ", control("Tree ", view.input)),
    figure,
  );
}
