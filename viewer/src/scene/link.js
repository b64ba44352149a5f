// SPDX-License-Identifier: MIT
// The state of the view as the fragment of an address, such as #camera=1,2,3&target=0,5,0&color=species.
import { ALL } from "./filters.js";

const short = (value) => String(Math.round(value * 1000) / 1000);
const FILTERS = Object.keys(ALL);

/**
 * @typedef {object} ViewState
 * @property {number[]} camera  position [m]
 * @property {number[]} target  the middle of the view [m]
 * @property {boolean} isWalking
 * @property {string} color     value of the coloring
 * @property {import("./filters.js").Filter} filter
 */

/** @param {ViewState} state */
export function fragmentOf({ camera, target, isWalking, color, filter }) {
  const parts = new URLSearchParams();
  parts.set("camera", camera.map(short).join());
  parts.set("target", target.map(short).join());
  if (isWalking) parts.set("mode", "walk");
  if (color) parts.set("color", color);
  for (const name of FILTERS) if (filter[name] !== null) parts.set(name, short(filter[name]));
  // Commas are allowed in fragments.
  return `#${parts.toString().replaceAll("%2C", ",")}`;
}

const triple = (text) => {
  const values = (text ?? "").split(",").map(Number);
  return values.length === 3 && values.every(Number.isFinite) && text !== "" ? values : null;
};
const numberOf = (text) => (text !== null && text !== "" && Number.isFinite(Number(text)) ? Number(text) : null);

/**
 * The state of a fragment; null for parts that are missing or cannot be read.
 * @returns {{camera: number[] | null, target: number[] | null, isWalking: boolean, color: string | null, filter: import("./filters.js").Filter}}
 */
export function stateOf(fragment) {
  const parts = new URLSearchParams(fragment.replace(/^#/, ""));
  const filter = Object.fromEntries(FILTERS.map((name) => [name, numberOf(parts.get(name))]));
  return { camera: triple(parts.get("camera")), target: triple(parts.get("target")), isWalking: parts.get("mode") === "walk", color: parts.get("color"), filter };
}
