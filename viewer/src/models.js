// SPDX-License-Identifier: MIT
// The chosen models: formulas, accuracy, coefficients, variance components, random effects.
import { element, verdictMark } from "./dom.js";
import { columnName, count, criterion, decimals, inUnit, listing, probability, r2, significant, withMinusSigns } from "./format.js";
import { groupTitle, modelList, varianceText } from "./head.js";
import { numeric, table } from "./table.js";

const FITS = [
  ["ols", "OLS, base"],
  ["covariates", "OLS, with covariates"],
  ["nlme", "NLME"],
];

/** @param {Result} result */
export function chosenModels(result) {
  const fits = FITS.filter(([key]) => result.fits[key] !== null).map(([key, name]) => ({ key, name, fit: result.fits[key] }));
  if (fits.length === 0) return [element("p", {}, "No model could be fitted.")];
  return [
    formulas(fits),
    element("div", { class: "estimates" }, accuracy(fits, result), coefficients(fits), ...components(result.fits.nlme, result.unit)),
  ];
}

const formulas = (fits) =>
  modelList(fits.map(({ name, fit }) => ({ name, fit, further: [], verdict: fit.converged ? [] : [" ", verdictMark(false), ` ${withMinusSigns(fit.verdict)}`] })));

/** The columns of the accuracy table: a fit, seen as a population or conditionally. */
function views(fits) {
  return fits.flatMap(({ key, name, fit }) =>
    key === "nlme"
      ? [
          { key, name: "NLME population", fit, statistics: fit.statistics.population },
          { key, isConditional: true, name: "NLME conditional", fit, statistics: fit.statistics.conditional },
        ]
      : [{ key, name, fit, statistics: fit.statistics.population }],
  );
}

/** The statistics of a fit at a level: name, key, value and format. */
export const statisticRows = (unit) => {
  const four = (value) => decimals(value, 4);
  const ofLevel = (name, key, format) => ({ name, key, of: (fit, level) => level?.[key] ?? null, format });
  const ofFit = (name, key, format) => ({ name, key, of: (fit) => fit[key] ?? null, format });
  return [
    ofLevel("R²", "r2", r2),
    ofLevel(inUnit("Mean error", unit), "mean_error", four),
    ofLevel(inUnit("RMSE", unit), "rmse", four),
    ofLevel(inUnit("MAE", unit), "mae", four),
    ofFit("Log-likelihood", "log_likelihood", criterion),
    ofFit("Parameters counted, k", "k", count),
    ofFit("AIC", "aic", criterion),
    ofFit("BIC", "bic", criterion),
  ];
};

function accuracy(fits, { unit, left_out: leftOut }) {
  const rows = statisticRows(unit).map(({ name, of, format }) => ({ name, of: ({ fit, statistics }) => format(of(fit, statistics)) }));
  if (leftOut?.r2_ols !== undefined) {
    // Only least squares and the population prediction have it: random effects of a left-out plot are unknown.
    const of = (name) => ({ key, isConditional }) => (isConditional ? null : leftOut[`${name}_${key}`]);
    rows.splice(1, 0, { name: `R², plots left out (${leftOut.folds} folds)`, of: (view) => r2(of("r2")(view)) });
    rows.splice(4, 0, { name: inUnit("RMSE, plots left out", unit), of: (view) => decimals(of("rmse")(view), 4) });
  }
  const columns = views(fits).map((view) => ({ title: view.name, value: (row) => row.of(view) }));
  return table("Accuracy and criteria", [{ title: "Statistic", text: true, value: ({ name }) => name }, ...columns], rows);
}

function coefficients(fits) {
  const rows = fits.flatMap(({ name, fit }) => Object.entries(fit.fixed).map(([coefficient, values]) => ({ name, coefficient, ...values })));
  const columns = [
    { title: "Coefficient", text: true, value: ({ coefficient }) => element("code", {}, coefficient) },
    { title: "Model", text: true, value: ({ name }) => name },
    numeric("Estimate", ({ estimate }) => estimate, significant),
    numeric("Standard error", ({ se }) => se, (value) => significant(value, 4)),
    numeric("df", ({ df }) => df, count),
    numeric("t", ({ t }) => t, (value) => decimals(value, 2)),
    numeric("p", ({ p }) => p, probability),
  ];
  const covariates = [...new Set(rows.filter(({ coefficient }) => coefficient.includes(":")).map(({ coefficient }) => coefficient.split(":")[1]))];
  const example = rows.find(({ coefficient }) => coefficient.includes(":"))?.coefficient;
  const legend =
    example === undefined
      ? null
      : element(
          "p",
          { class: "small" },
          `${example} is the change of ${example.split(":")[0]} when ${example.split(":")[1]} grows by 1. ` +
            `${listing(covariates.map((column) => `${column}: ${columnName(column)}`))}.`,
        );
  return element("div", {}, table("Fixed coefficients", columns, rows), legend);
}

function components(fit, unit) {
  const terms = fit?.random ?? [];
  if (terms.length === 0) return [];
  const { variance, sigma } = fit;
  const parts = [
    `Residual sigma ${significant(sigma)}${variance.function === "none" ? ` ${unit}`.trimEnd() : ""}`,
    `variance function ${varianceText(variance)}`,
    variance.delta === null ? null : `delta ${significant(variance.delta)}`,
    variance.constant === null ? null : `constant ${significant(variance.constant)}`,
  ].filter((part) => part !== null);
  return [
    ...terms.map((term, index) => componentsOfTerm(term, terms.length > 1 ? groupTitle(terms, index) : "")),
    element("p", { class: "small" }, `${parts.join("; ")}.`),
    terms.some(({ correlation }) => nearlyOne(correlation)) ? element("p", { class: "note" }, NEARLY_ONE) : null,
  ].filter((part) => part !== null);
}

function componentsOfTerm({ effects, sd, correlation }, group) {
  const rows = effects.map((effect, index) => ({ effect, sd: sd[index], correlation: correlation[index] ?? [], index }));
  const columns = [
    { title: "Random effect on", text: true, value: ({ effect }) => element("code", {}, effect) },
    numeric("Standard deviation", (row) => row.sd, significant),
    ...effects.slice(0, -1).map((other, column) => ({
      title: `Correlation with ${other}`,
      value: (row) => (column < row.index ? decimals(row.correlation[column], 3) : ""),
    })),
  ];
  return table(group === "" ? "Variance components" : `Variance components, ${group}`, columns, rows);
}

const NEARLY_ONE =
  "A correlation is nearly 1 or \u22121: these random effects are hardly identifiable separately. Consider a model with fewer of them.";
const nearlyOne = (correlation) => correlation.some((row, index) => row.slice(0, index).some((value) => Math.abs(value) > 0.995));
