// SPDX-License-Identifier: MIT
// From a chart's description to its Vega specification: points, lines, guides. All charts of the report are of this one kind.

/**
 * @typedef {{x: number, y: number, tip: string}} Point
 * @typedef {"ols" | "nlme" | "plot" | "guide" | "limit"} Kind  decides color and stroke
 * @typedef {{kind: Kind, values: {x: number, y: number | null}[]}} Line
 * @typedef {{label: string, x: string, y: string, points: Point[], lines: Line[], pointKind?: Kind,
 *   xDomain: [number, number], yDomain: [number, number], zero?: boolean}} Chart
 *   `x` and `y` are axis titles with units, `label` the text alternative
 * @typedef {{text: string, grid: string, point: string, ols: string, nlme: string, guide: string, font: string}} Palette
 */

const WIDTH = { ols: 2.5, nlme: 2.5, plot: 1, guide: 1.2, limit: 1 };
const DASH = { ols: [7, 4], nlme: [], plot: [], guide: [], limit: [3, 4] };
const OPACITY = { ols: 1, nlme: 1, plot: 0.7, guide: 1, limit: 1 };

const color = (kind, palette) => ({ ols: palette.ols, nlme: palette.nlme, plot: palette.nlme }[kind] ?? palette.guide);

/** Many points must not hide each other. */
const pointOpacity = (number) => Math.max(0.25, Math.min(0.75, 12 / Math.sqrt(number + 1)));

function scale(name, range, domain) {
  return { name, type: "linear", range, domain, nice: true, zero: false };
}

function axis(orient, name, title, palette) {
  return {
    orient,
    scale: name,
    title,
    grid: true,
    domain: false,
    ticks: false,
    tickCount: orient === "bottom" ? { signal: "ceil(width / 70)" } : { signal: "ceil(height / 45)" },
    labelPadding: 6,
    labelColor: palette.text,
    titleColor: palette.text,
    gridColor: palette.grid,
    labelFont: palette.font,
    titleFont: palette.font,
    labelFontSize: 12,
    titleFontSize: 13,
    titleFontWeight: 600,
    titlePadding: 8,
  };
}

function pointMark(chart, palette) {
  const fill = chart.pointKind ? color(chart.pointKind, palette) : palette.point;
  return {
    type: "symbol",
    from: { data: "points" },
    encode: {
      enter: {
        size: { value: 22 },
        fill: { value: fill },
        fillOpacity: { value: pointOpacity(chart.points.length) },
        tooltip: { field: "tip" },
      },
      update: { x: { scale: "x", field: "x" }, y: { scale: "y", field: "y" } },
    },
  };
}

function lineMark(line, index, palette) {
  return {
    type: "line",
    interactive: false,
    clip: true,
    from: { data: `line${index}` },
    encode: {
      enter: {
        stroke: { value: color(line.kind, palette) },
        strokeWidth: { value: WIDTH[line.kind] },
        strokeDash: { value: DASH[line.kind] },
        strokeOpacity: { value: OPACITY[line.kind] },
        defined: { signal: "isValid(datum.y)" },
      },
      update: { x: { scale: "x", field: "x" }, y: { scale: "y", field: "y" } },
    },
  };
}

/** Points lie over the guides and under the curves. */
const isUnderPoints = ({ kind }) => kind === "guide" || kind === "limit";

/**
 * @param {Chart} chart
 * @param {Palette} palette
 * @param {{width: number, height: number}} size  of the whole chart, axes and all, in CSS pixels
 */
export function specification(chart, palette, size) {
  const marks = chart.lines.map((line, index) => ({ line, mark: lineMark(line, index, palette) }));
  return {
    ...size,
    padding: 2,
    autosize: { type: "fit", contains: "padding" },
    background: null,
    data: [
      { name: "points", values: chart.points },
      ...chart.lines.map((line, index) => ({ name: `line${index}`, values: line.values })),
    ],
    scales: [scale("x", "width", chart.xDomain), scale("y", "height", chart.yDomain)],
    axes: [axis("bottom", "x", chart.x, palette), axis("left", "y", chart.y, palette)],
    marks: [
      ...marks.filter(({ line }) => isUnderPoints(line)).map(({ mark }) => mark),
      pointMark(chart, palette),
      ...marks.filter(({ line }) => !isUnderPoints(line)).map(({ mark }) => mark),
    ],
  };
}
