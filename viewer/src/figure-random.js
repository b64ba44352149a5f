// SPDX-License-Identifier: MIT
// Random effects of each plot, sorted, with intervals where their standard errors are known.
import { extent } from "./classes.js";
import { figure, titled } from "./figure.js";
import { listing, plural, significant } from "./format.js";
import { groupTitle } from "./head.js";
import { numeric, table } from "./table.js";

/** Normal quantile of 95 % intervals. */
const INTERVAL = 1.96;
/** More groups than this get numbers in their order instead of names. */
const MOST_NAMES = 45;
const ROW_HEIGHT = 17;
const LEAST_ROW_HEIGHT = 4;
const GREATEST_HEIGHT = 900;
const AXIS_HEIGHT = 62;

/**
 * @param {Result} result
 * @param {number} index  of the grouping, the coarser of two first
 * @returns null without random effects of this grouping
 */
export function randomFigure({ fits: { nlme }, outlying = [] }, index = 0) {
  const random = nlme?.random[index];
  const groups = Object.keys(random?.eblup ?? {});
  if (random === undefined || groups.length === 0) return null;
  const hasErrors = random.eblup_se !== undefined;
  // Only plots are compared with each other.
  const outliers = new Set(index === 0 ? outlying.map(({ plot }) => plot) : []);
  const panels = random.effects.map((effect, place) => panel(random, effect, random.sd[place], outliers));
  return figure({
    title: `Random effects by ${groupTitle(nlme.random, index)}`,
    legend: [["dot-nlme", `EBLUP of each ${random.group}`], ...(hasErrors ? [["nlme", "95 % interval"]] : []), ["limit", "two standard deviations of the random effect"], ...(outliers.size > 0 ? [["dot-ols", `outlying ${random.group}`]] : [])],
    note: hasErrors
      ? `The deviation of each ${random.group} from the coefficient. The intervals are conditional: given the estimates.`
      : `The deviation of each ${random.group} from the coefficient. Intervals need standard errors of the random effects, which this fit does not have.`,
    charts: panels.map(({ chart, effect }) => titled(`On ${effect}`, chart)),
    behind: () => [randomTable(random, groups)],
  });
}

function panel(random, effect, sd, outlying) {
  const rows = Object.entries(random.eblup)
    .map(([group, values]) => ({ y: group, x: values[effect], se: random.eblup_se?.[group]?.[effect] ?? null }))
    .filter(({ x }) => x !== null && x !== undefined)
    .sort((a, b) => b.x - a.x)
    .map((row) => ({ ...row, low: row.x - INTERVAL * (row.se ?? 0), high: row.x + INTERVAL * (row.se ?? 0), tip: `${random.group} ${row.y}: ${significant(row.x, 4)}`, kind: outlying.has(row.y) ? "ols" : "nlme" }));
  const names = rows.map(({ y }) => y);
  const domain = extent([-2 * sd, 2 * sd], rows.map(({ low }) => low), rows.map(({ high }) => high));
  const rule = (kind, x) => ({ mark: "line", kind, values: [{ x, y: names[0] }, { x, y: names.at(-1) }] });
  const height = Math.min(GREATEST_HEIGHT, AXIS_HEIGHT + rows.length * (rows.length > MOST_NAMES ? LEAST_ROW_HEIGHT : ROW_HEIGHT));
  return {
    effect,
    chart: {
      label: `Random effects on ${effect} of ${plural(rows.length, random.group)}, from ${significant(rows.at(-1)?.x, 3)} to ${significant(rows[0]?.x, 3)}; their standard deviation is ${significant(sd, 3)}.`,
      x: { title: `Random effect on ${effect}`, domain },
      y: { title: null, domain: names, labels: rows.length <= MOST_NAMES },
      layers: [
        ...(names.length > 1 ? [rule("guide", 0), rule("limit", -2 * sd), rule("limit", 2 * sd)] : []),
        { mark: "intervals", kind: "nlme", values: rows.filter(({ se }) => se !== null), thin: true },
        { mark: "points", kind: "nlme", values: rows, large: rows.length <= MOST_NAMES },
      ],
      height: Math.max(160, height),
    },
  };
}

function randomTable({ group, effects, eblup, eblup_se: errors }, groups) {
  const columns = effects.flatMap((effect) => [
    numeric(effect, (name) => eblup[name][effect], (value) => significant(value, 4)),
    ...(errors ? [numeric(`Standard error, ${effect}`, (name) => errors[name]?.[effect] ?? null, (value) => significant(value, 3))] : []),
  ]);
  return table(`Random effects of each ${group} on ${listing(effects)}`, [{ title: group, text: true, value: (name) => name }, ...columns], groups);
}
