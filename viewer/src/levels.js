// SPDX-License-Identifier: MIT
// The candidates of each level, best first, below a line with the chosen one.
import { disclosure, element } from "./dom.js";
import { count, criterion, decimals, joinedEffects, plural, probability, r2, significant, withMinusSigns } from "./format.js";
import { varianceText } from "./head.js";
import { byRank, numeric, table } from "./table.js";

const CRITERIA = [
  numeric("k", ({ k }) => k, count),
  numeric("Log-likelihood", ({ log_likelihood }) => log_likelihood, criterion),
  numeric("AIC", ({ aic }) => aic, criterion),
  numeric("BIC", ({ bic }) => bic, criterion),
];
/** Prediction errors for left-out plots, if the study chose by them. */
const crossValidated = (rows) =>
  rows.some(({ cv_rmse }) => cv_rmse !== null && cv_rmse !== undefined)
    ? [numeric("RMSE, left out", ({ cv_rmse }) => cv_rmse, (value) => decimals(value, 3))]
    : [];
const LIKELIHOOD_RATIO = [
  numeric("Likelihood ratio", ({ likelihood_ratio }) => likelihood_ratio, criterion),
  numeric("df", ({ df }) => df, count),
  numeric("p", ({ p }) => p, probability),
];
const RANK = numeric("Rank", ({ rank }) => rank, count);
const OUTCOME = { title: "Outcome", text: true, value: outcome };

function outcome(row) {
  if (!row.converged) return element("span", { class: "bad" }, `\u26a0 ${withMinusSigns(row.verdict)}`);
  if (row.objection) {
    const what = row.chosen ? "chosen in spite of this" : "rejected";
    return element("span", { class: "bad" }, `\u26a0 ${what}: ${withMinusSigns(row.objection)}`);
  }
  return row.chosen ? element("strong", { title: withMinusSigns(row.verdict) }, "chosen") : element("span", { title: withMinusSigns(row.verdict) }, "converged");
}

const rowClass = (row) => (row.chosen ? "chosen" : row.converged && !row.objection ? null : "failed");

/** "Level 1, base equation: M4 Meyer, of 16 (2 not converged)". */
function line(title, rows, name) {
  const winner = rows.find((row) => row.chosen);
  const failed = rows.filter((row) => !row.converged).length;
  const passed = rows.filter((row) => row.objection && !row.chosen).length;
  return [
    element("span", { class: "level" }, `${title}: `),
    element("strong", {}, winner ? name(winner) : "none could be used"),
    ` of ${plural(rows.length, "candidate")}`,
    failed > 0 ? element("span", { class: "bad" }, ` (${count(failed)} not converged)`) : null,
    passed > 0 ? element("span", { class: "bad" }, ` (${count(passed)} rejected)`) : null,
  ].filter((part) => part !== null);
}

function level(title, rows, name, columns) {
  if (rows.length === 0) return element("p", { class: "skipped" }, `${title}: left out.`);
  return disclosure(line(title, rows, name), () => [table(title, [...columns, OUTCOME], byRank(rows), rowClass)], 1);
}

const parameters = ({ parameters }) => (parameters.length > 0 ? parameters.join("; ") : "base model");
const effects = ({ effects, covariance }) => joinedEffects(effects, ", ") + (covariance === "general" ? "" : ` (${covariance})`);

/** @param {Result} result */
export function levels(result) {
  const length = (name) => numeric(`${name[0]}, ${result.unit}`, (row) => row[name[1]], (value) => decimals(value, 3));
  const text = (title, value) => ({ title, text: true, value });
  const code = (title, value) => text(title, (row) => element("code", {}, value(row)));
  const candidates = (key, title, name, own, further = LIKELIHOOD_RATIO) =>
    level(title, result[key], name, [own[0], RANK, ...own.slice(1), ...CRITERIA, ...crossValidated(result[key]), ...further]);
  const equation = ({ id, name }) => `${id} ${name}`;
  const errors = [["RMSE", "rmse"], ["MAE", "mae"], ["Mean error", "mean_error"]].map(length);
  return [
    candidates("base", "Level 1, base equation", equation, [text("Equation", equation), numeric("R²", (row) => row.r2, r2), ...errors], [code("Formula", ({ formula }) => formula)]),
    candidates("covariates", "Level 2, covariates (test against the base model)", parameters, [code("Parameters", parameters)]),
    candidates("random", "Level 3, random effects by plot (test against none)", effects, [code("Random effects on", effects)]),
    candidates("variance", "Level 3, variance function (test against none)", varianceText, [
      text("Function", varianceText),
      numeric("Delta", ({ delta }) => delta, significant),
      numeric("Constant", ({ constant }) => constant, significant),
    ]),
  ];
}
