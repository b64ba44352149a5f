// SPDX-License-Identifier: MIT
// The legend of the colors, as swatches and text.
import { element } from "../dom.js";

const square = (color) => {
  const node = element("span", { class: "swatch", "aria-hidden": "true" });
  node.style.background = color;
  return node;
};

function scaleBar({ colors, labels }) {
  const bar = element("div", { class: "ramp", "aria-hidden": "true" });
  bar.style.background = `linear-gradient(to right, ${colors.join(", ")})`;
  return element("div", {}, bar, element("div", { class: "ramp-labels" }, ...labels.map((label) => element("span", {}, label))));
}

/** @param {{title: string, told: string, keys?: {color: string, text: string}[], scale?: object} | null} coloring  @returns {Node[]} */
export function legend(coloring) {
  if (coloring === null) return [element("p", { class: "quiet" }, "Bark and leaves have the colors of their species preset.")];
  const nodes = [element("p", {}, coloring.told)];
  if (coloring.scale) nodes.push(scaleBar(coloring.scale));
  if (coloring.keys) nodes.push(element("ul", { class: "keys" }, ...coloring.keys.map(({ color, text }) => element("li", {}, square(color), text))));
  return nodes;
}
