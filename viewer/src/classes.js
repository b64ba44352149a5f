// SPDX-License-Identifier: MIT
// Trees in classes of equal size, for trends in charts and for the tables behind them.

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

function deviation(values) {
  if (values.length < 2) return null;
  const center = mean(values);
  return Math.sqrt(values.reduce((sum, value) => sum + (value - center) ** 2, 0) / (values.length - 1));
}

/**
 * Classes of x, each with about the same number of trees, from the smallest x to the largest.
 * Pairs with a missing number are left out.
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
    return { number: members.length, x: mean(members.map((pair) => pair[0])), y: mean(ys), sd: deviation(ys) };
  }).filter(({ number }) => number > 0);
}

/** Smallest and largest of the numbers that are there; [0, 1] if there are none. */
export function extent(...columns) {
  let low = Infinity;
  let high = -Infinity;
  for (const column of columns) {
    for (const value of column) {
      if (value === null) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low <= high ? [low, high] : [0, 1];
}
