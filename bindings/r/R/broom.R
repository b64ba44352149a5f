# SPDX-License-Identifier: MIT
# Methods for generics of broom, emmeans, insight and performance, registered when these are loaded.

#' Tidy a fit
#'
#' Methods for \pkg{broom}.
#'
#' @param x a fit of [silvafit()]
#' @param effects `"fixed"` or `"ran_pars"` (standard deviations and correlations), or both
#' @param conf.int add Wald confidence intervals
#' @param conf.level confidence level
#' @param data,newdata data to augment; the data of the fit by default
#' @param ... not used; for `augment()` arguments of [predict.silvafit()]
#' @return Data frames (tibbles if \pkg{tibble} is installed) as of other models.
#' @name broom-methods
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' if (requireNamespace("broom", quietly = TRUE)) {
#'   broom::tidy(fit, conf.int = TRUE)
#'   broom::glance(fit)
#' }
NULL

#' @rdname broom-methods
#' @exportS3Method broom::tidy
tidy.silvafit <- function(x, effects = c("fixed", "ran_pars"), conf.int = FALSE, conf.level = 0.95, ...) {
  no_further(list(...))
  check_flag(conf.int, "conf.int")
  effects <- match.arg(effects, several.ok = TRUE)
  table <- fixed_table(x)
  parts <- list()
  if ("fixed" %in% effects) {
    parts$fixed <- data.frame(effect = "fixed", group = NA_character_, term = rownames(table), estimate = table[, "Value"], std.error = table[, "Std.Error"],
                              df = table[, "DF"], statistic = table[, "t-value"], p.value = table[, "p-value"])
  }
  if ("ran_pars" %in% effects) {
    components <- as.data.frame(VarCorr(x))
    term <- ifelse(is.na(components$var1), "sd__Observation",
                   ifelse(is.na(components$var2), paste0("sd__", components$var1), paste0("cor__", components$var1, ".", components$var2)))
    parts$random <- data.frame(effect = "ran_pars", group = components$grp, term = term, estimate = components$sdcor, std.error = NA_real_,
                               df = NA_real_, statistic = NA_real_, p.value = NA_real_)
  }
  result <- do.call(rbind, parts)
  row.names(result) <- NULL
  if (conf.int) {
    intervals <- parameter_intervals(x, conf.level, "wald")
    at <- c(if ("fixed" %in% effects) match(rownames(table), intervals$name),
            if ("ran_pars" %in% effects) which(intervals$kind %in% c("sd", "cor", "sigma"))[order_of_components(x, intervals)])
    result$conf.low <- intervals$lower[at]
    result$conf.high <- intervals$upper[at]
  }
  as_tibble_if_there(result)
}

# The intervals of standard deviations and correlations in the order of as.data.frame(VarCorr(x)).
order_of_components <- function(x, intervals) {
  chosen <- intervals$kind %in% c("sd", "cor", "sigma")
  names <- intervals$name[chosen]
  components <- as.data.frame(VarCorr(x))
  suffix <- if (length(grouping_counts(x)) > 1) paste0(" | ", components$grp) else ""
  wanted <- ifelse(is.na(components$var1), "sigma",
                   ifelse(is.na(components$var2), paste0("sd(", components$var1, suffix, ")"),
                          paste0("cor(", components$var1, ", ", components$var2, suffix, ")")))
  match(wanted, names)
}

#' @rdname broom-methods
#' @exportS3Method broom::glance
glance.silvafit <- function(x, ...) {
  no_further(list(...))
  as_tibble_if_there(data.frame(
    sigma = sigma(x), logLik = as.numeric(logLik(x)), AIC = number_or_na(x$fit$aic), BIC = number_or_na(x$fit$bic), nobs = nobs(x),
    df.residual = df.residual(x), method = x$fit$method, converged = x$fit$converged,
    r2.marginal = number_or_na(x$fit$r2_marginal), r2.conditional = number_or_na(x$fit$r2_conditional)))
}

#' @rdname broom-methods
#' @exportS3Method broom::augment
augment.silvafit <- function(x, data = NULL, newdata = NULL, ...) {
  if (!is.null(newdata)) {
    predicted <- stats::predict(x, newdata, ...)
    if (is.data.frame(predicted)) {
      names(predicted) <- c(fit = ".fitted", lwr = ".lower", upr = ".upper", se.fit = ".se.fit")[names(predicted)]
    } else {
      predicted <- data.frame(.fitted = as.vector(predicted))
    }
    return(as_tibble_if_there(cbind(newdata, predicted)))
  }
  no_further(list(...), instead = c(level = "without newdata, .fitted is conditional and .fixed has random effects 0"))
  needs_data(x, "augment()")
  frame <- x$frame
  if (!is.null(data)) {
    if (nrow(data) != nrow(x$frame)) stop_usage("`data` has ", nrow(data), " rows, but the fit uses ", nrow(x$frame), "; omit `data`")
    frame <- data
  }
  as_tibble_if_there(cbind(frame, data.frame(.fitted = fitted_at(x, "conditional"), .resid = response_values(x) - fitted_at(x, "conditional"),
                                             .std.resid = (response_values(x) - fitted_at(x, "conditional")) / x$residual_sd, .fixed = fitted_at(x, "population"))))
}

as_tibble_if_there <- function(data) if (requireNamespace("tibble", quietly = TRUE)) tibble::as_tibble(data) else data

#' Estimated marginal means
#'
#' Methods for \pkg{emmeans}: the means of one parameter of the model, such as `emmeans(fit, ~ species, param = "a")`.
#'
#' @param object a fit of [silvafit()]
#' @param param parameter that has the sub-model
#' @param data not used: the fit has its data
#' @param trms,xlev,grid,... as in the generics of \pkg{emmeans}
#' @return What the generics of \pkg{emmeans} need.
#' @name emmeans-methods
#' @examples
#' if (requireNamespace("emmeans", quietly = TRUE)) {
#'   fit <- silvafit(weight ~ a / (1 + exp((m - Time) / s)), data = nlme::Soybean,
#'                   parameters = a ~ Variety, random = a ~ 1 | Plot)
#'   emmeans::emmeans(fit, ~ Variety, param = "a")
#' }
NULL

sub_model_of <- function(object, param) {
  formulas <- sub_model_formulas(eval(object$call$parameters, environment(object$formula)))
  if (missing(param) || is.null(param) || !param %in% names(formulas)) {
    stop_usage("`param` has to name a parameter with a sub-model: ", paste(names(formulas), collapse = ", "))
  }
  formulas[[param]]
}

#' @rdname emmeans-methods
#' @exportS3Method emmeans::recover_data
recover_data.silvafit <- function(object, param, data = NULL, ...) {
  needs_data(object, "emmeans()")
  terms <- stats::delete.response(stats::terms(sub_model_of(object, param)))
  frame <- object$frame
  for (name in names(frame)) if (is.character(frame[[name]])) frame[[name]] <- factor(frame[[name]])
  emmeans::recover_data(object$call, terms, na.action = NULL, data = frame, ...)
}

#' @rdname emmeans-methods
#' @exportS3Method emmeans::emm_basis
emm_basis.silvafit <- function(object, trms, xlev, grid, param, ...) {
  frame <- stats::model.frame(trms, grid, na.action = stats::na.pass, xlev = xlev)
  contrasts <- object$contrasts[intersect(names(object$contrasts), names(xlev))]
  matrix <- stats::model.matrix(trms, frame, contrasts.arg = contrasts)
  columns <- ifelse(colnames(matrix) == "(Intercept)", param, paste0(param, ":", colnames(matrix)))
  at <- match(columns, names(fixef(object)))
  if (anyNA(at)) stop_usage("the coefficients ", paste(columns[is.na(at)], collapse = ", "), " are not in the fit")
  df <- fixed_table(object)[at, "DF"]
  list(X = matrix, bhat = fixef(object)[at], nbasis = matrix(NA), V = vcov(object)[at, at, drop = FALSE],
       dffun = function(k, dfargs) dfargs$df, dfargs = list(df = min(df, na.rm = TRUE)), misc = list())
}

#' Coefficients of determination
#'
#' Methods for \pkg{performance} and \pkg{insight}. R2 of a mixed model is that of Nakagawa and Schielzeth (2013) and Johnson (2014).
#'
#' @param model,x a fit of [silvafit()]
#' @param ... no further arguments; unknown names stop
#' @return As of other models: `r2()` a list with `R2_marginal` and `R2_conditional`, or `R2` without random effects.
#' @name performance-methods
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' if (requireNamespace("performance", quietly = TRUE)) performance::r2(fit)
NULL

#' @rdname performance-methods
#' @exportS3Method performance::r2
r2.silvafit <- function(model, ...) {
  # performance passes arguments of its own, which do not apply: verbose, ci, tolerance.
  no_further(list(...), c("verbose", "ci", "tolerance", "estimator", "iterations"))
  if (!has_random(model)) {
    return(structure(list(R2 = c(R2 = model$fit$statistics$population$r2)), class = "r2_generic"))
  }
  structure(list(R2_conditional = c("Conditional R2" = model$fit$r2_conditional), R2_marginal = c("Marginal R2" = model$fit$r2_marginal)), class = "r2_nakagawa")
}

#' @rdname performance-methods
#' @details The generics of \pkg{insight} pass arguments of other models to all methods (`verbose`, `component`, ...); those that do not
#'   apply are ignored there.
#' @exportS3Method performance::check_singularity
check_singularity.silvafit <- function(x, ...) {
  no_further(list(...), c("tolerance", "verbose"))
  # A coefficient at a bound is no boundary of the random effects.
  kinds <- vapply(x$fit$evidence$findings, `[[`, "", "kind")
  has_random(x) && any(kinds == "boundary")
}

#' @rdname performance-methods
#' @param metrics names of the measures, or `"all"`
#' @exportS3Method performance::model_performance
model_performance.silvafit <- function(model, metrics = "all", ...) {
  no_further(list(...), c("verbose", "estimator"))
  all <- c(list(AIC = number_or_na(model$fit$aic), AICc = number_or_na(model$fit$aicc), BIC = number_or_na(model$fit$bic)),
           if (has_random(model)) list(R2_conditional = number_or_na(model$fit$r2_conditional), R2_marginal = number_or_na(model$fit$r2_marginal))
           else list(R2 = number_or_na(model$fit$statistics$population$r2)),
           list(RMSE = if (is.null(model$frame)) NA_real_ else sqrt(mean(residuals(model)^2, na.rm = TRUE)), Sigma = sigma(model)))
  if (!identical(metrics, "all")) {
    unknown <- setdiff(metrics, c(names(all), "R2"))
    if (length(unknown) > 0) stop_usage("`metrics`: unknown measure '", unknown[1], "'; available: ", paste(names(all), collapse = ", "))
    all <- all[names(all) %in% metrics | ("R2" %in% metrics & startsWith(names(all), "R2"))]
  }
  structure(as.data.frame(all), class = c("performance_model", "data.frame"))
}

#' @rdname performance-methods
#' @param effects `"fixed"`, or `"random"`: the standard deviations and correlations
#' @exportS3Method insight::get_parameters
get_parameters.silvafit <- function(x, effects = "fixed", ...) {
  if (identical(effects, "random")) {
    components <- tidy.silvafit(x, "ran_pars")
    return(data.frame(Parameter = components$term, Estimate = components$estimate, Group = components$group))
  }
  data.frame(Parameter = names(fixef(x)), Estimate = as.vector(fixef(x)))
}

#' @rdname performance-methods
#' @exportS3Method insight::find_formula
find_formula.silvafit <- function(x, ...) {
  random <- random_formulas(x)
  structure(c(list(conditional = without_bars(x$formula)), if (length(random) > 0) list(random = random)), class = c("insight_formula", "list"))
}

# The random effects as formulas of lme4: ~ a + b | plot; one, or a list for two groupings.
random_formulas <- function(x) {
  groups <- names(random_terms_of(x))
  formulas <- lapply(seq_along(groups), function(i) {
    effects <- vapply(random_terms_of(x)[[i]]$effects, name_text, "")
    within <- paste(vapply(groups[seq_len(i)], name_text, ""), collapse = ":")
    stats::as.formula(paste("~", paste(effects, collapse = " + "), "|", within), globalenv())
  })
  if (length(formulas) == 1) formulas[[1]] else formulas
}

#' @rdname performance-methods
#' @exportS3Method insight::model_info
model_info.silvafit <- function(x, ...) {
  info <- insight::model_info(stats::lm(y ~ x, data.frame(y = c(1, 2, 2), x = 1:3)))
  info$is_mixed <- has_random(x)
  info$is_linear <- FALSE
  info$n_obs <- nobs(x)
  info
}

#' @rdname performance-methods
#' @exportS3Method insight::get_data
get_data.silvafit <- function(x, ...) x$frame

#' @rdname performance-methods
#' @exportS3Method insight::find_statistic
find_statistic.silvafit <- function(x, ...) "t-statistic"

#' @rdname performance-methods
#' @exportS3Method insight::get_statistic
get_statistic.silvafit <- function(x, ...) data.frame(Parameter = names(fixef(x)), Statistic = as.vector(fixed_table(x)[, "t-value"]))
