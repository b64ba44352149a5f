// SPDX-License-Identifier: MIT
// Comparison of two or more model libraries.
import { chartElement } from "./chart-view.js";
import { extent } from "./classes.js";
import { element, section, verdictMark } from "./dom.js";
import { figure } from "./figure.js";
import { capital, columnName, count, decimals, listing, MISSING, responseInText, responseName, significant } from "./format.js";
import { modelList, varianceText } from "./head.js";
import { statisticRows } from "./models.js";
import { gridRows, hasValues, lineLayer } from "./observations.js";
import { numeric, table } from "./table.js";

/** Colors of the libraries; the first has that of least squares, the reference. */
const KINDS = ["ols", "nlme", "first", "third", "fifth"];
const kindOf = (index) => KINDS[Math.min(index, KINDS.length - 1)];
const ROLES = { ols: "OLS, base", covariates: "OLS, with covariates", nlme: "NLME" };
export const pairId = (index) => `pair-${index + 1}`;

export function pairName({ species, response, role }) {
  const subject = `${species === "" ? "" : `${species} `}${responseInText(response)}`;
  return role === "" ? subject : `${subject}, ${ROLES[role] ?? role}`;
}

/** As a heading. A column of the file keeps its name, because its case is significant. */
export function pairTitle(pair) {
  return pair.species === "" && responseName(pair.response) !== pair.response ? capital(pairName(pair)) : pairName(pair);
}

const best = (fit) => (fit === null ? null : fit.statistics.conditional ?? fit.statistics.population);
const signed = (digits) => (value) => (value > 0 ? "+" : "") + decimals(value, digits);

/** @param {Comparison} comparison */
export function comparisonPage(comparison) {
  const names = comparison.libraries.map(({ name }) => name);
  return [
    element(
      "header",
      {},
      element("h1", {}, comparison.title),
      element("p", { class: "lead" }, `Differences are those from ${names[0]}: below zero in AIC, BIC and RMSE, the other one is better.`),
    ),
    libraries(comparison),
    overview(comparison, names),
    ...comparison.pairs.map((pair, index) => pairSection(pair, names, pairId(index))),
    versions(comparison),
  ];
}

function libraries({ libraries: rows }) {
  const columns = [
    { title: "Library", text: true, value: ({ name }) => name },
    { title: "Fitted to", text: true, value: ({ file }) => (file === "" ? MISSING : file) },
    { title: "Fingerprint", text: true, value: ({ fingerprint }) => (fingerprint === "" ? MISSING : element("code", {}, fingerprint)) },
    numeric("Trees", ({ trees }) => (trees > 0 ? trees : null), count),
    numeric("Models", ({ models }) => models, count),
  ];
  return section("libraries", "Libraries", {}, table("The libraries that are compared", columns, rows));
}

function overview({ pairs }, names) {
  const rows = pairs.flatMap((pair, index) => pair.differences.map((difference, other) => ({ pair, index, difference, other: other + 1 })));
  const of = (name) => ({ difference }) => difference?.[name] ?? null;
  const columns = [
    { title: "Model", text: true, value: ({ pair, index }) => element("a", { href: `#${pairId(index)}` }, pairName(pair)) },
    ...(names.length > 2 ? [{ title: "Library", text: true, value: ({ other }) => names[other] }] : []),
    numeric("Difference of AIC", of("aic"), signed(2)),
    numeric("Difference of BIC", of("bic"), signed(2)),
    { ...numeric("Difference of RMSE", of("rmse"), signed(3)), value: ({ difference, pair }) => `${signed(3)(difference?.rmse ?? null)}${difference ? ` ${pair.unit}`.trimEnd() : ""}` },
    numeric("Difference of R²", of("r2"), signed(4)),
    { title: "Note", text: true, value: ({ difference, pair }) => element("span", { class: "sentence" }, noteOn(difference, pair, names)) },
  ];
  return section(
    "overview",
    "Overview",
    {},
    table("Differences between the models", columns, rows),
    element("p", { class: "small" }, "RMSE and R² are those of the conditional prediction for mixed models, else of the population, each on the library's own data."),
  );
}

function noteOn(difference, { fits }, names) {
  if (difference === null) return `only in ${listing(names.filter((_, index) => fits[index] !== null))}`;
  return difference.reason === null ? "" : `AIC and BIC cannot be compared: ${difference.reason}`;
}

/** @param {ComparedModels} pair */
function pairSection(pair, names, id) {
  const sides = pair.fits.map((fit, index) => ({ fit, name: names[index], index })).filter(({ fit }) => fit !== null);
  const reasons = pair.differences.map((difference) => difference?.reason).filter((reason) => reason);
  return section(
    id,
    pairTitle(pair),
    { class: "result" },
    ...reasons.map((reason) => element("p", { class: "note" }, `AIC and BIC cannot be compared: ${reason}.`)),
    models(sides),
    statistics(pair, sides),
    coefficients(sides),
    curves(pair, names),
  );
}

const models = (sides) =>
  modelList(
    sides.map(({ fit, name }) => ({
      name,
      fit,
      further: fit.variance.function === "none" ? [] : [`variance: ${varianceText(fit.variance)}`],
      verdict: [element("br"), verdictMark(fit.converged), ` ${fit.verdict}`],
    })),
  );

/** Digits of differences between libraries, of the statistics that are compared. */
const DIGITS = { r2: 4, rmse: 4, log_likelihood: 2, aic: 2, bic: 2 };

function statistics({ differences, unit }, sides) {
  const rows = [...statisticRows(unit), { name: "Trees", key: "n", of: (fit) => fit.n, format: count }];
  const own = ({ fit, name }) => ({ title: name, raw: (row) => row.of(fit, best(fit)), value: (row) => row.format(row.of(fit, best(fit))) });
  const differing = differences.map((difference, index) => ({ difference, side: sides.find((side) => side.index === index + 1) })).filter(({ difference, side }) => difference !== null && side);
  const change = ({ difference, side }) => ({
    title: `Difference, ${side.name}`,
    raw: (row) => (row.key in DIGITS ? difference[row.key] : null),
    value: (row) => (row.key in DIGITS ? signed(DIGITS[row.key])(difference[row.key]) : ""),
  });
  return table("Accuracy and criteria", [{ title: "Statistic", text: true, value: ({ name }) => name }, ...sides.map(own), ...differing.map(change)], rows);
}

function coefficients(sides) {
  const names = [...new Set(sides.flatMap(({ fit }) => Object.keys(fit.fixed)))];
  const columns = sides.flatMap(({ fit, name }) => [
    numeric(name, (coefficient) => fit.fixed[coefficient]?.estimate ?? null, significant),
    numeric(`Standard error, ${name}`, (coefficient) => fit.fixed[coefficient]?.se ?? null, (value) => significant(value, 3)),
  ]);
  return table("Fixed coefficients", [{ title: "Coefficient", text: true, value: (coefficient) => element("code", {}, coefficient) }, ...columns], names);
}

function curves({ curves: drawn, response, unit }, names) {
  if (drawn === null) return element("p", { class: "small" }, "No curves: none of the fits has a range of DBH.");
  const lines = drawn.values.map((values, index) => ({ values, index })).filter(({ values }) => values !== null);
  const layers = lines.map(({ values, index }) => lineLayer(kindOf(index), drawn.dbh, values)).filter(hasValues);
  const name = responseName(response);
  const held = Object.entries(drawn.held_at).map(([column, value]) => `${columnName(column)} ${significant(value, 3)}`);
  const notes = [
    "Population predictions (b = 0), each over its own range of DBH.",
    held.length > 0 ? `${capital(listing(held))}: the middle of the common range of the fits.` : "",
    drawn.own_heights ? "Heights are those of each library's height model." : "",
  ];
  const chart = {
    label: `${name} against DBH: curves of ${listing(lines.map(({ index }) => names[index]))}. The table behind the chart has the values.`,
    x: { title: "DBH (cm)", domain: extent(drawn.dbh) },
    y: { title: unit === "" ? name : `${name} (${unit})`, domain: extent(...lines.map(({ values }) => values)) },
    layers,
  };
  const at = (values) => (index) => values[index];
  const columns = [
    numeric("DBH, cm", at(drawn.dbh), (value) => decimals(value, 1)),
    ...lines.map(({ values, index }) => numeric(names[index], at(values), (value) => decimals(value, 2))),
    ...(lines.length === 2 ? [numeric("Difference", (index) => difference(lines[0].values[index], lines[1].values[index]), signed(2))] : []),
  ];
  const rows = gridRows(drawn.dbh).map(({ index }) => index);
  return figure({
    title: `${name} against DBH`,
    legend: lines.map(({ index }) => [`line-${kindOf(index)}${index === 0 ? " dashed" : ""}`, names[index]]),
    note: notes.filter((note) => note !== "").join(" "),
    charts: [chartElement(chart)],
    behind: () => [table(`Curves of ${name.toLowerCase()}`, columns, rows)],
  });
}

const difference = (first, second) => (first === null || second === null ? null : second - first);

function versions({ versions: list }) {
  return section("versions", "Made by", {}, element("p", {}, `${listing(list.map(({ name, version }) => `${name} ${version}`))}.`));
}
