// SPDX-License-Identifier: MIT
// Charts on the screen: drawn when they come into sight, and again when width or theme change or the page is printed.
import { parse, View } from "./vega-parts.js";
import { specification } from "./chart-spec.js";
import { element } from "./dom.js";

/** @type {WeakMap<Element, import("./chart-spec.js").Chart>} */
const descriptions = new WeakMap();
/** @type {Map<Element, View>} */
const drawn = new Map();

/** Width over height, and the greatest height in pixels. */
const SHAPE = 1.5;
const GREATEST_HEIGHT = 430;

/** An element that holds the chart once it is seen. */
export function chartElement(chart) {
  const node = element("div", { class: "chart", role: "img", "aria-label": chart.label });
  descriptions.set(node, chart);
  return node;
}

/** @returns {import("./chart-spec.js").Palette} */
function palette() {
  const style = getComputedStyle(document.documentElement);
  const named = (name) => style.getPropertyValue(`--${name}`).trim();
  return {
    text: named("text"),
    grid: named("grid"),
    point: named("point"),
    ols: named("ols"),
    nlme: named("nlme"),
    guide: named("guide"),
    font: getComputedStyle(document.body).fontFamily,
  };
}

function size(node) {
  const width = Math.max(200, Math.floor(node.clientWidth));
  return { width, height: Math.round(Math.min(GREATEST_HEIGHT, Math.max(220, width / SHAPE))) };
}

function draw(node) {
  drawn.get(node)?.finalize();
  const chart = descriptions.get(node);
  const view = new View(parse(specification(chart, palette(), size(node))), { renderer: "canvas" });
  view.initialize(node).run();
  // Vega marks up its own graphics; the one text alternative is the label of the element around it.
  node.querySelector(".marks, canvas")?.setAttribute("aria-hidden", "true");
  node.dataset.drawn = "true";
  drawn.set(node, view);
}

function resize(node) {
  const view = drawn.get(node);
  const { width, height } = size(node);
  if (view && (view.width() !== width || view.height() !== height)) view.width(width).height(height).run();
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

/** @param {Iterable<Element>} elements  made by chartElement */
export function drawChartsWhenSeen(elements) {
  const nodes = [...elements];
  const resized = new ResizeObserver((entries) => entries.forEach(({ target }) => resize(target)));
  const seen = new IntersectionObserver(
    (entries) =>
      entries
        .filter(({ isIntersecting, target }) => isIntersecting && !drawn.has(target))
        .forEach(({ target }) => {
          draw(target);
          resized.observe(target);
        }),
    { rootMargin: "400px" },
  );
  nodes.forEach((node) => seen.observe(node));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  followPrint(nodes);
}
