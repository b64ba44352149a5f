// SPDX-License-Identifier: MIT
// The crown curve, as in libtree's crown.hpp: up(x) = H - (H - Hc)(x/R)^up, down(x) = Hb + (Hc - Hb)(x/R)^down.
import { quadtree } from "d3-quadtree";

/** Crown radius towards (x east, z south): between the four measured ones by cos^2 and sin^2 of the azimuth [m]. */
export function radiusTowards(crown, x, z) {
  const square = x * x + z * z;
  const share = square > 0 ? (x * x) / square : 1;
  return (x >= 0 ? crown.east : crown.west) * share + (z >= 0 ? crown.south : crown.north) * (1 - share);
}

export const upper = (crown, share) => crown.h - (crown.h - crown.hc) * share ** crown.up;
export const lower = (crown, share) => crown.hcb + (crown.hc - crown.hcb) * share ** crown.down;

/** Width of the crown at a height relative to its widest; 0 outside. */
export function relativeWidth(crown, y) {
  if (y < crown.hcb || y > crown.h) return 0;
  if (y >= crown.hc) return crown.h > crown.hc ? ((crown.h - y) / (crown.h - crown.hc)) ** (1 / crown.up) : 1;
  return ((y - crown.hcb) / (crown.hc - crown.hcb)) ** (1 / crown.down);
}

/** Whether a point, x east, y up, z south of the stem base, is in the crown. */
export function contains(crown, x, y, z) {
  const width = relativeWidth(crown, y);
  return width > 0 && Math.hypot(x, z) <= width * radiusTowards(crown, x, z);
}

/** For two positioned crowns: horizontal distance of the stems and the sum of the facing radii [m]. */
export function facing(first, second) {
  const x = second.place.x - first.place.x;
  const z = second.place.z - first.place.z;
  return { distance: Math.hypot(x, z), radii: radiusTowards(first.crown, x, z) + radiusTowards(second.crown, -x, -z) };
}

/**
 * Pairs of trees whose facing radii add up to more than their distance. Each tree is compared with those of its own reach or less: one
 * wide crown needs one test by each of the others, not a search of each among all.
 * @param {({crown: object, place: {x: number, y: number, z: number}} | null)[]} trees
 * @returns {{first: number, second: number, distance: number, radii: number}[]}
 */
export function overlappingPairs(trees) {
  const reach = trees.map((tree) => tree && Math.max(tree.crown.east, tree.crown.west, tree.crown.south, tree.crown.north));
  const places = quadtree([...trees.keys()].filter((index) => trees[index]), (index) => trees[index].place.x, (index) => trees[index].place.z);
  const pairs = [];
  const compare = (index, other) => {
    // Two of one reach would find each other twice.
    if (reach[other] > reach[index] || (reach[other] === reach[index] && other <= index)) return;
    const [first, second] = index < other ? [index, other] : [other, index];
    const { distance, radii } = facing(trees[first], trees[second]);
    if (distance < radii) pairs.push({ first, second, distance, radii });
  };
  trees.forEach((tree, index) => {
    if (!tree) return;
    const { x, z } = tree.place;
    const far = 2 * reach[index];
    places.visit((node, west, north, east, south) => {
      for (let leaf = node.length ? null : node; leaf; leaf = leaf.next) compare(index, leaf.data);
      return west > x + far || east < x - far || north > z + far || south < z - far;
    });
  });
  return pairs.sort((a, b) => a.first - b.first || a.second - b.second);
}

/** Points of a crown's surface: rings from the crown base up, each of `sides` points, around the stem base. */
export function surfaceRings(crown, sides, steps) {
  const rings = [];
  for (let step = 0; step <= 2 * steps; ++step) {
    const below = step <= steps;
    const share = below ? step / steps : (2 * steps - step) / steps;
    const y = below ? lower(crown, share) : upper(crown, share);
    rings.push(
      Array.from({ length: sides }, (_, side) => {
        const angle = (2 * Math.PI * side) / sides;
        const x = Math.cos(angle);
        const z = Math.sin(angle);
        const distance = share * radiusTowards(crown, x, z);
        return [x * distance, y, z * distance];
      }),
    );
  }
  return rings;
}

/** Distance of a point outside a crown, relative to its width there: below 0 inside, continuous across the surface. */
function outsideness(crown, x, y, z) {
  const sideways = Math.hypot(x, z) / radiusTowards(crown, x, z);
  const span = crown.h - crown.hcb;
  const above = (y - upper(crown, Math.min(1, sideways))) / span;
  const below = (lower(crown, Math.min(1, sideways)) - y) / span;
  return Math.max(sideways - 1, above, below);
}

/** The part of a triangle where a value that is linear on it is negative, as triangles. */
function clipped(corners, values) {
  const kept = [];
  for (let index = 0; index < 3; ++index) {
    const next = (index + 1) % 3;
    if (values[index] <= 0) kept.push(corners[index]);
    if (values[index] <= 0 !== values[next] <= 0) {
      const share = values[index] / (values[index] - values[next]);
      kept.push(corners[index].map((value, axis) => value + share * (corners[next][axis] - value)));
    }
  }
  return kept.length < 3 ? [] : Array.from({ length: kept.length - 2 }, (_, index) => [kept[0], kept[index + 1], kept[index + 2]]);
}

/** The triangles between rings of equally many points: three indices each into the points of all rings. */
export function ringTriangles(rings) {
  const sides = rings[0].length;
  const triangles = [];
  for (let first = 0; first + sides < sides * rings.length; first += sides) {
    for (let side = 0; side < sides; ++side) {
      const [a, b] = [first + side, first + ((side + 1) % sides)];
      triangles.push([a, a + sides, b], [b, a + sides, b + sides]);
    }
  }
  return triangles;
}

/** The surface of one crown inside another, in the page's frame. */
function surfaceWithin(own, other, sides, steps) {
  const inPage = ([x, y, z]) => [x + own.place.x, y + own.place.y, z + own.place.z];
  const valueAt = ([x, y, z]) => outsideness(other.crown, x - other.place.x, y - other.place.y, z - other.place.z);
  const rings = surfaceRings(own.crown, sides, steps);
  const points = rings.flat().map(inPage);
  return ringTriangles(rings).flatMap((triangle) => {
    const corners = triangle.map((index) => points[index]);
    return clipped(corners, corners.map(valueAt));
  });
}

/** The boundary of the overlap of two crowns, as triangles of three points in the page's frame. */
export function sharedSpace(first, second, sides = 24, steps = 8) {
  return [...surfaceWithin(first, second, sides, steps), ...surfaceWithin(second, first, sides, steps)];
}
