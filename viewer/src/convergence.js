// SPDX-License-Identifier: MIT
// Convergence of the final models, with the evidence.
import { element, section, verdictMark } from "./dom.js";
import { count, listing, MISSING, responseName, significant, withMinusSigns } from "./format.js";
import { resultId } from "./navigation.js";
import { numeric, table } from "./table.js";

const LEVELS = ["base", "covariates", "random", "variance"];

/** The fit of the last level that was reached. */
const final = ({ fits }) => fits.nlme ?? fits.covariates ?? fits.ols;
const tried = (result) => LEVELS.flatMap((level) => result[level]);
const failedRow = ({ converged }) => (converged ? null : "failed");

/** @param {Report} report */
export function convergence({ results }) {
  if (results.length === 0) return null;
  const rows = results.map((result, index) => ({ ...result, index, fit: final(result) }));
  const hasEvidence = rows.some(({ fit }) => fit?.evidence);
  const evidence = [
    numeric("Newton decrement", ({ fit }) => fit?.evidence?.gradient ?? null, (value) => significant(value, 2)),
    numeric("Iterations", ({ fit }) => fit?.evidence?.iterations ?? null, count),
    { title: "Boundary", text: true, value: ({ fit }) => (fit?.evidence ? listing(fit.evidence.boundary) || "none" : MISSING) },
  ];
  const columns = [
    { title: "Species, response", text: true, value: ({ index, species, response }) => element("a", { href: `#${resultId(index)}` }, `${species} ${responseName(response).toLowerCase()}`) },
    { title: "Final model", text: true, value: ({ converged }) => verdictMark(converged) },
    ...(hasEvidence ? evidence : []),
    numeric("Fits tried", (result) => tried(result).length, count),
    numeric("Not converged", (result) => tried(result).filter(({ converged }) => !converged).length, count),
    { title: "Convergence message", text: true, value: ({ verdict }) => element("span", { class: "sentence" }, withMinusSigns(verdict)) },
  ];
  return section(
    "convergence",
    "Convergence",
    {},
    table("Convergence of the final models", columns, rows, failedRow),
    hasEvidence ? element("p", { class: "small" }, "Newton decrement: squared distance to the optimum in standard errors; boundary: standard deviations of zero or correlations of one.") : null,
  );
}
