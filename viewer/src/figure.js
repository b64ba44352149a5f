// SPDX-License-Identifier: MIT
// The frame of a figure: numbered heading, legend, charts, the numbers behind them, and buttons that save it as a picture.
import { chartElement } from "./chart-view.js";
import { disclosure, element } from "./dom.js";
import { pictureButtons } from "./picture.js";

/**
 * @param {{title: string, legend?: [string, string][], note?: string | null, charts: HTMLElement[], behind: () => HTMLElement[]}} parts
 *   `legend`: kind of the key, and text; `behind` is called when the reader opens the numbers
 */
export function figure({ title, legend = [], note = null, charts, behind }) {
  const entries = legend.map(([kind, text]) => element("li", {}, element("span", { class: `key ${kind}`, "aria-hidden": "true" }), text));
  const node = element(
    "figure",
    { "data-panels": charts.length },
    element(
      "figcaption",
      {},
      element("h3", {}, element("span", { class: "label" }), title),
      entries.length > 0 ? element("ul", { class: "legend" }, ...entries) : null,
      note ? element("p", { class: "small" }, note) : null,
    ),
    element("div", { class: charts.length > 1 ? "charts pair" : "charts" }, ...charts),
    disclosure("The numbers behind this chart", behind),
  );
  node.append(pictureButtons(node, title));
  return node;
}

/** A chart under its own small heading. */
export const titled = (title, chart) => element("div", {}, element("h4", {}, title), chartElement(chart));
