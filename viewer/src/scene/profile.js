// SPDX-License-Identifier: MIT
// A cross-section of the stand: the trees of a strip, seen from the side, with the outlines of their crowns to scale.
import { crownOf, placeOf } from "./data.js";
import { relativeWidth } from "./crown.js";

const DIRECTIONS = {
  east: { along: ({ x }) => x, away: ({ z }) => -z, left: "west", right: "east" },
  north: { along: ({ z }) => -z, away: ({ x }) => x, left: "south", right: "north" },
};

/**
 * @typedef {object} Strip
 * @property {"east" | "north"} direction  that the drawing shows from left to right
 * @property {number} middle  coordinate of the strip's middle line: north for a strip to the east, east for one to the north [m]
 * @property {number} width   [m]
 */

/** Offsets of the frame of the page: its coordinates are relative to the origin. */
const originOf = (data, direction) => (direction === "east" ? { along: data.origin.x, away: data.origin.y } : { along: data.origin.y, away: data.origin.x });

/** The outline of a crown from the side, as points [along, up] around it. */
function outlineOf(crown, { left, right }) {
  const STEPS = 24;
  const heights = Array.from({ length: STEPS + 1 }, (_, step) => crown.hcb + ((crown.h - crown.hcb) * step) / STEPS);
  const side = (radius, sign) => heights.map((height) => [sign * radius * relativeWidth(crown, height), height]);
  return [...side(crown[right], 1), ...side(crown[left], -1).reverse()];
}

/**
 * The trees whose stems are in a strip, those farthest from the viewer first. The viewer of a strip to the east is in the south, of one to the north in the east.
 * @param {(tree: number) => boolean} passes
 * @returns {{tree: number, at: number, outline: number[][], stem: {radius: number, height: number}}[]}  `at` in the inventory's coordinate [m]
 */
export function profileOf(data, variant, { direction, middle, width }, passes) {
  const sides = DIRECTIONS[direction];
  const origin = originOf(data, direction);
  const found = [];
  for (let tree = 0; tree < data.trees.tree.length; ++tree) {
    if (!passes(tree)) continue;
    const place = placeOf(data, tree);
    const away = sides.away(place) + origin.away - middle;
    if (Math.abs(away) > width / 2) continue;
    const crown = crownOf(data, variant, tree);
    if (!crown) continue;
    const dbh = data.trees.dbh[tree];
    found.push({
      tree,
      at: sides.along(place) + origin.along,
      depth: direction === "east" ? away : -away,
      outline: outlineOf(crown, sides),
      stem: { radius: dbh === null ? 0.05 : dbh / 200, height: crown.h },
    });
  }
  return found.sort((a, b) => b.depth - a.depth);
}

/** The strip through the middle of the shown trees, 10 m wide. */
export function usualStrip(data, direction, passes) {
  const values = data.trees.tree.map((_, tree) => tree).filter(passes).map((tree) => data.trees[direction === "east" ? "y" : "x"][tree]);
  const middle = values.length > 0 ? (Math.min(...values) + Math.max(...values)) / 2 : 0;
  return { direction, middle: Math.round(10 * middle) / 10, width: 10 };
}

/** Horizontal, vertical and straight distance of two points [m]. */
export function distanceOf([x1, y1], [x2, y2]) {
  const horizontal = Math.abs(x2 - x1);
  const vertical = Math.abs(y2 - y1);
  return { horizontal, vertical, straight: Math.hypot(horizontal, vertical) };
}
