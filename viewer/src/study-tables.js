// SPDX-License-Identifier: MIT
// The tables of the whole study as files, with the names and columns of those in its folder `tables`.
import { csvText, downloadButton } from "./csv.js";
import { disclosure, element } from "./dom.js";
import { count, criterion, decimals, plural, probability, significant } from "./format.js";
import { numeric, table } from "./table.js";

/** @typedef {import("./types.js").Result} Result */

const LEVELS = ["ols", "covariates", "nlme"];
const ACCURACY = ["r2", "mean_error", "rmse", "mae"];
const TEST = ["likelihood_ratio", "df", "p"];
const CRITERIA = ["k", "log_likelihood", "aic", "bic", "cv_rmse", "cv_failed_folds", "rank", "chosen", "converged", "verdict", "objection"];

const rowsOf = (results, level) => results.flatMap((result) => result[level].map((row) => ({ ...row, species: result.species, response: result.response })));
const fitsOf = (results) => results.flatMap(({ species, response, fits }) => LEVELS.filter((level) => fits[level] !== null).map((level) => ({ species, response, level, fit: fits[level] })));

function candidates(results) {
  return rowsOf(results, "base").map((row) => ({ ...row, model: row.id }));
}

const covariates = (results) => rowsOf(results, "covariates").map((row) => ({ ...row, sub_models: row.parameters.join("; ") }));
const randomEffects = (results) => rowsOf(results, "random").map((row) => ({ ...row, random_effects: row.effects.join(" + ") }));

const estimates = (results) =>
  fitsOf(results).flatMap(({ fit, ...subject }) => Object.entries(fit.fixed).map(([coefficient, values]) => ({ ...subject, coefficient, ...values })));

function components({ species, response, fits: { nlme } }) {
  if (nlme === null || nlme.random === null) return [];
  const { effects, sd, correlation } = nlme.random;
  const pairs = effects.flatMap((effect, row) => effects.slice(0, row).map((other, column) => [`cor(${other}, ${effect})`, correlation[row][column]]));
  const variance = [["delta", nlme.variance.delta], ["constant", nlme.variance.constant]].filter(([, value]) => value !== null);
  const values = [...effects.map((effect, row) => [`sd(${effect})`, sd[row]]), ...pairs, ["sigma", nlme.sigma], ...variance];
  return values.map(([component, value]) => ({ species, response, component, value }));
}

const statistics = (results) =>
  fitsOf(results).flatMap(({ fit, ...subject }) =>
    Object.entries(fit.statistics)
      .filter(([, values]) => values !== null)
      .map(([prediction, values]) => ({ ...fit, ...subject, ...values, prediction })),
  );

/** @type {{file: string, what: string, columns: string[], rows: (results: Result[]) => object[]}[]} */
const TABLES = [
  { file: "candidates.csv", what: "Level 1: every base model with its rank", columns: ["species", "response", "model", "name", "formula", ...ACCURACY, ...CRITERIA], rows: candidates },
  { file: "covariates.csv", what: "Level 2: every covariate subset, likelihood-ratio tests", columns: ["species", "response", "sub_models", ...ACCURACY, ...TEST, ...CRITERIA], rows: covariates },
  { file: "random_effects.csv", what: "Level 3: every subset of random effects, tests against none", columns: ["species", "response", "random_effects", "covariance", ...TEST, ...CRITERIA], rows: randomEffects },
  { file: "variance_functions.csv", what: "Level 3: variance functions, likelihood-ratio tests", columns: ["species", "response", "function", "delta", "constant", ...TEST, ...CRITERIA], rows: (results) => rowsOf(results, "variance") },
  { file: "estimates.csv", what: "Coefficients of the chosen models", columns: ["species", "response", "level", "coefficient", "estimate", "se", "df", "t", "p"], rows: estimates },
  { file: "variance_components.csv", what: "Variance components of the mixed models", columns: ["species", "response", "component", "value"], rows: (results) => results.flatMap(components) },
  {
    file: "statistics.csv",
    what: "Accuracy and criteria of the chosen models",
    columns: ["species", "response", "level", "prediction", "formula", "n", ...ACCURACY, "k", "log_likelihood", "aic", "bic", "converged"],
    rows: statistics,
  },
];

const FORMATS = { count, estimate: significant, criterion, share: (value) => decimals(value, 4), percent: (value) => decimals(value, 1), p: probability };

/** A table of the whole study, behind its caption. */
function summary({ caption, columns, rows }) {
  const shown = columns.map(({ title, kind }, index) =>
    kind === "text" ? { title, text: true, value: (row) => row[index] ?? "" } : numeric(title, (row) => row[index], FORMATS[kind]),
  );
  return disclosure([element("span", { class: "level" }, caption)], () => [table(caption, shown, rows)]);
}

/** @param {import("./types.js").Report} report */
export function studyTables({ results, tables = [] }) {
  const entry = ({ file, what, columns, rows }) => {
    const content = () => csvText(columns, rows(results).map((row) => columns.map((column) => row[column])));
    return element("li", {}, downloadButton(file, file, content), ` ${what}: ${plural(rows(results).length, "row")}`);
  };
  return element(
    "section",
    { id: "tables", "aria-labelledby": "tables-title" },
    element("h2", { id: "tables-title" }, "Tables of the study"),
    ...tables.map(summary),
    element("p", {}, "All species and responses in one file each, with all digits, to be saved as CSV."),
    element("ul", { class: "downloads" }, ...TABLES.map(entry)),
  );
}
