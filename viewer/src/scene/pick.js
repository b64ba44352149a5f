// SPDX-License-Identifier: MIT
// Finds the first tree on a ray, by its crown curve and stem, for any level of detail.
import { contains } from "./crown.js";

const STEPS = 64;
/** Minimum radius, because thin stems would be hard to hit. */
const LEAST_STEM_M = 0.12;

/** The interval of a ray that is within a distance of the tree's axis and between its base and tip, as [from, to]; null if none. */
function throughCylinder(origin, direction, radius, height) {
  const a = direction.x ** 2 + direction.z ** 2;
  const b = origin.x * direction.x + origin.z * direction.z;
  const c = origin.x ** 2 + origin.z ** 2 - radius ** 2;
  let [from, to] = [0, Infinity];
  if (a < 1e-12) {
    if (c > 0) return null;
  } else {
    const root = b * b - a * c;
    if (root < 0) return null;
    from = Math.max(0, (-b - Math.sqrt(root)) / a);
    to = (-b + Math.sqrt(root)) / a;
  }
  if (Math.abs(direction.y) < 1e-12) {
    if (origin.y < 0 || origin.y > height) return null;
  } else {
    const ends = [-origin.y / direction.y, (height - origin.y) / direction.y].sort((p, q) => p - q);
    from = Math.max(from, ends[0]);
    to = Math.min(to, ends[1]);
  }
  return from < to ? [from, to] : null;
}

function meets(body, dbh, origin, direction, nearest) {
  const { crown, place } = body;
  const local = { x: origin.x - place.x, y: origin.y - place.y, z: origin.z - place.z };
  const reach = Math.max(crown.east, crown.west, crown.south, crown.north);
  const passage = throughCylinder(local, direction, reach, crown.h);
  if (!passage || passage[0] >= nearest) return Infinity;
  const stem = throughCylinder(local, direction, Math.max(dbh / 200, LEAST_STEM_M), crown.hc);
  const [from, to] = passage;
  for (let step = 0; step <= STEPS; ++step) {
    const at = from + ((to - from) * step) / STEPS;
    if (contains(crown, local.x + at * direction.x, local.y + at * direction.y, local.z + at * direction.z)) {
      return Math.min(at, stem ? stem[0] : Infinity);
    }
  }
  return stem ? stem[0] : Infinity;
}

/**
 * @param {{bodies: object[], stand: {shown: boolean[]}}} side
 * @param {number[]} dbh                           of all trees [cm]
 * @param {{x: number, y: number, z: number}} origin  of the ray
 * @param {{x: number, y: number, z: number}} direction
 * @returns {number | null}  the tree
 */
export function pick({ bodies, stand }, dbh, origin, direction) {
  let nearest = Infinity;
  let picked = null;
  bodies.forEach((body, tree) => {
    if (!body || !stand.shown[tree]) return;
    const distance = meets(body, dbh[tree], origin, direction, nearest);
    if (distance < nearest) [nearest, picked] = [distance, tree];
  });
  return picked;
}
