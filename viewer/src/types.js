// SPDX-License-Identifier: MIT
// The data of the page; docs/report-data.md has the full description.

/**
 * @typedef {{converged: boolean, verdict: string, k: number|null, log_likelihood: number|null, aic: number|null,
 *   bic: number|null, cv_rmse?: number|null, cv_failed_folds?: number|null, rank: number|null, chosen: boolean, objection?: string|null}} Criteria
 * @typedef {{r2: number|null, mean_error: number|null, rmse: number|null, mae: number|null}} Accuracy
 * @typedef {{likelihood_ratio: number|null, df: number|null, p: number|null}} LikelihoodRatio
 * @typedef {Criteria & Accuracy & {id: string, name: string, formula: string}} BaseCandidate
 * @typedef {Criteria & LikelihoodRatio & {parameters: string[]}} CovariateCandidate
 * @typedef {Criteria & {effects: string[], covariance: string}} RandomCandidate
 * @typedef {{function: string, of: string|null, delta: number|null, constant: number|null}} Variance
 * @typedef {Criteria & LikelihoodRatio & Variance} VarianceCandidate
 * @typedef {{group: string, effects: string[], sd: number[], correlation: number[][],
 *   eblup: Record<string, Record<string, number>>, eblup_se?: Record<string, Record<string, number|null>>}} Random
 * @typedef {{gradient: number|null, iterations: number, boundary: string[], rank: number}} Evidence
 * @typedef {{formula: string, parameters: Record<string, string>, method: string, n: number, converged: boolean,
 *   verdict: string, evidence?: Evidence, fixed: Record<string, {estimate: number, se: number, df: number, t: number, p: number}>,
 *   random: Random[], variance: Variance, sigma: number, log_likelihood: number, k: number, aic: number, bic: number,
 *   statistics: {population: Accuracy|null, conditional: Accuracy|null}}} Fit
 * @typedef {{plot: string[], tree: string[], dbh: number[], covariates: Record<string, (number|null)[]>, observed: number[], ols: number[], population: number[],
 *   conditional: number[], residual_ols: number[], residual_nlme: number[]}} Observations
 * @typedef {{covariate: string, classes: number[], trees: number[], covariates: (number|null)[][], population: (number|null)[][]}} ClassCurves
 * @typedef {{low: (number|null)[], high: (number|null)[]}} Band
 * @typedef {{held_at: Record<string, number>, dbh: number[], h?: number[], ols: number[], population: number[], ols_band?: Band, population_band?: Band,
 *   plots: Record<string, number[]>, by_class: ClassCurves[]}} Curves
 * @typedef {{name: string, version: string}} Version
 * @typedef {{folds: number, trees: number, rmse_ols: number|null, rmse_covariates: number|null, rmse_nlme: number|null, r2_ols?: number|null, r2_covariates?: number|null, r2_nlme?: number|null, t: number|null, worse: boolean}} LeftOut
 * @typedef {{species: string, response: string, unit: string, n: number, plots: number, converged: boolean,
 *   verdict: string, sound?: boolean, doubts?: string[], left_out?: LeftOut|null, outlying?: {plot: string, distance: number|null, p: number|null}[], notes: string[], base: BaseCandidate[], covariates: CovariateCandidate[],
 *   random: RandomCandidate[], variance: VarianceCandidate[], fits: {ols: Fit|null, covariates: Fit|null, nlme: Fit|null},
 *   gain: {population: number|null, conditional: number|null}, observations: Observations, curves: Curves|null}} Result
 * @typedef {{areas: {name: string|null, rings: number[][][]}[], buffer: number, torus: boolean, species_names: string[],
 *   layer_names: string[], area: (number|null)[], plot: string[], tree: string[], species: (number|null)[], x: (number|null)[],
 *   y: (number|null)[], dbh: (number|null)[], h: (number|null)[], cw: (number|null)[], layer: (number|null)[], core: number[],
 *   W: (number|null)[], M: (number|null)[], U: (number|null)[], C: (number|null)[], nearest: number[][]}} PlotMap
 * @typedef {{species: string, formula: string, trees: number, rmse: number|null, dbh: number[], h: (number|null)[]}} HeightCurve
 * @typedef {{tables: SummaryTable[], diameters: {low: number, high: number, trees: number, stems_per_ha: number|null, basal_area_per_ha: number|null}[],
 *   curves: HeightCurve[], left_out: string[]}} Stand
 * @typedef {{schema: string, silvafit: string, title: string, command: string, stand?: Stand,
 *   repeat: {fingerprint: string, versions: Version[]}, options: {name: string, value: string}[],
 *   inventory: {file: string, trees: number, plots: number, excluded: number,
 *     species: {code: string, name: string|null, trees: number, core: number|null, studied: boolean}[]},
 *   notes: string[], results: Result[], tables?: SummaryTable[], map?: PlotMap}} Report
 * @typedef {{name: string, caption: string, columns: {name: string, title: string, kind: string}[], rows: (string|number|null)[][]}} SummaryTable
 * @typedef {{log_likelihood: number|null, aic: number|null, bic: number|null, rmse: number|null, r2: number|null, reason: string|null}} Difference
 * @typedef {{species: string, response: string, role: string, unit: string, fits: (Fit|null)[], differences: (Difference|null)[],
 *   curves: {held_at: Record<string, number>, own_heights: boolean, dbh: number[], values: ((number|null)[]|null)[]}|null}} ComparedModels
 * @typedef {{schema: string, silvafit: string, title: string, versions: Version[],
 *   libraries: {name: string, file: string, fingerprint: string, trees: number, models: number}[], pairs: ComparedModels[]}} Comparison
 */
export {};
