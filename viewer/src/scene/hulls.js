// SPDX-License-Identifier: MIT
// Convex hulls of points, and the intersection area of two of them.
import { polygonArea, polygonHull } from "d3-polygon";

const turn = ([ax, ay], [bx, by], [cx, cy]) => (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);

/** Corners of the convex hull, counterclockwise; none without an area. @param {number[][]} corners */
export const hullOf = (corners) => (polygonHull(corners) ?? []).reverse();

/** Area of a polygon. */
export const areaOf = (polygon) => Math.abs(polygonArea(polygon));

/** The part of a convex polygon to the left of a line. */
function leftOf(polygon, from, to) {
  const kept = [];
  polygon.forEach((corner, index) => {
    const next = polygon[(index + 1) % polygon.length];
    const [here, there] = [turn(from, to, corner), turn(from, to, next)];
    if (here >= 0) kept.push(corner);
    if (here < 0 !== there < 0) kept.push(corner.map((value, axis) => value + (here / (here - there)) * (next[axis] - value)));
  });
  return kept;
}

/** Intersection area of two convex polygons (Sutherland and Hodgman 1974); 0 if they touch. */
export function sharedArea(first, second) {
  const shared = first.reduce((rest, corner, index) => leftOf(rest, corner, first[(index + 1) % first.length]), second);
  return shared.length < 3 ? 0 : areaOf(shared);
}
