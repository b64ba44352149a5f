// SPDX-License-Identifier: MIT
// Charts on the screen: drawn when they come into sight, and again when width or theme change or the page is printed.
import { compile, parse, View } from "./vega-parts.js";
import { specification } from "./chart-spec.js";
import { element } from "./dom.js";
import { onThemeChange } from "./theme.js";

/** @type {WeakMap<Element, import("./chart-spec.js").Chart>} */
const descriptions = new WeakMap();
/** @type {Map<Element, {view: View, width: number}>} */
const drawn = new Map();

/** Width over height, and greatest and least height in pixels. */
const SHAPE = 1.5;
const GREATEST_HEIGHT = 430;
/** So that "Height to crown base (m)" has room beside the axis. */
const LEAST_HEIGHT = 260;
/** The width of a chart on paper of A4, in CSS pixels, and the marks up to which it is printed as a drawing instead of a picture. */
const PAPER_WIDTH = 660;
const MOST_DRAWN_MARKS = 1500;

const KINDS = ["text", "grid", "paper", "point", "ols", "nlme", "guide", "first", "second", "third", "fourth", "fifth"];

/** An element that holds the chart once it is seen. */
export function chartElement(chart) {
  const node = element("div", { class: "chart", role: "img", "aria-label": chart.label, style: chart.height ? `min-height: ${chart.height}px` : null });
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

function size(node) {
  const own = Math.max(200, Math.floor(node.clientWidth));
  const paper = node.closest(".pair") ? PAPER_WIDTH / 2 : PAPER_WIDTH;
  const width = isPrinting() ? Math.min(own, paper) : own;
  const height = descriptions.get(node).height ?? Math.round(Math.min(GREATEST_HEIGHT, Math.max(LEAST_HEIGHT, width / SHAPE)));
  return { width, height };
}

/** On paper lines stay sharp if they are drawn, but thousands of points would make a file that nobody can open. */
function renderer({ layers }) {
  const marks = layers.reduce((sum, { values }) => sum + values.length, 0);
  return isPrinting() && marks <= MOST_DRAWN_MARKS ? "svg" : "canvas";
}

function draw(node) {
  drawn.get(node)?.view.finalize();
  const chart = descriptions.get(node);
  const { width, height } = size(node);
  const { spec } = compile(specification(chart, palette(), { width, height }));
  const view = new View(parse(spec), { renderer: renderer(chart) });
  // Vega gives its container a role and a label of its own; ours are those of the element around it.
  const container = element("div", { "aria-hidden": "true" });
  node.replaceChildren(container);
  view.initialize(container).run();
  node.dataset.drawn = "true";
  drawn.set(node, { view, width });
}

function drawIfResized(node) {
  if (!isPrinting() && drawn.has(node) && drawn.get(node).width !== size(node).width) draw(node);
}

const redraw = () => [...drawn.keys()].forEach(draw);

function followPrint(nodes) {
  const root = document.documentElement;
  addEventListener("beforeprint", () => {
    root.classList.add("print");
    nodes.forEach(draw);
  });
  addEventListener("afterprint", () => {
    root.classList.remove("print");
    redraw();
  });
}

/** Draws what is in sight, one chart a frame, so that scrolling stays smooth and what has passed by is left alone. */
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
