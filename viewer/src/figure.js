// SPDX-License-Identifier: MIT
// The frame of a figure: heading, legend, charts, and the numbers behind them.
import { chartElement } from "./chart-view.js";
import { disclosure, element } from "./dom.js";

/**
 * @param {{title: string, legend?: [string, string][], note?: string | null, charts: HTMLElement[], behind: () => HTMLElement[]}} parts
 *   `legend`: kind of the key, and text; `behind` is called when the reader opens the numbers, or prints
 */
export function figure({ title, legend = [], note = null, charts, behind }) {
  const entries = legend.map(([kind, text]) => element("li", {}, element("span", { class: `key ${kind}`, "aria-hidden": "true" }), text));
  return element(
    "figure",
    {},
    element(
      "figcaption",
      {},
      element("h3", {}, title),
      entries.length > 0 ? element("ul", { class: "legend" }, ...entries) : null,
      note ? element("p", { class: "small" }, note) : null,
    ),
    element("div", { class: charts.length > 1 ? "charts pair" : "charts" }, ...charts),
    disclosure("The numbers behind this chart", behind),
  );
}

/** A chart under its own small heading. */
export const titled = (title, chart) => element("div", {}, element("h4", {}, title), chartElement(chart));
