// SPDX-License-Identifier: MIT
// The frame of a map: axes in meters, a scale bar and a north arrow around a picture in meters.
import { svg } from "./dom.js";
import { roundDown, roundUp } from "./format.js";

/** Space around the picture in pixels. */
const ROOM = { left: 62, right: 14, top: 34, bottom: 62 };
const LEAST_WIDTH = 300;
/** Pixels between two ticks, at least. */
const TICK_DISTANCE = 64;
/** Upper limit of the length of a scale bar, relative to the width. */
const BAR_SHARE = 0.28;

function ticks(low, high, step) {
  const first = Math.ceil(low / step - 1e-9);
  const number = Math.floor(high / step + 1e-9) - first + 1;
  return Array.from({ length: Math.max(0, number) }, (_, index) => Number(((first + index) * step).toPrecision(12)));
}

/** A coordinate with the page's minus sign. */
const named = (value) => String(value).replace("-", "\u2212");

const text = (content, x, y, attributes = {}) => svg("text", { x, y, class: "axis", ...attributes }, content);

function xAxis(box, scale, place) {
  const step = roundUp(TICK_DISTANCE / scale);
  const y = place.bottom;
  return [
    svg("line", { x1: place.left, x2: place.right, y1: y, y2: y, class: "axis" }),
    ...ticks(box.x, box.x + box.width, step).flatMap((value) => {
      const x = place.left + (value - box.x) * scale;
      return [svg("line", { x1: x, x2: x, y1: y, y2: y + 5, class: "axis" }), text(named(value), x, y + 19, { "text-anchor": "middle" })];
    }),
    text("x (m)", (place.left + place.right) / 2, y + 40, { "text-anchor": "middle" }),
  ];
}

function yAxis(box, scale, place) {
  const step = roundUp(TICK_DISTANCE / scale);
  const x = place.left;
  const middle = (place.top + place.bottom) / 2;
  return [
    svg("line", { x1: x, x2: x, y1: place.top, y2: place.bottom, class: "axis" }),
    ...ticks(-box.y - box.height, -box.y, step).flatMap((value) => {
      const y = place.top + (-value - box.y) * scale;
      return [svg("line", { x1: x - 5, x2: x, y1: y, y2: y, class: "axis" }), text(named(value), x - 8, y + 4, { "text-anchor": "end" })];
    }),
    text("y (m)", 13, middle, { "text-anchor": "middle", transform: `rotate(-90 13 ${middle})` }),
  ];
}

function scaleBar(scale, place) {
  const length = roundDown((BAR_SHARE * (place.right - place.left)) / scale);
  const [from, to, y] = [place.right - length * scale, place.right, place.bottom + 46];
  return svg(
    "g",
    { class: "scale-bar" },
    svg("path", { d: `M${from},${y - 5}V${y}H${to}V${y - 5}`, class: "bar" }),
    text(`${named(length)} m`, (from + to) / 2, y - 5, { "text-anchor": "middle" }),
  );
}

const northArrow = (place) =>
  svg("g", { class: "north", transform: `translate(${place.right - 10} ${place.top - 28})` }, svg("path", { d: "M0,0L6,20L0,15L-6,20Z", class: "arrow" }), text("N", -18, 16, { "text-anchor": "middle", "font-weight": 600 }));

/**
 * A picture in meters with its frame, in the available space.
 * @param {{x: number, y: number, width: number, height: number}} box  of the picture; y downwards: north is up if the sign of y is reversed
 * @param {{width: number, height: number}} room  in pixels
 * @param {Record<string, string | number>} attributes  of the whole drawing
 * @param {Node[]} content  in meters
 */
export function framed(box, room, attributes, content) {
  const across = Math.max(LEAST_WIDTH, room.width) - ROOM.left - ROOM.right;
  const scale = Math.min(across / box.width, (room.height - ROOM.top - ROOM.bottom) / box.height);
  const place = { left: ROOM.left, right: ROOM.left + box.width * scale, top: ROOM.top, bottom: ROOM.top + box.height * scale };
  const [width, height] = [place.right + ROOM.right, place.bottom + ROOM.bottom];
  return svg(
    "svg",
    { viewBox: `0 0 ${width} ${height}`, width, height, ...attributes },
    svg("g", { transform: `translate(${place.left - box.x * scale} ${place.top - box.y * scale}) scale(${scale})` }, ...content),
    ...xAxis(box, scale, place),
    ...yAxis(box, scale, place),
    scaleBar(scale, place),
    northArrow(place),
  );
}

const DRAWN = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-opacity", "stroke-linejoin", "font-size", "font-weight"];

/** The drawing as text, with the styles of the style sheet. */
export function drawingText(drawing) {
  const copy = drawing.cloneNode(true);
  const copies = copy.querySelectorAll("*");
  drawing.querySelectorAll("*").forEach((node, index) => {
    const style = getComputedStyle(node);
    DRAWN.forEach((name) => copies[index].setAttribute(name, style.getPropertyValue(name)));
    // Lines with a constant width on the screen have the same width in the drawing.
    if (style.vectorEffect === "non-scaling-stroke") {
      const scale = node.getScreenCTM().a / drawing.getScreenCTM().a;
      copies[index].setAttribute("stroke-width", Number.parseFloat(style.strokeWidth) / scale);
    }
  });
  return new XMLSerializer().serializeToString(copy);
}
