// SPDX-License-Identifier: MIT
// Convex hulls of points, and the intersection area of two of them.

const turn = ([ax, ay], [bx, by], [cx, cy]) => (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);

/** Corners of the convex hull, counterclockwise (Andrew 1979). @param {number[][]} corners */
export function hullOf(corners) {
  const sorted = [...corners].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (order) => {
    const kept = [];
    for (const corner of order) {
      while (kept.length > 1 && turn(kept.at(-2), kept.at(-1), corner) <= 0) kept.pop();
      kept.push(corner);
    }
    return kept.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}

/** Area of a polygon, counterclockwise. */
export function areaOf(polygon) {
  const [origin] = polygon;
  let twice = 0;
  for (let index = 1; index + 1 < polygon.length; ++index) twice += turn(origin, polygon[index], polygon[index + 1]);
  return twice / 2;
}

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
