// SPDX-License-Identifier: MIT
// Lines across the borders of a rectangle whose opposite sides are joined.
import { extent } from "./classes.js";

/** The rectangle round rings of corners. */
export function rectangleOf(rings) {
  const ends = [0, 1].map((axis) => extent(rings.flat().map((corner) => corner[axis])));
  return { low: ends.map(([low]) => low), high: ends.map(([, high]) => high) };
}

/**
 * The line from a point to the nearest image of another, cut at the borders that it crosses.
 * @param {{low: number[], high: number[]}} rectangle
 * @param {number[]} from  x, y, in the rectangle
 * @param {number[]} to
 * @returns {[number[], number[]][]}  ends of its pieces, all in the rectangle
 */
export function wayAround({ low, high }, from, to) {
  const size = [high[0] - low[0], high[1] - low[1]];
  const step = [0, 1].map((axis) => to[axis] - from[axis] - size[axis] * Math.round((to[axis] - from[axis]) / size[axis]));
  const at = (share) => [0, 1].map((axis) => from[axis] + share * step[axis]);
  const crossings = [0, 1].flatMap((axis) => [low[axis], high[axis]].map((border) => (border - from[axis]) / step[axis]));
  const shares = [0, ...crossings.filter((share) => share > 0 && share < 1).sort((a, b) => a - b), 1];
  return shares.slice(1).flatMap((share, index) => {
    if (share === shares[index]) return [];
    // The middle of a piece determines its image of the rectangle.
    const shift = at((shares[index] + share) / 2).map((value, axis) => size[axis] * Math.floor((value - low[axis]) / size[axis]));
    return [[at(shares[index]), at(share)].map((end) => end.map((value, axis) => value - shift[axis]))];
  });
}
