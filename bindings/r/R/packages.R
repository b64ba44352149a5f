# SPDX-License-Identifier: MIT
# Methods for generics of insight, performance, parameters, lmtest, multcomp, lme4 and marginaleffects, registered when these are loaded.

#' Methods for other packages
#'
#' Methods for \pkg{performance}, \pkg{insight}, \pkg{parameters}, \pkg{lmtest}, \pkg{multcomp}, \pkg{lme4} and \pkg{marginaleffects}. R2 of a mixed model is that of Nakagawa and Schielzeth (2013) and Johnson (2014).
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
check_singularity.silvafit <- strict(function(x, ...) {
  # A coefficient at a bound is no boundary of the random effects.
  kinds <- vapply(x$fit$evidence$findings, `[[`, "", "kind")
  has_random(x) && any(kinds == "boundary")
}, c("tolerance", "verbose"))

#' @rdname performance-methods
check_convergence.silvafit <- strict(function(x, ...) structure(isTRUE(x$fit$converged), gradient = number_or_na(x$fit$evidence$gradient)), "tolerance")

#' @rdname performance-methods
performance_aicc.silvafit <- function(x, ...) number_or_na(x$fit$aicc)

#' @rdname performance-methods
#' @param metrics names of the measures, or `"all"`
model_performance.silvafit <- strict(function(model, metrics = "all", ...) {
  r2 <- lapply(list(R2_conditional = model$fit$r2_conditional, R2_marginal = model$fit$r2_marginal), number_or_na)
  all <- c(list(AIC = number_or_na(model$fit$aic), AICc = number_or_na(model$fit$aicc), BIC = stats::BIC(model)),
           if (has_random(model)) c(r2, ICC = (r2[[1]] - r2[[2]]) / (1 - r2[[2]])) else list(R2 = number_or_na(model$fit$statistics$population$r2)),
           list(RMSE = if (is.null(model$frame)) NA_real_ else sqrt(mean(residuals(model)^2, na.rm = TRUE)), Sigma = sigma(model)))
  if (!identical(metrics, "all")) {
    unknown <- setdiff(metrics, c(names(all), "R2"))
    if (length(unknown) > 0) stop_usage("`metrics`: unknown measure '", unknown[1], "'; available: ", paste(names(all), collapse = ", "))
    all <- all[names(all) %in% metrics | ("R2" %in% metrics & startsWith(names(all), "R2"))]
  }
  structure(as.data.frame(all), class = c("performance_model", "data.frame"))
}, c("verbose", "estimator"))

#' @rdname performance-methods
#' @param effects `"fixed"`, or `"random"`: the standard deviations and correlations
get_parameters.silvafit <- function(x, effects = "fixed", ...) {
  if (identical(effects, "random")) {
    components <- tidy.silvafit(x, "ran_pars")
    return(data.frame(Parameter = components$term, Estimate = components$estimate, Group = components$group))
  }
  data.frame(Parameter = names(fixef(x)), Estimate = as.vector(fixef(x)))
}

#' @rdname performance-methods
#' @param ci coverage of the intervals
#' @details `model_parameters()` has the rows and columns of fits of \pkg{lme4}: the fixed effects, and with `effects = "all"` or `"random"` the standard deviations and
#'   correlations with Wald intervals.
model_parameters.silvafit <- function(model, ci = 0.95, effects = "all", ...) {
  if (!effects %in% c("all", "fixed", "random")) stop_usage("`effects` has to be \"all\", \"fixed\" or \"random\"")
  fixed <- utils::getS3method("model_parameters", "default", envir = asNamespace("parameters"))(model, ci = ci, effects = "fixed", ...)
  if (effects == "fixed" || !has_random(model)) return(fixed)
  components <- as.data.frame(variance_components(model))
  term <- ifelse(is.na(components$var1), "SD (Observations)", ifelse(is.na(components$var2), paste0("SD (", components$var1, ")"),
                                                                      paste0("Cor (", components$var1, "~", components$var2, ")")))
  random <- as.data.frame(fixed)[rep(NA_integer_, length(term)), ]
  random[c("Parameter", "Coefficient", "CI")] <- list(term, components$sdcor, ci)
  if (!is.null(model$frame)) {
    limits <- as.data.frame(parameter_intervals(model, ci, "wald"))
    random[c("CI_low", "CI_high")] <- limits[match(names_of_components(model), limits$name), c("lower", "upper")]
  }
  table <- rbind(cbind(as.data.frame(fixed), Effects = "fixed", Group = ""), cbind(random, Effects = "random", Group = components$grp))
  shown <- table[effects == "all" | table$Effects == "random", ]
  kept <- attributes(fixed)[setdiff(names(attributes(fixed)), c("names", "row.names", "pretty_names"))]
  attributes(shown) <- c(list(names = names(shown), row.names = seq_len(nrow(shown)), pretty_names = stats::setNames(shown$Parameter, shown$Parameter)), kept)
  attr(shown, "ignore_group") <- FALSE
  attr(shown, "ran_pars") <- TRUE
  shown
}

#' @rdname performance-methods
#' @param objects,only_models,verbose as in the generic
#' @details `compare_performance()` takes fits with others. \pkg{insight} knows models by a fixed list of classes; within the comparison the fits have one of them as their
#'   last class.
ellipsis_info.silvafit <- function(objects, ..., only_models = TRUE, verbose = TRUE) {
  fits <- list(objects, ...)
  responses <- lapply(fits, function(fit) if (inherits(fit, "silvafit")) as.vector(fit$frame[[1]]) else insight::get_response(fit))
  known <- lapply(fits, function(fit) if (inherits(fit, "silvafit")) structure(fit, class = c(class(fit), "lavaan")) else fit)
  structure(known, names = vapply(as.list(substitute(list(objects, ...)))[-1], deparse1, ""), class = c("ListModels", "list"),
            same_response = all(vapply(responses, identical, NA, responses[[1]])))
}

#' @rdname performance-methods
find_formula.silvafit <- function(x, ...) {
  random <- random_formulas(x)
  # The predictors are the columns that the mean reads; parameters are none.
  mean <- if (is.null(x$frame)) without_bars(x$formula) else stats::formula(stats::terms(x))
  structure(c(list(conditional = mean), if (length(random) > 0) list(random = random)), class = c("insight_formula", "list"))
}

# The random effects as formulas of lme4: ~ a + b | plot; one, or a list for two groupings.
random_formulas <- function(x) {
  groups <- names(random_terms_of(x))
  formulas <- lapply(seq_along(groups), function(i) {
    effects <- vapply(random_terms_of(x)[[i]]$effects, name_text, "")
    within <- if (is_crossed(x)) groups[i] else paste(vapply(groups[seq_len(i)], name_text, ""), collapse = ":")
    stats::as.formula(paste("~", paste(effects, collapse = " + "), "|", within), globalenv())
  })
  if (length(formulas) == 1) formulas[[1]] else formulas
}

#' @rdname performance-methods
model_info.silvafit <- function(x, ...) {
  info <- insight::model_info(stats::lm(y ~ x, data.frame(y = c(1, 2, 2), x = 1:3)))
  info$is_mixed <- has_random(x)
  info$is_linear <- FALSE
  info$n_obs <- nobs(x)
  info
}

#' @rdname performance-methods
get_data.silvafit <- function(x, ...) x$frame

#' @rdname performance-methods
#' @param type,data as in the generics
get_df.silvafit <- function(x, type = "residual", ...) if (identical(type, "model")) x$fit$k else stats::setNames(fixed_table(x)[, "DF"], names(fixef(x)))

#' @rdname performance-methods
get_loglikelihood.silvafit <- function(x, ...) logLik(x)

#' @rdname performance-methods
get_predicted.silvafit <- function(x, data = NULL, ...) as.vector(stats::predict(x, data))

#' @rdname performance-methods
find_algorithm.silvafit <- function(x, ...) list(algorithm = method_title(x))

#' @rdname performance-methods
#' @param component component of the variance
#' @details `get_variance()`, and with it `performance::icc()`, has the shares of the variance of Johnson (2014), as [r2()][performance::r2] has.
get_variance.silvafit <- function(x, component = "all", ...) {
  if (!has_random(x)) stop_usage("the fit has no random effects")
  marginal <- number_or_na(x$fit$r2_marginal)
  conditional <- number_or_na(x$fit$r2_conditional)
  fixed <- stats::var(as.vector(fitted(x, level = "population")), na.rm = TRUE)
  total <- fixed / marginal
  values <- list(var.fixed = fixed, var.random = (conditional - marginal) * total, var.residual = (1 - conditional) * total,
                 var.distribution = (1 - conditional) * total, var.dispersion = 0)
  if (identical(component, "all")) values else values[[paste0("var.", component)]]
}

#' @rdname performance-methods
#' @method find_statistic silvafit
find_statistic.silvafit <- function(x, ...) "t-statistic"

#' @rdname performance-methods
get_statistic.silvafit <- function(x, ...) data.frame(Parameter = names(fixef(x)), Statistic = as.vector(fixed_table(x)[, "t-value"]))

#' @rdname performance-methods
degrees_of_freedom.silvafit <- function(model, ...) as.vector(fixed_table(model)[, "DF"])

#' @rdname performance-methods
#' @method ci silvafit
ci.silvafit <- function(x, ci = 0.95, ...) {
  limits <- fixed_limits(x, ci)
  data.frame(Parameter = rownames(limits), CI = ci, CI_low = as.vector(limits[, 1]), CI_high = as.vector(limits[, 2]))
}

# Wald intervals of the fixed effects; those that are held have none.
fixed_limits <- function(x, level) {
  limits <- unclass(stats::confint(x, level = level))
  limits <- limits[match(names(fixef(x)), rownames(limits)), , drop = FALSE]
  rownames(limits) <- names(fixef(x))
  limits
}

#' @rdname performance-methods
#' @param vcov. covariance matrix of the fixed effects, or a function of the fit
#' @param df degrees of freedom; by default those of the fit
coeftest.silvafit <- strict(function(x, vcov. = NULL, df = NULL, ...) {
  table <- fixed_table(x)
  covariance <- if (is.function(vcov.)) vcov.(x) else if (is.null(vcov.)) vcov.silvafit(x) else vcov.
  error <- ifelse(is.na(table[, "Std.Error"]), NA, sqrt(diag(covariance)))
  if (is.null(df)) df <- table[, "DF"]
  t <- table[, "Value"] / error
  result <- cbind(Estimate = table[, "Value"], "Std. Error" = error, "t value" = t, "Pr(>|t|)" = 2 * stats::pt(-abs(t), df))
  structure(result, class = "coeftest", method = "t test of coefficients", df = df, nobs = nobs(x), logLik = logLik(x))
}, "save")

#' @rdname performance-methods
#' @details `lrtest()` stops for fits that [anova.silvafit()] does not compare: to other rows or groups, or by REML with other fixed effects.
lrtest.silvafit <- function(object, ...) {
  fits <- Filter(function(one) inherits(one, "silvafit"), list(object, ...))
  for (fit in fits[-1]) {
    require_same_rows(object, fit)
    is_other <- !identical(names(fixef(fit)), names(fixef(object))) || !identical(fit$formula, object$formula)
    if (is_other && (isTRUE(object$fit$reml) || isTRUE(fit$fit$reml))) stop_usage("fits by REML with different fixed effects cannot be compared; use update(fit, method = \"ML\")")
  }
  utils::getS3method("lrtest", "default", envir = asNamespace("lmtest"))(object, ...)
}

#' @rdname performance-methods
#' @param parm,level as in [confint.silvafit()]
coefci.silvafit <- strict(function(x, parm = names(fixef(x)), level = 0.95, ...) fixed_limits(x, level)[parm, , drop = FALSE])

#' @rdname performance-methods
#' @param coef. the fixed effects, or a function of the fit
modelparm.silvafit <- function(model, coef. = fixef, vcov. = vcov.silvafit, df = NULL, ...) {
  value <- function(what) if (is.function(what)) what(model) else what
  estimate <- value(coef.)
  structure(list(coef = estimate, vcov = value(vcov.), df = if (is.null(df)) min(fixed_table(model)[, "DF"], na.rm = TRUE) else df,
                 estimable = rep(TRUE, length(estimate))), class = "modelparm")
}

#' @rdname performance-methods
#' @param object a fit of [silvafit()]
#' @method ngrps silvafit
ngrps.silvafit <- function(object, ...) grouping_counts(object)

#' @rdname performance-methods
#' @method isREML silvafit
isREML.silvafit <- function(x, ...) isTRUE(x$fit$reml)

#' @rdname performance-methods
#' @method get_coef silvafit
get_coef.silvafit <- function(model, ...) fixef(model)

#' @rdname performance-methods
#' @param coefs fixed effects in the place of those of the fit
#' @method set_coef silvafit
set_coef.silvafit <- function(model, coefs, ...) {
  model$handle <- engine(.Call(C_with_estimates, model$handle, as.numeric(coefs)))
  model
}

#' @rdname performance-methods
#' @param vcov as in the generic
#' @method get_vcov silvafit
get_vcov.silvafit <- function(model, vcov = NULL, ...) if (is.matrix(vcov)) vcov else vcov.silvafit(model)

#' @rdname performance-methods
#' @param newdata data frame
#' @details For \pkg{marginaleffects}, whose predictions are those of the population, set `options(marginaleffects_model_classes = "silvafit")`.
#' @method get_predict silvafit
get_predict.silvafit <- function(model, newdata = model$frame, type = "response", ...) {
  data.frame(rowid = seq_len(nrow(newdata)), estimate = as.vector(stats::predict(model, newdata, level = "population")))
}

#' @rdname performance-methods
#' @param name element of the fit: `"theta"`, `"lower"`, `"beta"`, `"sigma"`, `"y"`, `"n"`, `"p"`, `"q"`, `"cnms"`, `"flist"`, `"l_i"` or `"n_rtrms"`, or several
#' @details `getME()` has the elements of \pkg{lme4} that such fits have, so that [lme4::isSingular()] works, too.
#' @method getME silvafit
getME.silvafit <- strict(function(object, name, ...) {
  terms <- random_terms_of(object)
  of_factor <- function(value) unname(unlist(lapply(terms, function(term) value(lower_factor(term$covariance) / sigma(object)))))
  triangle <- function(values) values[lower.tri(values, diag = TRUE)]
  elements <- list(theta = of_factor(triangle), lower = of_factor(function(factor) triangle(ifelse(diag(nrow(factor)) == 1, 0, -Inf))), beta = unname(fixef(object)),
                   fixef = fixef(object), sigma = sigma(object), y = response_values(object), n = nobs(object), p = length(fixef(object)),
                   q = sum(vapply(terms, function(term) length(unlist(term$modes)), 0L)), cnms = lapply(terms, `[[`, "effects"), l_i = unname(grouping_counts(object)),
                   n_rtrms = length(terms), flist = if (!is.null(object$frame) && has_random(object)) as.list(group_frame(object)))
  if (!all(name %in% names(elements))) stop_unknown(setdiff(name, names(elements))[1], names(elements), "getME() of such a fit has no element")
  if (length(name) == 1) elements[[name]] else elements[name]
})

# The Cholesky factor of a covariance matrix, which may be singular: from a square root, by QR.
lower_factor <- function(covariance) {
  parts <- eigen(covariance, symmetric = TRUE)
  upper <- qr.R(qr(sqrt(pmax(parts$values, 0)) * t(parts$vectors), tol = 0))
  t(upper * ifelse(diag(upper) < 0, -1, 1))
}

#' @rdname performance-methods
#' @param newresp new responses of the rows of the fit
#' @details `refit()` fits to new responses, such as those of [simulate.silvafit()]; `refitML()` without restricted likelihood.
#' @method refit silvafit
refit.silvafit <- function(object, newresp = NULL, ...) {
  no_further(list(...), "newresp")
  needs_call(object, "refit()")
  response <- object$formula[[2]]
  if (!is.name(response)) stop_usage("the left side ", deparse1(response), " is not a column; use update(fit, data = ...)")
  data <- getData.silvafit(object)
  if (!is.null(newresp)) data[[as.character(response)]] <- if (is.data.frame(newresp)) newresp[[1]] else as.vector(newresp)
  stats::update(object, data = data, subset = NULL)
}

#' @rdname performance-methods
#' @method refitML silvafit
refitML.silvafit <- function(x, ...) if (isTRUE(x$fit$reml)) stats::update(x, reml = FALSE) else x

#' @rdname performance-methods
#' @method isLMM silvafit
isLMM.silvafit <- function(x, ...) FALSE

#' @rdname performance-methods
#' @method isGLMM silvafit
isGLMM.silvafit <- isLMM.silvafit

#' @rdname performance-methods
#' @method isNLMM silvafit
isNLMM.silvafit <- function(x, ...) has_random(x)

#' @rdname performance-methods
#' @param mod a fit of [silvafit()]
#' @details For \pkg{car}: `Anova()` has the Wald tests of [anova.silvafit()] of type III, given all other terms; `linearHypothesis()` and `deltaMethod()` are those of
#'   the fixed effects.
#' @method Anova silvafit
Anova.silvafit <- strict(function(mod, type = "III", test.statistic = "F", ...) {
  if (!type %in% c("III", "3", 3)) stop_usage("`type` has to be \"III\": terms of different parameters of a nonlinear model are not marginal to each other, so that type II is not defined")
  if (!identical(test.statistic, "F")) stop_usage("`test.statistic` has to be \"F\"; for tests of likelihood ratios use drop1()")
  tests <- anova.silvafit(mod, type = "marginal")
  structure(tests, heading = paste("Type III:", attr(tests, "heading")))
})

#' @rdname performance-methods
#' @method linearHypothesis silvafit
linearHypothesis.silvafit <- function(model, ...) {
  utils::getS3method("linearHypothesis", "default", envir = asNamespace("car"))(model, ..., vcov. = vcov.silvafit(model), coef. = fixef(model), suppress.vcov.msg = TRUE)
}

#' @rdname performance-methods
#' @method deltaMethod silvafit
deltaMethod.silvafit <- function(object, ...) car::deltaMethod(fixef(object), ..., vcov. = vcov.silvafit(object))
