// SPDX-License-Identifier: MIT
// Charts on the screen: drawn when they become visible, and again when width or theme change or the page is printed.
import { compile, viewOf } from "./vega-parts.js";
import { specification } from "./chart-spec.js";
import { element } from "./dom.js";
import { inLight, onThemeChange } from "./theme.js";
import { hideTip, showTip } from "./tip.js";

/** @type {WeakMap<Element, import("./chart-spec.js").Chart>} */
const descriptions = new WeakMap();
/** @type {Map<Element, {view: import("vega-view").View, width: number}>} */
const drawn = new Map();

/** Ratio of width to height, and largest and smallest height in pixels. */
const SHAPE = 1.5;
const GREATEST_HEIGHT = 430;
/** High enough for "Height to crown base (m)" beside the axis. */
const LEAST_HEIGHT = 260;
/** On paper a figure's charts are beside its caption: their total width in CSS pixels on A4, and the space between two. */
const PAPER_WIDTH = 480;
const PAPER_GAP = 12;
/** Smallest and largest height of a chart on paper. */
const PAPER_HEIGHT = [160, 200];
const LEAST_PAPER_HEIGHT = 110;
/** Largest number of marks of a chart that is printed as a drawing; others are printed as a picture. */
const MOST_DRAWN_MARKS = 300;
/** Pixels of such a picture per pixel of the page. */
const PICTURE_SCALE = 2;
/** Size of letters on paper relative to the screen. */
const PAPER_LETTERS = 0.8;

const KINDS = ["text", "grid", "paper", "point", "ols", "nlme", "guide", "first", "second", "third", "fourth", "fifth"];

/** An element in which the chart is drawn when it becomes visible. */
export function chartElement(chart) {
  const node = element("div", { class: "chart", role: "img", "aria-label": chart.label });
  // The content security policy forbids style attributes.
  if (chart.height) node.style.minHeight = `${chart.height}px`;
  descriptions.set(node, chart);
  return node;
}

/** @returns {import("./chart-spec.js").Palette} */
function palette() {
  const style = getComputedStyle(document.documentElement);
  const colors = Object.fromEntries(KINDS.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
  return { ...colors, plot: colors.nlme, limit: colors.guide, font: getComputedStyle(document.body).fontFamily };
}

const isPrinting = () => document.documentElement.classList.contains("print");

const limited = (value, [least, greatest]) => Math.round(Math.min(greatest, Math.max(least, value)));

function paperSize(node) {
  const panels = Number(node.closest("figure").dataset.panels);
  const columns = panels % 3 === 0 ? 3 : Math.min(2, panels);
  const width = (PAPER_WIDTH - (columns - 1) * PAPER_GAP) / columns;
  const { height } = descriptions.get(node);
  return { width, height: height ? limited(height * PAPER_LETTERS, [LEAST_PAPER_HEIGHT, height]) : limited(width / SHAPE, PAPER_HEIGHT), letters: PAPER_LETTERS, isPaper: true };
}

function size(node) {
  if (isPrinting()) return paperSize(node);
  const width = Math.max(200, Math.floor(node.clientWidth));
  return { width, height: descriptions.get(node).height ?? limited(width / SHAPE, [LEAST_HEIGHT, GREATEST_HEIGHT]), letters: 1 };
}

/** Drawings are sharp on paper, but with thousands of points the file would be too large to open. */
function isDrawnOnPaper({ layers }) {
  return layers.reduce((sum, { values }) => sum + values.length, 0) <= MOST_DRAWN_MARKS;
}

/** Browsers print a canvas point by point, but a picture as a picture. */
async function paintPicture(view, container, { width, height }) {
  await view.initialize(container).runAsync();
  const source = container.querySelector("canvas").toDataURL("image/jpeg", 0.9);
  container.replaceChildren(element("img", { src: source, width, height, alt: "" }));
}

/** Vega reads the number of canvas pixels per page pixel from the window. */
function setPixels(scale) {
  if (scale === null) delete window.devicePixelRatio;
  else Object.defineProperty(window, "devicePixelRatio", { value: scale, configurable: true });
}

const compiled = (chart, size) => compile(specification(chart, palette(), size)).spec;

function tooltip(_, event, __, value) {
  if (value) showTip(value, event);
  else hideTip();
}

function draw(node) {
  drawn.get(node)?.view.finalize();
  const chart = descriptions.get(node);
  const dimensions = size(node);
  const isPicture = isPrinting() && !isDrawnOnPaper(chart);
  const view = viewOf(compiled(chart, dimensions), { renderer: isPrinting() && !isPicture ? "svg" : "canvas", tooltip });
  // Vega sets a role and a label on its container; the element around it has the correct ones.
  const container = element("div", { "aria-hidden": "true" });
  node.replaceChildren(container);
  if (isPicture) paintPicture(view, container, dimensions);
  else view.initialize(container).run();
  node.dataset.drawn = "true";
  drawn.set(node, { view, width: dimensions.width });
}

/** A chart as the text of an SVG file in light colors, with its height. */
export async function chartSvg(node, { width, height: usual }) {
  const chart = descriptions.get(node);
  const height = chart.height ?? usual;
  const view = viewOf(inLight(() => compiled(chart, { width, height, letters: 1 })), { renderer: "none" });
  const svg = await view.toSVG();
  view.finalize();
  return { svg, height };
}

function drawIfResized(node) {
  if (!isPrinting() && drawn.has(node) && drawn.get(node).width !== size(node).width) draw(node);
}

const redraw = () => [...drawn.keys()].forEach(draw);

function followPrint(nodes) {
  const root = document.documentElement;
  addEventListener("beforeprint", () => {
    root.classList.add("print");
    setPixels(PICTURE_SCALE);
    nodes.forEach(draw);
  });
  addEventListener("afterprint", () => {
    root.classList.remove("print");
    setPixels(null);
    redraw();
  });
}

/** Draws visible charts, one per frame, so that scrolling is smooth and charts that were scrolled past are skipped. */
function drawer(afterwards) {
  const waiting = new Set();
  let isBusy = false;
  const step = () => {
    const [node] = waiting;
    isBusy = node !== undefined;
    if (!isBusy) return;
    waiting.delete(node);
    if (!drawn.has(node)) draw(node);
    afterwards(node);
    requestAnimationFrame(step);
  };
  return ({ isIntersecting, target }) => {
    if (isIntersecting && !drawn.has(target)) waiting.add(target);
    else waiting.delete(target);
    if (!isBusy) requestAnimationFrame(step);
    isBusy = true;
  };
}

/** @param {Iterable<Element>} elements  made by chartElement */
export function drawChartsWhenSeen(elements) {
  const nodes = [...elements];
  const resized = new ResizeObserver((entries) => entries.forEach(({ target }) => drawIfResized(target)));
  const inSight = drawer((node) => resized.observe(node));
  const seen = new IntersectionObserver((entries) => entries.forEach(inSight), { rootMargin: "400px" });
  nodes.forEach((node) => seen.observe(node));
  onThemeChange(redraw);
  followPrint(nodes);
}
