// SPDX-License-Identifier: MIT
// The top of the report: main result, summary, and the analyses.
import { element, section, verdictMark } from "./dom.js";
import { count, decimals, listing, MISSING, plural, points, r2, responseName, significant, withMinusSigns } from "./format.js";
import { gainFigure } from "./gain.js";
import { resultId } from "./navigation.js";
import { numeric, table } from "./table.js";

const LEVELS = [
  ["base", "base equations"],
  ["covariates", "covariate subsets"],
  ["random", "random-effect subsets"],
  ["variance", "variance functions"],
];

/** Trees that were not skipped, the basis of all counts. */
const used = ({ trees, excluded }) => trees - excluded;

const chosen = (rows) => rows.find((row) => row.chosen) ?? null;

/** @param {Report} report */
export const heading = (report) => element("header", {}, element("h1", {}, report.title), element("p", { class: "lead" }, whatItIs(report)));

function whatItIs({ inventory, results }) {
  const species = new Set(results.map((result) => result.species)).size;
  const responses = listing([...new Set(results.map((result) => responseName(result.response).toLowerCase()))]);
  if (results.length === 0) return `${inventory.file}: ${plural(used(inventory), "tree")}, ${plural(inventory.plots, "plot")}.`;
  return (
    `Models of ${responses} for ${plural(species, "species", "species")} from ${plural(used(inventory), "tree")} ` +
    `on ${plural(inventory.plots, "plot")} (${inventory.file}), by least squares (OLS) and by nonlinear mixed effects (NLME).`
  );
}

/** Data of earlier versions do not have `sound`; there, converged models count as sound. */
export const isSound = ({ converged, sound }) => sound ?? converged;

export function verdict(report) {
  const doubtful = report.results.map((result, index) => ({ result, index })).filter(({ result }) => !isSound(result));
  return section(
    "verdict",
    "Sound and doubtful models",
    { class: doubtful.length > 0 || report.results.length === 0 ? "panel warn" : "panel" },
    element("p", { class: "headline" }, headline(report.results)),
    soundList(report.results, doubtful),
    doubtful.length > 0 ? element("ul", {}, ...doubtful.map(doubt)) : null,
    gainSentence(report.results),
    outlyingSentence(report.results),
    effort(report.results),
    report.notes.length > 0 ? element("p", { class: "small" }, element("a", { href: "#notes" }, plural(report.notes.length, "note")), " on how the table was read and what was assumed.") : null,
  );
}

function headline(results) {
  if (results.length === 0) return "No model was fitted.";
  const failed = results.filter(({ converged }) => !converged).length;
  const doubtful = results.filter((result) => !isSound(result)).length - failed;
  const models = plural(results.length, "final model");
  if (failed === 0 && doubtful === 0) return results.length === 1 ? "The final model is sound." : `All ${models} are sound.`;
  const sentences = [];
  if (failed > 0) sentences.push(`${failed} of ${models} did not converge. Do not use ${failed === 1 ? "its" : "their"} results.`);
  if (doubtful > 0) sentences.push(`${doubtful} of ${models} ${doubtful === 1 ? "is" : "are"} doubtful.`);
  return sentences.join(" ");
}

const nameOf = ({ species, response }) => `${species}, ${responseName(response).toLowerCase()}`;
const linkTo = (result, index) => element("a", { href: `#${resultId(index)}` }, nameOf(result));

/** The sound models, by name if there are others, too. */
function soundList(results, doubtful) {
  const sound = results.map((result, index) => ({ result, index })).filter(({ result }) => isSound(result));
  if (sound.length === 0) return null;
  const leftOut = sound.some(({ result }) => result.left_out)
    ? "their errors for plots left out are not clearly larger than those of least squares"
    : "no plots were left out to check predictions, because there is no mixed model of several plots";
  const meaning = `they converged, their curves are plausible for the population and every plot, and ${leftOut}`;
  if (doubtful.length === 0) return element("p", {}, `Sound: ${meaning}.`);
  const names = sound.flatMap(({ result, index }, place) => [place > 0 ? "; " : "", linkTo(result, index)]);
  return element("p", {}, `Sound (${meaning}): `, ...names, ".");
}

function doubt({ result, index }) {
  const reasons = [...(result.converged ? [] : [result.verdict]), ...(result.doubts ?? [])].map(withMinusSigns);
  return element("li", {}, linkTo(result, index), `: ${reasons.join(" ")}`);
}

/** "+2.53 (SM, height) to +30.32 (BHN, crown width)". */
function gainRange(results, level) {
  const sorted = results.filter(({ gain }) => gain[level] !== null).sort((a, b) => a.gain[level] - b.gain[level]);
  const named = ({ gain, species, response }) => `${points(gain[level])} (${species}, ${responseName(response).toLowerCase()})`;
  if (sorted.length === 0) return null;
  return sorted.length === 1 ? named(sorted[0]) : `${named(sorted[0])} to ${named(sorted.at(-1))}`;
}

function gainSentence(results) {
  const usable = results.filter(({ converged }) => converged);
  const conditional = gainRange(usable, "conditional");
  const population = gainRange(usable, "population");
  if (conditional === null) return null;
  const onNewPlots = population === null ? "" : ` On a plot without measured trees, from covariates alone: ${population}.`;
  return element(
    "p",
    {},
    `Against OLS, the mixed models change R² by ${conditional} percentage points where other trees of the plot ` +
      `were measured (conditional).${onNewPlots}`,
  );
}

/** The outlying plots, by model. */
function outlyingSentence(results) {
  const named = results.map((result, index) => ({ result, index })).filter(({ result }) => (result.outlying ?? []).length > 0);
  if (named.length === 0) return null;
  const parts = named.flatMap(({ result, index }, place) => [place > 0 ? "; " : "", linkTo(result, index), `: plot ${listing(result.outlying.map(({ plot }) => plot))}`]);
  return element("p", {}, "Outlying plots, whose random effects are far from those of the others: ", ...parts, ".");
}

function effort(results) {
  const counts = LEVELS.map(([level, name]) => {
    const rows = results.flatMap((result) => result[level]);
    return { name, all: rows.length, failed: rows.filter((row) => !row.converged).length };
  }).filter((level) => level.all > 0);
  if (counts.length === 0) return null;
  const parts = counts.map(({ name, all, failed }) => `${count(all)} ${name}${failed > 0 ? ` (${count(failed)} not converged)` : ""}`);
  const passed = results.flatMap((result) => LEVELS.flatMap(([level]) => result[level])).filter((row) => row.objection && !row.chosen).length;
  const rejected = passed > 0 ? ` ${plural(passed, "candidate")} that ranked well ${passed === 1 ? "was" : "were"} rejected; the table is below.` : "";
  return element("p", {}, `Compared: ${listing(parts)}. Those that did not converge were not ranked.${rejected}`);
}

/** Covariates of the chosen level 2 model, "none" if the base model was chosen, a dash if the level was skipped. */
export function covariateText(result) {
  const row = chosen(result.covariates);
  if (row === null) return MISSING;
  return row.parameters.length > 0 ? row.parameters.join("; ") : "none";
}

export function varianceText(variance) {
  if (variance === null) return MISSING;
  const of = variance.of === null || variance.of === "fitted" ? "" : ` of ${variance.of}`;
  return variance.function.replaceAll("-", " ") + of;
}

/** "random: a + b | plot" of each term; a finer grouping is within the one before it. */
const randomTexts = (terms) => terms.map(({ effects }, index) => `random: ${effects.join(" + ")} | ${groupTitle(terms, index)}`);

/** Formulas of named fits: "h ~ ..., b ~ 1 + C, random: a + b:C | plot", further parts, and the verdict. */
export function modelList(fits) {
  const describe = ({ name, fit, further, verdict }) => {
    const submodels = Object.entries(fit.parameters).filter(([, terms]) => terms !== "1").map(([parameter, terms]) => `${parameter} ~ ${terms}`);
    const parts = [fit.formula, ...submodels, ...randomTexts(fit.random), ...further].flatMap((part) => [element("code", {}, part), " "]);
    return [element("dt", {}, name), element("dd", {}, ...parts, ...verdict)];
  };
  return element("dl", { class: "formulas" }, ...fits.flatMap(describe));
}

/** "plot", or "year within plot" of a finer grouping. */
export const groupTitle = (terms, index) => terms[index].group + (index === 0 ? "" : ` within ${terms[index - 1].group}`);

/** "a, b", of two groupings "a, b | plot; a | year". */
function effectsText(terms) {
  const text = ({ effects, group }) => effects.join(", ") + (terms.length > 1 ? ` | ${group}` : "");
  return terms.length > 0 ? terms.map(text).join("; ") : MISSING;
}

export function summary(report) {
  const stat = (fit, level, name) => fit?.statistics[level]?.[name] ?? null;
  const row = (result, index) => ({ ...result, index });
  const length = (title, raw) => ({ title, raw, value: (result) => `${decimals(raw(result), 3)} ${result.unit}` });
  const name = {
    title: "Species, response",
    text: true,
    value: (result) =>
      element("a", { href: `#${resultId(result.index)}` }, `${result.species} ${responseName(result.response).toLowerCase()}`),
  };
  const isMixed = report.results.some(({ fits }) => fits.nlme !== null);
  const chosenModel = [
    name,
    { title: "Base model", text: true, value: ({ base }) => baseText(chosen(base)) },
    { title: "Covariates", text: true, value: covariateText },
    ...(isMixed
      ? [
          { title: "Random effects", text: true, value: ({ fits }) => effectsText(fits.nlme?.random ?? []) },
          { title: "Variance function", text: true, value: ({ fits }) => varianceText(fits.nlme?.variance ?? null) },
        ]
      : []),
    { title: "State", text: true, value: (result) => verdictMark(result.converged, isSound(result)) },
    numeric("Trees", ({ n }) => n, count),
  ];
  const mixed = [
    numeric("R² NLME population", ({ fits }) => stat(fits.nlme, "population", "r2"), r2),
    numeric("R² NLME conditional", ({ fits }) => stat(fits.nlme, "conditional", "r2"), r2),
    numeric("Gain, percentage points of R²", ({ gain }) => gain.conditional, points),
    ...leftOutColumns(report.results),
  ];
  const accuracy = [
    name,
    numeric("R² OLS", ({ fits }) => stat(fits.ols, "population", "r2"), r2),
    ...(isMixed ? mixed : []),
    length("RMSE OLS", (result) => stat(result.fits.ols, "population", "rmse")),
    ...(isMixed ? [length("RMSE NLME conditional", (result) => stat(result.fits.nlme, "conditional", "rmse"))] : []),
  ];
  const rows = report.results.map(row);
  const withoutMixed = report.results.filter(({ fits }) => fits.nlme === null).length;
  const reason = isMixed && withoutMixed > 0 ? ` A dash: there is no mixed model, for the reason in the section of the model.` : "";
  const kinds = "Population: random effects zero. Conditional: with the plot's own random effects (EBLUP). Gain: 100 (R² NLME conditional − R² OLS).";
  return section(
    "summary",
    "Summary",
    {},
    table("Chosen model for each species and response", chosenModel, rows, failedRow),
    gainFigure(report),
    table("Accuracy for each species and response", accuracy, rows, failedRow),
    element("p", { class: "small" }, isMixed ? `${kinds}${leftOutText(report.results)}${reason}` : "There is no mixed model: random effects need several plots."),
  );
}

const foldsOf = (results) => results.find(({ left_out: leftOut }) => leftOut?.r2_ols !== undefined)?.left_out.folds ?? null;

/** Cross-validated R², if the data have it. */
function leftOutColumns(results) {
  if (foldsOf(results) === null) return [];
  return [
    numeric("R² OLS, plots left out", ({ left_out: leftOut }) => leftOut?.r2_ols ?? null, r2),
    numeric("R² NLME, plots left out", ({ left_out: leftOut }) => leftOut?.r2_nlme ?? null, r2),
  ];
}

function leftOutText(results) {
  const folds = foldsOf(results);
  return folds === null ? "" : ` Plots left out: predictions (random effects zero) by fits without the plot, in ${folds} folds of plots.`;
}

const baseText = (row) => (row === null ? MISSING : `${row.id} ${row.name}`);
const failedRow = (result) => (isSound(result) ? null : "failed");

/** @param {Report} report */
export function whatWasDone({ inventory, options }) {
  const items = [
    ["Inventory", `${inventory.file}: ${plural(used(inventory), "tree")}, ${plural(inventory.plots, "plot")}, ${plural(inventory.species.length, "species", "species")}`],
    ["Excluded", inventory.excluded === 0 ? "no row" : `${count(inventory.excluded)} of ${plural(inventory.trees, "row")}, each with its reason in excluded.csv`],
    ...options.map(({ name, value }) => [name, value]),
  ];
  const share = ({ trees }) => `${significant((100 * trees) / used(inventory), 3)} %`;
  const species = [
    { title: "Species", text: true, value: ({ code, name }) => (name === null ? code : `${code} (${name})`) },
    numeric("Trees", ({ trees }) => trees, count),
    { title: "Share of stems", value: share },
    numeric("Inside the edge buffer", ({ core }) => core, count),
    { title: "Models", text: true, value: ({ studied }) => (studied ? "fitted" : "not fitted") },
  ];
  return section(
    "done",
    "What was done",
    {},
    element("dl", {}, ...items.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)])),
    table("Species of the inventory", species, inventory.species),
  );
}
