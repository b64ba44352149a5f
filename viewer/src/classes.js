// SPDX-License-Identifier: MIT
// Trees in classes of equal size, for trends in charts and for the tables behind them.

import { deviation, extent as extentOf, group, mean, quantileSorted } from "d3-array";

/**
 * Classes of x, each with about the same number of trees, from the smallest x to the largest.
 * Pairs with a missing number are skipped.
 * @param {(number|null)[]} x
 * @param {(number|null)[]} y
 * @returns {{number: number, x: number, y: number, sd: number|null}[]}  mean of x, mean of y, standard deviation of y
 */
export function equalClasses(x, y, greatest = 10) {
  const pairs = x.map((value, index) => [value, y[index]]).filter(([a, b]) => a !== null && b !== null);
  pairs.sort((a, b) => a[0] - b[0]);
  const classes = Math.max(1, Math.min(greatest, Math.floor(pairs.length / 5)));
  return Array.from({ length: classes }, (_, index) => {
    const members = pairs.slice(Math.round((index * pairs.length) / classes), Math.round(((index + 1) * pairs.length) / classes));
    const ys = members.map((pair) => pair[1]);
    return { number: members.length, x: mean(members.map((pair) => pair[0])), y: mean(ys), sd: deviation(ys) ?? null };
  }).filter(({ number }) => number > 0);
}

/** Smallest and largest of the numbers that are not missing; [0, 1] if there are none. */
export function extent(...columns) {
  const [low = 0, high = 1] = extentOf(columns.flat());
  return [low, high];
}

/** Round class widths. */
const WIDTHS = [0.1, 0.2, 0.25, 0.5, 1, 2, 5, 10, 20, 25, 50, 100];
const MOST_CLASSES = 14;
const FEWEST_CLASSES = 4;

/** Width of classes over a range: 2, as in forestry tables, unless that gives too few or too many classes. */
export function classWidth([low, high], usual = 2) {
  const number = (width) => Math.ceil((high - low) / width);
  if (number(usual) >= FEWEST_CLASSES && number(usual) <= MOST_CLASSES) return usual;
  return WIDTHS.find((width) => number(width) <= MOST_CLASSES) ?? (high - low) / MOST_CLASSES;
}

/** A class with fewer trees has no box. */
export const FEWEST_TREES = 5;

/** Values that are drawn as points: those beyond the whiskers, or all values of a class without a box. */
export const drawnAlone = ({ number, outliers, values }) => (number >= FEWEST_TREES ? outliers : values);

/** Whiskers end at the farthest value within this many quartile ranges of the box (Tukey). */
const WHISKER = 1.5;

/**
 * Box plots of y in classes of x of one width.
 * @param {(number|null)[]} x
 * @param {(number|null)[]} y
 * @returns {{from: number, to: number, number: number, mean: number, low: number, q1: number, median: number, q3: number, high: number, outliers: number[], values: number[]}[]}  `values` sorted
 */
export function boxClasses(x, y, width) {
  const trees = x.map((value, index) => [value, y[index]]).filter(([value, other]) => value !== null && other !== null);
  return [...group(trees, ([value]) => Math.floor(value / width))]
    .sort(([a], [b]) => a - b)
    .map(([key, values]) => ({ from: key * width, to: (key + 1) * width, ...box(values.map((tree) => tree[1])) }));
}

function box(values) {
  const sorted = [...values].sort((a, b) => a - b);
  const [q1, median, q3] = [0.25, 0.5, 0.75].map((share) => quantileSorted(sorted, share));
  const reach = WHISKER * (q3 - q1);
  const inside = sorted.filter((value) => value >= q1 - reach && value <= q3 + reach);
  const outliers = sorted.filter((value) => value < q1 - reach || value > q3 + reach);
  return { number: sorted.length, mean: mean(sorted), low: inside[0], q1, median, q3, high: inside.at(-1), outliers, values: sorted };
}
