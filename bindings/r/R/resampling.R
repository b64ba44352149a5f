# SPDX-License-Identifier: MIT
# The bootstrap and cross-validation of fits.

#' Bootstrap of a fit
#'
#' Refits the model to resampled data, for standard errors and intervals of all parameters. Replicates that do not converge are counted and
#' are in no figure.
#'
#' @param object a fit of [silvafit()]
#' @eval setting_params("bootstrap")
#' @param seed seed of the random numbers; without it, it is drawn by R, so that [set.seed()] has effect. Results do not depend on the number of threads
#' @param threads number of threads; 0 means all cores
#' @param progress show the progress in the console
#' @return List of class `silvafit_bootstrap`: `parameters`, a data frame with the estimate, the number of replicates that have a value, bias,
#'   standard error, percentile and basic intervals of each parameter; `values`, a matrix with a row for each replicate; `replicates` and
#'   `converged`, their numbers; `failures` and `boundary`, data frames of the reasons of replicates that did not converge, or are boundary
#'   (singular) fits, with their numbers.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' bootstrap(fit, 20, threads = 1)
bootstrap <- function(object, replicates = 500, resample = c("parametric", "cases"), level = 0.95, seed = NULL, group = "", threads = 0,
                      progress = interactive()) {
  if (is.null(seed)) seed <- drawn_seed()
  needs_data(object, "bootstrap()")
  settings <- list(refit = object$options, replicates = replicates, resample = match.arg(resample), level = level, seed = seed, group = group, threads = threads)
  found <- analysis_of_fit("bootstrap", object, settings, progress = progress)
  tables <- lapply(found$tables[c("parameters", "failures", "boundary")], as.data.frame)
  for (kind in c("failures", "boundary")) tables[[kind]]$reason <- r_names(object, tables[[kind]]$reason)
  names <- r_names(object, tables$parameters$name)
  tables$parameters <- data.frame(tables$parameters[-1], row.names = names)
  values <- matrix(unlist(found$tables$values), ncol = length(names), dimnames = list(NULL, names))
  structure(c(tables, list(values = values), found$json, settings[c("resample", "level", "seed")]), class = "silvafit_bootstrap")
}

print.silvafit_bootstrap <- strict(function(x, digits = 4, ...) {
  cat(x$resample, " bootstrap, ", x$converged, " of ", x$replicates, " replicates converged; ", 100 * x$level, "% intervals\n\n", sep = "")
  print(x$parameters, digits = digits)
  for (kind in c("failures", "boundary")) {
    if (nrow(x[[kind]]) > 0) print_notes(paste0(if (kind == "failures") "not converged" else "boundary", ": ", x[[kind]]$reason, " (", x[[kind]]$replicates, ")"))
  }
  invisible(x)
})

#' Cross-validation of a fit
#'
#' Predicts each group by a fit to the others.
#'
#' @param object a fit of [silvafit()]
#' @eval setting_params("cross-validation")
#' @param seed seed of the random numbers; without it, it is drawn by R, so that [set.seed()] has effect
#' @param threads number of threads; 0 means all cores
#' @param progress show the progress in the console
#' @return Data frame with the rows of the fit and the columns `fold`, `observed`, `predicted` (random effects 0) and, with `measured`,
#'   `calibrated` (NA for the measured rows). Attributes: `population` and `calibrated` have R2, mean error, RMSE and MAE, `mean_log_density` the mean
#'   log predictive density, `failed` the folds without a fit.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' attr(cross_validate(fit, 5, threads = 1), "population")
cross_validate <- function(object, folds = 10, group = "", measured = 0, seed = NULL, threads = 0, progress = interactive()) {
  needs_data(object, "cross_validate()")
  if (is.null(seed)) seed <- drawn_seed()
  settings <- list(refit = object$options, folds = folds, group = group, measured = measured, seed = seed, threads = threads)
  result <- analysis_of_fit("cross_validate", object, settings, progress = progress)
  table <- data.frame(result$tables$rows, row.names = row.names(object$frame)[result$rows])
  table$fold <- as.integer(table$fold) + 1L
  table <- table[order(result$rows), , drop = FALSE]
  statistics <- function(values) vapply(values, number_or_na, 0)
  attr(table, "population") <- statistics(result$json$population)
  if (measured > 0) attr(table, "calibrated") <- statistics(result$json$calibrated$statistics)
  attr(table, "mean_log_density") <- number_or_na(result$json$mean_log_density)
  attr(table, "failed") <- lapply(result$json$failed, function(fold) list(groups = fold$groups, message = fold$verdict))
  table
}
