// SPDX-License-Identifier: MIT
// From a chart's description to its Vega-Lite specification: layers of a few kinds over two common axes.

/**
 * @typedef {"ols" | "nlme" | "plot" | "guide" | "limit" | "point" | "first" | "second" | "third" | "fourth" | "fifth"} Kind
 *   decides color and stroke; first to fifth are ordered classes
 * @typedef {{title: string | null, domain: [number, number] | string[], labels?: boolean, ticks?: number[]}} Axis
 *   `domain` of texts: rows from top to bottom
 * @typedef {{x: number | string, y: number | string | null, tip?: string, kind?: Kind}} Datum
 * @typedef {{mark: "points" | "line" | "band" | "boxes" | "intervals" | "labels", kind: Kind, values: Datum[], thin?: boolean, dash?: boolean}} Layer
 * @typedef {{label: string, x: Axis, y: Axis, layers: Layer[], labelSpace?: number, height?: number}} Chart
 *   `label` is the text alternative, `labelSpace` the space in pixels at the right for labels of lines
 * @typedef {Record<Kind | "text" | "grid" | "font" | "paper", string>} Palette
 */

const WIDTH = { plot: 1, guide: 1.2, limit: 1 };
const DASH = { ols: [7, 4], limit: [3, 4] };
const OPACITY = { plot: 0.55 };
const LABEL_DISTANCE = 15;
/** Height of a chart's axes, approximately. */
const AXIS_HEIGHT = 50;

/** Opacity of points: lower for many points. */
const pointOpacity = (number) => Math.max(0.25, Math.min(0.75, 12 / Math.sqrt(number + 1)));

const isText = ({ domain }) => typeof domain[0] === "string";

function position(axis) {
  if (isText(axis)) return { type: "ordinal", sort: null, scale: { domain: axis.domain, padding: 0.5 }, axis: { grid: true, labels: axis.labels !== false } };
  return { type: "quantitative", scale: { domain: axis.domain, nice: !axis.ticks, zero: false }, ...(axis.ticks ? { axis: { values: axis.ticks, labelOverlap: true } } : {}) };
}

/** The encodings that all layers of a chart share, so that Vega-Lite gives them one scale and one axis. */
function positions({ x, y }) {
  return { x: { field: "x", title: x.title, ...position(x) }, y: { field: "y", title: y.title, ...position(y) } };
}

const tooltip = (values) => (values.some(({ tip }) => tip) ? { tooltip: { field: "tip", type: "nominal" } } : {});

/** Kinds of single data; one list, so that all layers of a chart share one scale. */
const DATUM_KINDS = ["ols", "nlme", "point", "first", "second", "third", "fourth", "fifth"];

/** A color for the layer, or one for each datum with its own kind. */
function colored(layer, palette) {
  if (!layer.values.some(({ kind }) => kind)) return { color: { value: palette[layer.kind] } };
  const range = DATUM_KINDS.map((kind) => palette[kind]);
  return { color: { field: "kind", type: "nominal", legend: null, scale: { domain: DATUM_KINDS, range } } };
}

function points(layer, encoding, palette) {
  const mark = { type: "circle", size: layer.large ? 70 : 24, opacity: layer.large ? 1 : pointOpacity(layer.values.length) };
  return [{ mark, encoding: { ...encoding, ...colored(layer, palette), ...tooltip(layer.values) } }];
}

function line(layer, encoding, palette, chart, { isPaper }) {
  const mark = {
    type: "line",
    clip: true,
    color: palette[layer.kind],
    strokeWidth: layer.thin ? 1 : WIDTH[layer.kind] ?? 2.5,
    strokeDash: layer.dash ? DASH.ols : DASH[layer.kind] ?? [1, 0],
    opacity: OPACITY[layer.kind] ?? 1,
  };
  return [{ mark, encoding }, ...(isPaper ? [] : lineTips(layer, encoding))];
}

/** Invisible points along a line, for tooltips with its values. */
function lineTips(layer, encoding) {
  if (!layer.values.some(({ tip }) => tip)) return [];
  return [{ mark: { type: "circle", size: 90, opacity: 0, clip: true }, encoding: { ...encoding, ...tooltip(layer.values) } }];
}

function band(layer, encoding, palette) {
  const { y } = encoding;
  return [{ mark: { type: "area", clip: true, color: palette[layer.kind], opacity: 0.16 }, encoding: { ...encoding, y: { ...y, field: "low" }, y2: { field: "high" } } }];
}

/** Boxes from the first to the third quartile, a line at the median, a cross at the mean, whiskers to `low` and `high`. */
function boxes(layer, encoding, palette) {
  const { x, y } = encoding;
  const color = palette[layer.kind];
  const upright = (low, high) => ({ x, y: { ...y, field: low }, y2: { field: high } });
  const across = { x: { ...x, field: "left" }, x2: { field: "right" } };
  return [
    { mark: { type: "rule", color, strokeWidth: 1.2 }, encoding: upright("low", "high") },
    { mark: { type: "rect", color, fillOpacity: 0.22, stroke: color, strokeWidth: 1.2 }, encoding: { ...upright("q1", "q3"), ...across, ...tooltip(layer.values) } },
    { mark: { type: "rule", color, strokeWidth: 3 }, encoding: { ...across, y: { ...y, field: "median" } } },
    { mark: { type: "point", shape: "cross", filled: true, color, stroke: palette.paper, strokeWidth: 1, size: 70 }, encoding: { x, y: { ...y, field: "mean" }, ...tooltip(layer.values) } },
  ];
}

/** Lines along x from `low` to `high`. */
function intervals(layer, encoding, palette) {
  const { x, y } = encoding;
  return [{ mark: { type: "rule", color: palette[layer.kind], strokeWidth: layer.thin ? 1.2 : 2.5, opacity: layer.thin ? 1 : 0.5 }, encoding: { x: { ...x, field: "low" }, x2: { field: "high" }, y } }];
}

/** Labels that would overlap are moved apart, from the lowest upwards. */
export function apart(values, distance, greatest) {
  const sorted = [...values].sort((a, b) => a.y - b.y).map((value) => ({ ...value }));
  for (let index = 1; index < sorted.length; ++index) {
    sorted[index].y = Math.max(sorted[index].y, sorted[index - 1].y + distance);
  }
  for (let index = sorted.length - 1, limit = greatest; index >= 0; --index, limit -= distance) {
    sorted[index].y = Math.min(sorted[index].y, limit);
  }
  return sorted;
}

function labels(layer, encoding, palette, chart, size) {
  const { domain } = chart.y;
  const distance = (LABEL_DISTANCE * (domain[1] - domain[0])) / Math.max(1, size.height - AXIS_HEIGHT);
  const values = isText(chart.y) ? layer.values : apart(layer.values, distance, domain[1]);
  const mark = { type: "text", align: "left", baseline: "middle", dx: 7, fontSize: 12 * (size.letters ?? 1), fontWeight: 600 };
  return [{ data: { values }, mark, encoding: { ...encoding, text: { field: "text", type: "nominal" }, ...colored(layer, palette) } }];
}

const DRAW = { points, line, band, boxes, intervals, labels };

/** The width of row names is limited on a narrow screen, so that the rows have enough space. */
const LABEL_SHARE = 0.34;
const GREATEST_LABEL = 200;

function configuration(palette, { width, letters = 1 }) {
  return {
    font: palette.font,
    view: { stroke: null },
    axis: {
      grid: true,
      domain: false,
      ticks: false,
      labelPadding: 6,
      labelColor: palette.text,
      titleColor: palette.text,
      gridColor: palette.grid,
      labelFontSize: 12 * letters,
      titleFontSize: 12.5 * letters,
      titleFontWeight: 600,
      titlePadding: 8,
      labelLimit: Math.min(GREATEST_LABEL, LABEL_SHARE * width),
    },
    axisX: { tickCount: { signal: "ceil(width / 70)" } },
    axisY: { tickCount: { signal: "ceil(height / 45)" } },
  };
}

/**
 * @param {Chart} chart
 * @param {Palette} palette
 * @param {{width: number, height: number, letters?: number, isPaper?: boolean}} size  of the whole chart with its axes, in CSS pixels; `letters`: size of letters relative to that on the screen
 */
export function specification(chart, palette, size) {
  const encoding = positions(chart);
  return {
    width: size.width,
    height: size.height,
    padding: { left: 2, top: 6, bottom: 2, right: 8 + (chart.labelSpace ?? 0) },
    autosize: { type: "fit", contains: "padding" },
    background: size.isPaper ? "#ffffff" : null,
    config: configuration(palette, size),
    layer: chart.layers
      .filter(({ values }) => values.length > 0)
      .flatMap((layer) => DRAW[layer.mark](layer, encoding, palette, chart, size).map((drawn) => ({ data: { values: layer.values }, ...drawn }))),
  };
}
