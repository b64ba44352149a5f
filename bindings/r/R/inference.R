# SPDX-License-Identifier: MIT
# Confidence intervals and comparisons of fits.

#' Confidence intervals of all parameters
#'
#' `confint()` has the fixed effects, the standard deviations and correlations of the random effects, the parameters of the
#' residuals' correlation and of the variance function, sigma, and derived quantities. `intervals()` returns the Wald intervals in the form
#' of [nlme::intervals()].
#'
#' Wald intervals of variance parameters are those of nlme: on the scales of the logarithm and of Fisher's z.
#' Profile-likelihood intervals refit the model for each limit; they take longer and are more accurate.
#'
#' @param object a fit of [silvafit()]
#' @param parm names or numbers of parameters; all if missing
#' @param level confidence level
#' @param method `"wald"`, `"profile"`, or `"boot"`: percentile intervals of [bootstrap()]
#' @param replicates,seed of the bootstrap
#' @param which `"all"`, `"var-cov"` or `"fixed"`
#' @param threads number of threads; 0 means all cores
#' @param ... no further arguments; unknown names stop
#' @return `confint()`: matrix with a row for each parameter; the attribute `notes` explains limits that are not known or do not
#'   exist. `intervals()`: list of class `intervals.silvafit` with the elements `fixed`, `derived` (quantities of `derive`), `reStruct`,
#'   `corStruct`, `varStruct` and `sigma`.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' confint(fit, c("Asym", "sigma"))
#' intervals(fit)
confint.silvafit <- strict(function(object, parm, level = 0.95, method = c("wald", "profile", "boot"), threads = 1, replicates = 500, seed = NULL, ...) {
  # lme4 writes "Wald".
  if (is.character(method)) method <- tolower(method)
  method <- match.arg(method)
  if (method != "boot" && !(missing(replicates) && missing(seed))) stop_usage("`replicates` and `seed` are those of `method = \"boot\"`")
  result <- if (method == "boot") bootstrap_intervals(object, level, threads, replicates, seed) else parameter_intervals(object, level, method, threads)
  table <- cbind(result$lower, result$upper)
  dimnames(table) <- list(result$name, limit_names(level))
  if (!missing(parm)) {
    unknown <- if (is.character(parm)) setdiff(parm, rownames(table)) else setdiff(abs(parm), seq_len(nrow(table)))
    if (length(unknown) > 0) stop_usage("unknown parameter '", unknown[1], "'; available: ", paste(rownames(table), collapse = ", "))
    table <- table[parm, , drop = FALSE]
  }
  notes <- stats::setNames(result$note, result$name)[rownames(table)]
  if (any(notes != "")) attr(table, "notes") <- notes[notes != ""]
  structure(table, class = c("confint.silvafit", class(table)))
}, instead = c(conf.level = "use level", nsim = "use replicates", oldNames = "names are those of the coefficients"))

limit_names <- function(level) paste(format(100 * c(1 - level, 1 + level) / 2, trim = TRUE, digits = 3), "%")

#' Profiles of the likelihood
#'
#' The likelihood with each parameter held at values around its estimate, of all parameters that [confint.silvafit()] has.
#'
#' @param fitted a fit of [silvafit()]
#' @param which names or numbers of parameters; all by default
#' @param alphamax 1 - confidence level that the profiles reach
#' @param delta.t step between two values, as signed root of the likelihood ratio
#' @param threads number of threads; 0 means all cores
#' @param ... no further arguments; unknown names stop
#' @return Object of the class of [stats::profile.nls()], which `plot()` shows: for each parameter `tau`, the signed root of the likelihood ratio, and
#'   `par.vals`, the values of the parameter there. `confint()` interpolates the limits of intervals; those of `confint(fit, method = "profile")` are exact.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' confint(profile(fit, "R0"))
profile.silvafit <- strict(function(fitted, which = NULL, alphamax = 0.01, delta.t = cutoff / 5, threads = 1, ...) {
  # A root is the quantile of a level: the limits of intervals of many levels are the profile.
  df <- if (fitted$fit$method == "ols") df.residual(fitted) else Inf
  cutoff <- stats::qt(1 - alphamax / 2, df)
  roots <- seq(delta.t, by = delta.t, length.out = ceiling(cutoff / delta.t))
  found <- lapply(roots, function(root) parameter_intervals(fitted, 1 - 2 * stats::pt(-root, df), "profile", threads))
  names <- found[[1]]$name
  chosen <- if (is.null(which)) seq_along(names) else if (is.character(which)) match(which, names) else which
  if (anyNA(chosen) || !all(chosen %in% seq_along(names))) stop_usage("`which`: available parameters are ", paste(names, collapse = ", "))
  curves <- lapply(stats::setNames(chosen, names[chosen]), function(k) {
    at <- function(end) vapply(found, function(one) one[[end]][k], 0)
    values <- c(rev(at("lower")), found[[1]]$estimate[k], at("upper"))
    # At the end of a parameter's range the root is not that of the level.
    kind <- found[[1]]$kind[k]
    is_known <- is.finite(values) & (kind == "fixed" | values != 0) & (kind != "correlation" | abs(values) != 1)
    tau <- c(-rev(roots), 0, roots)[is_known]
    structure(list(tau = tau, par.vals = matrix(values[is_known], dimnames = list(NULL, names[k]))), class = "data.frame", row.names = seq_along(tau))
  })
  # What plot() of stats reads.
  structure(curves, original.fit = fitted, summary = list(df = c(nobs(fitted) - df.residual(fitted), df)), class = c("profile.silvafit", "profile.nls", "profile"))
})

#' @rdname profile.silvafit
#' @param object a profile
#' @param parm names or numbers of its parameters
#' @param level confidence level
confint.profile.silvafit <- strict(function(object, parm = names(object), level = 0.95, ...) {
  if (is.numeric(parm)) parm <- names(object)[parm]
  if (!all(parm %in% names(object))) stop_usage("`parm`: available are ", paste(names(object), collapse = ", "))
  roots <- c(-1, 1) * stats::qt((1 + level) / 2, attr(object, "summary")$df[2])
  limits <- t(vapply(parm, function(name) {
    curve <- object[[name]]
    ifelse(roots < min(curve$tau) | roots > max(curve$tau), NA, stats::splinefun(curve$tau, curve$par.vals)(roots))
  }, roots))
  dimnames(limits) <- list(parm, limit_names(level))
  limits
})

print.confint.silvafit <- strict(function(x, digits = getOption("digits"), ...) {
  notes <- attr(x, "notes")
  attr(x, "notes") <- NULL
  print(unclass(x), digits = digits)
  print_notes(notes)
  invisible(x)
})

print_notes <- function(notes) {
  if (length(notes) == 0) return(invisible())
  texts <- if (is.null(names(notes))) notes else paste0(names(notes), ": ", notes)
  cat("\n", paste(strwrap(texts, exdent = 2), collapse = "\n"), "\n", sep = "")
}

bootstrap_intervals <- function(object, level, threads, replicates, seed) {
  found <- bootstrap(object, replicates, level = level, seed = seed, threads = threads, progress = FALSE)$parameters
  list(name = row.names(found), lower = found$percentile_lower, upper = found$percentile_upper,
       note = ifelse(is.na(found$percentile_lower), "too few replicates", ""))
}

parameter_intervals <- function(object, level, method, threads = 1) {
  needs_data(object, "confidence intervals")
  result <- analysis_of_fit("intervals", object, list(method = method, level = level, threads = threads))$tables$parameters
  result$name <- r_names(object, result$name)
  result$note <- r_names(object, result$note)
  result
}

#' @rdname confint.silvafit
intervals.silvafit <- strict(function(object, level = 0.95, which = c("all", "var-cov", "fixed"), ...) {
  which <- match.arg(which)
  result <- parameter_intervals(object, level, "wald")
  rows <- function(kinds) {
    chosen <- result$kind %in% kinds
    table <- cbind(lower = result$lower, est. = result$estimate, upper = result$upper)[chosen, , drop = FALSE]
    rownames(table) <- result$name[chosen]
    table
  }
  parts <- list()
  if (which != "var-cov") {
    parts$fixed <- rows("fixed")
    if (any(result$kind == "derived")) parts$derived <- rows("derived")
  }
  if (which != "fixed") {
    random <- rows(c("standard deviation", "correlation"))
    if (nrow(random) > 0) {
      groups <- names(grouping_counts(object))
      # With two groupings, names end with "| group)".
      of_group <- if (length(groups) == 1) rep(groups, nrow(random)) else sub(".*\\| (.*)\\)$", "\\1", rownames(random))
      parts$reStruct <- lapply(split(seq_len(nrow(random)), factor(of_group, groups)), function(i) as.data.frame(random[i, , drop = FALSE]))
    }
    if (any(result$kind == "residual correlation")) parts$corStruct <- rows("residual correlation")
    if (any(result$kind == "variance function")) parts$varStruct <- rows("variance function")
    parts$sigma <- rows("sigma")[1, ]
  }
  shown <- result$note != "" & (which == "all" | result$kind %in% c("fixed", "derived") == (which == "fixed"))
  structure(parts, level = level, notes = stats::setNames(result$note, result$name)[shown], class = "intervals.silvafit")
}, instead = c(conf.level = "use level"))

print.intervals.silvafit <- strict(function(x, digits = getOption("digits"), ...) {
  cat("Approximate ", 100 * attr(x, "level"), "% confidence intervals\n", sep = "")
  parts <- c(list("Fixed effects" = x$fixed, "Derived quantities" = x$derived), stats::setNames(x$reStruct, if (length(x$reStruct) > 0) paste("Random effects,", names(x$reStruct))),
             list("Residual correlation" = x$corStruct, "Variance function" = x$varStruct, "Residual standard deviation (sigma)" = x$sigma))
  for (title in names(Filter(Negate(is.null), parts))) {
    cat("\n ", title, ":\n", sep = "")
    print(parts[[title]], digits = digits)
  }
  print_notes(attr(x, "notes"))
  invisible(x)
})

#' Compare fits by information criteria and likelihood-ratio tests
#'
#' With several fits, each is tested against the one with the next fewer parameters, if it contains it. If the larger model has
#' further variances, the p value is that of a mixture of chi-squared distributions (Self and Liang 1987, Stram and Lee 1994), because
#' a variance of 0 is at the boundary of its range; nlme uses the chi-squared distribution there, which is conservative. Fits to different
#' observations, by different methods or by REML with different fixed effects are not compared.
#'
#' With one fit, its terms are tested by Wald's F as in [nlme::anova.lme()].
#'
#' @param object a fit of [silvafit()]
#' @param ... further fits
#' @param type for one fit: `"sequential"`, each term given those before it, in the order of the coefficients; `"marginal"`, given all others
#' @param Terms names or numbers of terms to test together
#' @param L matrix with a column for each coefficient, or named vector: linear combinations to test together
#' @return Data frame of class `anova`. The attribute `notes` has what there is to know of the tests.
#' @examples
#' curve <- height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age)
#' one <- silvafit(curve, data = Loblolly, random = Asym ~ 1 | Seed)
#' two <- silvafit(curve, data = Loblolly, random = list(Asym ~ 1 | Seed, R0 ~ 1 | Seed))
#' anova(one, two)
#' anova(one, type = "marginal")
#' anova(one, L = c(Asym = 1, R0 = 1))
anova.silvafit <- function(object, ..., type = c("sequential", "marginal"), Terms = NULL, L = NULL) {
  type <- tryCatch(match.arg(type), error = function(e) stop_usage("`type` has to be \"sequential\" or \"marginal\""))
  further <- list(...)
  # Fits may have names, as in do.call(anova, list_of_fits); other arguments have none here.
  no_further(Filter(function(one) !is.list(one), further))
  if (length(further) == 0) return(wald_tests(object, type, Terms, L))
  if (!is.null(Terms) || !is.null(L)) stop_usage("`Terms` and `L` are for one fit")
  fits <- c(list(object), further)
  if (!all(vapply(fits, inherits, logical(1), what = "silvafit"))) {
    stop_usage("only fits of silvafit() can be compared; refit the others with silvafit()")
  }
  names <- vapply(as.list(substitute(list(object, ...)))[-1], function(one) if (is.language(one)) deparse1(one) else "fit", "")
  compared_fits(fits, names)
}

# Two fits with data have the same responses in the same groups; the order of the rows may differ.
require_same_rows <- function(one, other) {
  if (is.null(one$frame) || is.null(other$frame) || names(one$frame)[1] != names(other$frame)[1]) return(invisible())
  shared <- Reduce(intersect, list(c(names(one$frame)[1], grouping_names(one), grouping_names(other)), names(one$frame), names(other$frame)))
  rows <- function(fit) sort(do.call(paste, c(lapply(fit$frame[shared], as.character), sep = "\001")))
  if (!identical(rows(one), rows(other))) {
    stop_usage("the fits have other rows or groups, ", nobs(one), " and ", nobs(other), " rows; fit both to the same, for example with `subset`")
  }
}

compared_fits <- function(fits, names) {
  for (fit in fits[-1]) require_same_rows(fits[[1]], fit)
  result <- analysis("compare", objects = lapply(fits, `[[`, "handle"))
  failed <- 1 + unlist(result$json$failed)
  order <- c(1 + result$tables$fits$fit, failed)
  fits <- fits[order]
  value <- function(key) vapply(fits, function(fit) number_or_na(fit$fit[[key]]), 0)
  table <- data.frame(Model = seq_along(fits), df = value("k"), AIC = value("aic"), BIC = vapply(fits, stats::BIC, 0), logLik = value("log_likelihood"),
                      Test = "", L.Ratio = NA_real_, "p-value" = NA_real_, check.names = FALSE, row.names = make.unique(names[order]))
  tests <- as.data.frame(result$tables$tests)
  pair <- paste(1 + tests$smaller, "vs", 1 + tests$larger)
  done <- !is.na(tests$df)
  at <- 1 + tests$larger[done]
  table$Test[at] <- pair[done]
  table$L.Ratio[at] <- tests$statistic[done]
  table$`p-value`[at] <- tests$p[done]
  notes <- c(Filter(nzchar, result$json$reason), paste0(pair, ": ", tests$note)[nzchar(tests$note)],
             if (length(failed) > 0) paste("not converged:", paste(names[failed], collapse = ", ")))
  structure(table, heading = "Comparison of fits\n", notes = notes, class = c("anova.silvafit", "anova", "data.frame"))
}

wald_tests <- function(object, type = "marginal", chosen = NULL, L = NULL) {
  tests <- function(...) analysis_of_fit("term_tests", object, list(...), NULL)$tables$terms
  heading <- paste("Wald tests of the terms of each parameter, given", if (type == "marginal") "all others" else "those before")
  if (!is.null(L)) {
    found <- tests(combinations = matrix_of_combinations(L, fixed_table(object)))
    heading <- "Wald test of linear combinations"
  } else if (!is.null(chosen)) {
    terms <- r_names(object, tests()$term)
    at <- if (is.character(chosen)) match(chosen, terms) else match(chosen, seq_along(terms))
    if (anyNA(at)) stop_usage("`Terms`: unknown term '", chosen[is.na(at)][1], "'; available: ", paste(terms, collapse = ", "))
    found <- tests(terms = as.list(at - 1))
    heading <- paste("Wald test of", paste(terms[at], collapse = ", "))
  } else {
    found <- tests(sequential = type == "sequential")
  }
  result <- data.frame(numDF = found$df, denDF = found$df_denominator, "F-value" = found$statistic, "p-value" = found$p, check.names = FALSE,
                       row.names = r_names(object, found$term))
  structure(result, heading = paste0(heading, "\n"), class = c("anova.silvafit", "anova", "data.frame"))
}

# Rows of all coefficients; L has those that are estimated, or some by their names.
matrix_of_combinations <- function(L, table) {
  coefficients <- rownames(table)[is.finite(table[, "Std.Error"])]
  if (!is.numeric(L)) stop_usage("`L` has to be a numeric matrix or vector")
  if (!is.matrix(L)) L <- t(L)
  if (is.null(colnames(L)) && ncol(L) == length(coefficients)) colnames(L) <- coefficients
  unknown <- setdiff(colnames(L), coefficients)
  if (is.null(colnames(L)) || length(unknown) > 0) stop_usage("`L` needs a column for each coefficient, or columns with their names: ", paste(coefficients, collapse = ", "))
  whole <- matrix(0, nrow(L), nrow(table), dimnames = list(NULL, rownames(table)))
  whole[, colnames(L)] <- L
  whole
}

print.anova.silvafit <- strict(function(x, digits = max(getOption("digits") - 2, 3), ...) {
  cat(attr(x, "heading"))
  shown <- as.data.frame(unclass(x)[names(x)], row.names = row.names(x), check.names = FALSE)
  names(shown) <- names(x)
  for (name in intersect(c("AIC", "BIC", "logLik", "L.Ratio", "F-value"), names(shown))) {
    shown[[name]] <- ifelse(is.na(shown[[name]]), "", format(shown[[name]], digits = digits + 2))
  }
  shown$`p-value` <- ifelse(is.na(shown$`p-value`), "", format.pval(shown$`p-value`, digits = 3, eps = 1e-4))
  print(shown)
  print_notes(attr(x, "notes"))
  invisible(x)
})
