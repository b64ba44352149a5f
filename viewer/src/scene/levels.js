// SPDX-License-Identifier: MIT
// Levels of detail: selected by a tree's height on the screen, within a budget of triangles.

/** Minimum heights on the screen [CSS pixels] for the first, second, ... level; smaller trees are drawn as impostors. */
export const LEAST_PIXELS = [600, 280, 120, 22];

/** Triangles of one frame; automatic detail stays below it. */
export const BUDGETS = { low: 300_000, automatic: 1_500_000, high: 6_000_000 };

/**
 * The level of a tree.
 * @param {number} pixels  its height on the screen
 * @param {number} levels  how many there are; the stand-in is level `levels`
 */
export function levelFor(pixels, levels) {
  const offset = LEAST_PIXELS.length - levels;
  for (let level = 0; level < levels; ++level) {
    if (pixels >= LEAST_PIXELS[Math.max(0, level + offset)]) return level;
  }
  return levels;
}

/** Steps by which heights are reduced. */
const MOST_STEPS = 16;

/**
 * The factor, at most 1, by which heights on the screen are reduced to stay within the budget.
 * @param {Float32Array} pixels     heights of the trees in view
 * @param {number} count            of them
 * @param {(tree: number, level: number) => number} triangles
 */
export function detailFactor(pixels, count, levels, triangles, budget) {
  const fits = (step) => {
    const factor = 0.8 ** step;
    let sum = 0;
    for (let index = 0; index < count; ++index) sum += triangles(index, levelFor(pixels[index] * factor, levels));
    return sum <= budget;
  };
  if (fits(0)) return 1;
  // The number of triangles falls with each step: the first that fits is between two others.
  let [low, high] = [0, MOST_STEPS];
  while (high - low > 1) {
    const middle = Math.floor((low + high) / 2);
    if (fits(middle)) high = middle;
    else low = middle;
  }
  return 0.8 ** high;
}

/** Budgets for slower and faster machines: less after slow frames, more after fast ones. */
export class AdaptiveBudget {
  constructor(most = BUDGETS.automatic, least = 200_000) {
    this.most = most;
    this.least = least;
    this.budget = most;
  }

  /** @param {number} milliseconds  between two frames of a movement */
  observe(milliseconds) {
    if (milliseconds > 45) this.budget = Math.max(this.least, this.budget * 0.8);
    else if (milliseconds < 20) this.budget = Math.min(this.most, this.budget * 1.1);
  }
}
