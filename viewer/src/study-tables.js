// SPDX-License-Identifier: MIT
// The tables of the whole study as files, with the names and columns of those in its folder `tables`.
import { csvText, downloadButton } from "./csv.js";
import { disclosure, element, section } from "./dom.js";
import { count, criterion, decimals, joinedEffects, plural, probability, significant } from "./format.js";
import { numeric, table } from "./table.js";

const LEVELS = ["ols", "covariates", "nlme"];
const ACCURACY = ["r2", "mean_error", "rmse", "mae"];
const TEST = ["likelihood_ratio", "df", "p"];
const CRITERIA = ["k", "log_likelihood", "aic", "bic", "cv_rmse", "cv_failed_folds", "rank", "chosen", "converged", "verdict", "objection"];

const rowsOf = (results, level) => results.flatMap((result) => result[level].map((row) => ({ ...row, species: result.species, response: result.response })));
const fitsOf = (results) => results.flatMap(({ species, response, fits }) => LEVELS.filter((level) => fits[level] !== null).map((level) => ({ species, response, level, fit: fits[level] })));

const candidates = (results) => rowsOf(results, "base").map((row) => ({ ...row, model: row.id }));
const covariates = (results) => rowsOf(results, "covariates").map((row) => ({ ...row, sub_models: row.parameters.join("; ") }));
const randomEffects = (results) => rowsOf(results, "random").map((row) => ({ ...row, random_effects: joinedEffects(row.effects, " + ") }));

const estimates = (results) =>
  fitsOf(results).flatMap(({ fit, ...subject }) => Object.entries(fit.fixed).map(([coefficient, values]) => ({ ...subject, coefficient, ...values })));

function components({ species, response, fits: { nlme } }) {
  const terms = nlme?.random ?? [];
  if (terms.length === 0) return [];
  const variance = [["delta", nlme.variance.delta], ["constant", nlme.variance.constant]].filter(([, value]) => value !== null);
  const values = [...terms.flatMap((term) => componentsOfTerm(term, terms.length > 1 ? ` | ${term.group}` : "")), ["sigma", nlme.sigma], ...variance];
  return values.map(([component, value]) => ({ species, response, component, value }));
}

function componentsOfTerm({ effects, sd, correlation }, group) {
  const pairs = effects.flatMap((effect, row) => effects.slice(0, row).map((other, column) => [`cor(${other}, ${effect}${group})`, correlation[row][column]]));
  return [...effects.map((effect, row) => [`sd(${effect}${group})`, sd[row]]), ...pairs];
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

/** A cell of a column of numbers is a text if the program added stars or the name of its parameter, and empty if a model lacks it. */
function shownColumn({ title, kind }, index) {
  if (kind === "text") return { title, text: true, value: (row) => row[index] ?? "" };
  const format = (value) => (typeof value === "number" ? FORMATS[kind](value) : value ?? "");
  return numeric(title, (row) => row[index], format);
}

/** A table from the program. */
export const madeTable = ({ caption, columns, rows }) => table(caption, columns.map(shownColumn), rows);

/** A table of the whole study, behind its caption. */
const summary = (made) => disclosure([element("span", { class: "level" }, made.caption.replace(/[.:;] .*$/, ""))], () => [madeTable(made)], 1);

/** Tables for publications are open at the top of the report. */
const PRINTED = ["species", "coefficients", "variance_and_fit"];

/** The tables of a paper: species, coefficients, and variances with accuracy; null where the data have none. */
export function modelTables({ tables = [] }) {
  const printed = PRINTED.map((name) => tables.find((made) => made.name === name)).filter((made) => made !== undefined);
  if (printed.length === 0) return null;
  return section("models", "Species and models", {}, ...printed.map(madeTable));
}

/** @param {Report} report */
export function studyTables({ results, tables = [] }) {
  const entry = ({ file, what, columns, rows }) => {
    const content = () => csvText(columns, rows(results).map((row) => columns.map((column) => row[column])));
    return element("li", {}, downloadButton(file, file, content), ` ${what}: ${plural(rows(results).length, "row")}`);
  };
  return section(
    "tables",
    "Tables of the study",
    {},
    ...tables.filter(({ name }) => !PRINTED.includes(name)).map(summary),
    element("p", {}, "All species and responses in one file each, with all digits, to be saved as CSV. The folder tables of the study has every table also as Markdown and LaTeX."),
    element("ul", { class: "downloads" }, ...TABLES.map(entry)),
  );
}
