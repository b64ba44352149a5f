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
  # performance passes arguments of its own, which do not apply: tolerance, estimator.
  no_further(with_effect(list(...)), c("tolerance", "estimator", "iterations"))
  if (!has_random(model)) {
    return(structure(list(R2 = c(R2 = model$fit$statistics$population$r2)), class = "r2_generic"))
  }
  structure(list(R2_conditional = c("Conditional R2" = model$fit$r2_conditional), R2_marginal = c("Marginal R2" = model$fit$r2_marginal)), class = "r2_nakagawa")
}

#' @rdname performance-methods
#' @details The generics of these packages pass arguments of other models to all methods (`verbose`, `component`, ...). Values that change nothing are accepted; others stop.
check_singularity.silvafit <- strict(function(x, ...) {
  # A coefficient at a bound is no boundary of the random effects.
  kinds <- vapply(x$fit$evidence$findings, `[[`, "", "kind")
  has_random(x) && any(kinds == "boundary")
}, c("tolerance", "verbose"))

#' @rdname performance-methods
check_convergence.silvafit <- strict(function(x, ...) structure(isTRUE(x$fit$converged), gradient = number_or_na(x$fit$evidence$gradient)), "tolerance")

#' @rdname performance-methods
performance_aicc.silvafit <- for_others(function(x, estimator = own_estimator(x), ...) {
  require_own_estimator(x, estimator)
  number_or_na(x$fit$aicc)
})

own_estimator <- function(x) if (isTRUE(x$fit$reml)) "REML" else "ML"

require_own_estimator <- function(x, estimator) {
  if (!identical(estimator, own_estimator(x))) stop_usage("the fit has the likelihood that it maximizes, ", own_estimator(x), "; refit with update(fit, method = \"", estimator, "\")")
}

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
get_parameters.silvafit <- for_others(function(x, effects = "fixed", ...) {
  effects <- one_of(effects, c("fixed", "random"), "effects")
  if (effects == "random") {
    components <- tidy.silvafit(x, "ran_pars")
    return(data.frame(Parameter = components$term, Estimate = components$estimate, Group = components$group))
  }
  data.frame(Parameter = names(fixef(x)), Estimate = as.vector(fixef(x)))
})

#' @rdname performance-methods
#' @param ci coverage of the intervals
#' @param ci_method,method of intervals: `"wald"` (the default), `"normal"` (without degrees of freedom), `"profile"` or `"boot"`, as in [confint.silvafit()]
#' @param ci_random intervals of the standard deviations and correlations; by default the fixed effects and these have them
#' @param bootstrap,iterations estimates and intervals by [bootstrap()], and the number of its replicates
#' @details `model_parameters()` has the rows and columns of fits of \pkg{lme4}: the fixed effects, and with `effects = "all"` or `"random"` the standard deviations and
#'   correlations. Tests are those of [summary.silvafit()] with all kinds of intervals but `"normal"`. Of the arguments of \pkg{parameters}, `exponentiate`, `p_adjust`, `keep`, `drop` and `summary` are accepted, too.
model_parameters.silvafit <- function(model, ci = 0.95, effects = "all", ci_method = NULL, ci_random = NULL, bootstrap = FALSE, iterations = 1000, ...) {
  effects <- one_of(effects, c("all", "fixed", "random"), "effects")
  check_flag(bootstrap, "bootstrap")
  passed <- c("exponentiate", "p_adjust", "keep", "drop", "summary", "verbose")
  no_further(with_effect(list(...)), passed, c(df_method = "use ci_method", conf.level = "use ci"))
  further <- list(...)[intersect(names(list(...)), passed)]
  if (length(ci) > 1) stop_usage("`ci` has to be one coverage, or NULL for no intervals")
  table_of <- function(...) do.call(utils::getS3method("model_parameters", "default", envir = asNamespace("parameters")), c(list(model, ci = ci, effects = "fixed", ...), further))
  if (bootstrap) {
    if (effects == "random" || isTRUE(ci_random)) stop_usage("`bootstrap` is for fixed effects here; bootstrap(fit) has all parameters")
    return(table_of(bootstrap = TRUE, iterations = iterations, ci_method = ci_method))
  }
  if (!missing(iterations)) stop_usage("`iterations` is that of `bootstrap = TRUE`")
  kind <- interval_kind(ci_method)
  fixed <- table_of(ci_method = if (kind == "normal") kind else "wald")
  limits <- if (!is.null(ci) && !is.null(model$frame)) limits_of_kind(model, ci, kind)
  if (!is.null(limits) && kind %in% c("profile", "boot")) {
    fixed[c("CI_low", "CI_high")] <- limits[match(fixed$Parameter, rownames(limits)), ]
    attr(fixed, "ci_method") <- kind
  }
  if (effects == "fixed" || !has_random(model)) return(fixed)
  components <- as.data.frame(variance_components(model))
  term <- ifelse(is.na(components$var1), "SD (Observations)", ifelse(is.na(components$var2), paste0("SD (", components$var1, ")"),
                                                                      paste0("Cor (", components$var1, "~", components$var2, ")")))
  random <- as.data.frame(fixed)[rep(NA_integer_, length(term)), ]
  random[c("Parameter", "Coefficient")] <- list(term, components$sdcor)
  if (!is.null(limits) && !isFALSE(ci_random)) random[c("CI", "CI_low", "CI_high")] <- data.frame(ci, limits[match(names_of_components(model), rownames(limits)), ])
  table <- rbind(cbind(as.data.frame(fixed), Effects = "fixed", Group = ""), cbind(random, Effects = "random", Group = components$grp))
  shown <- table[effects == "all" | table$Effects == "random", ]
  kept <- attributes(fixed)[setdiff(names(attributes(fixed)), c("names", "row.names", "pretty_names"))]
  attributes(shown) <- c(list(names = names(shown), row.names = seq_len(nrow(shown)), pretty_names = stats::setNames(shown$Parameter, shown$Parameter)), kept)
  attr(shown, "ignore_group") <- FALSE
  attr(shown, "ran_pars") <- TRUE
  shown
}

# The kinds of intervals in the words of easystats.
interval_kind <- function(method) {
  kinds <- c(wald = "wald", residual = "wald", analytical = "wald", any = "wald", normal = "normal", profile = "profile", boot = "boot")
  if (is.null(method)) "wald" else kinds[[one_of(tolower(method), names(kinds), "ci_method")]]
}

# Limits of all parameters, in a row for each.
limits_of_kind <- function(x, level, kind) {
  limits <- unclass(stats::confint(x, level = level, method = if (kind == "normal") "wald" else kind))
  if (kind == "normal") {
    held <- is.na(fixed_table(x)[, "Std.Error"])
    limits[names(fixef(x))[!held], ] <- (fixef(x) + outer(fixed_table(x)[, "Std.Error"], c(-1, 1)) * stats::qnorm((1 + level) / 2))[!held, ]
  }
  limits
}

#' @rdname performance-methods
#' @param type type of the bootstrap: `"parametric"`, or `"cases"`, whole groups; of predictions `"response"`; of degrees of freedom `"residual"`, `"wald"`, `"normal"` or `"model"`, the number of parameters
#' @details `bootstrap_model()`, and with it `bootstrap_parameters()`, refits by [bootstrap()], so that groups stay together.
bootstrap_model.silvafit <- for_others(function(model, iterations = 1000, type = "parametric", ...) {
  values <- bootstrap(model, iterations, one_of(type, c("parametric", "cases"), "type"), progress = FALSE)$values[, names(fixef(model)), drop = FALSE]
  draws <- as.data.frame(values[stats::complete.cases(values), , drop = FALSE], optional = TRUE)
  structure(draws, class = c("bootstrap_model", "see_bootstrap_model", "data.frame"), original_model = model)
})

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
find_formula.silvafit <- for_others(function(x, ...) {
  random <- random_formulas(x)
  # The predictors are the columns that the mean reads; parameters are none.
  mean <- if (is.null(x$frame)) without_bars(x$formula) else stats::formula(stats::terms(x))
  structure(c(list(conditional = mean), if (length(random) > 0) list(random = random)), class = c("insight_formula", "list"))
})

# The groups of random effects as formulas of lme4, ~ 1 + C | plot: effects are those of coefficients, which are no variables, and of covariates. One, or a list for two groupings.
random_formulas <- function(x) {
  groups <- names(random_terms_of(x))
  formulas <- lapply(seq_along(groups), function(i) {
    factors <- unlist(lapply(x$fit$random[[i]]$effects, function(effect) if (grepl(":", effect, fixed = TRUE)) all.vars(str2lang(sub("^[^:]*:", "", effect)))))
    covariates <- intersect(factors, names(x$frame))
    effects <- c("1", vapply(covariates, name_text, ""))
    within <- if (is_crossed(x)) groups[i] else paste(vapply(groups[seq_len(i)], name_text, ""), collapse = ":")
    stats::as.formula(paste("~", paste(effects, collapse = " + "), "|", within), globalenv())
  })
  if (length(formulas) == 1) formulas[[1]] else formulas
}

#' @rdname performance-methods
model_info.silvafit <- for_others(function(x, ...) {
  info <- insight::model_info(stats::lm(y ~ x, data.frame(y = c(1, 2, 2), x = 1:3)))
  info$is_mixed <- has_random(x)
  info$is_linear <- FALSE
  info$n_obs <- nobs(x)
  info
}, list(response = 1))

#' @rdname performance-methods
get_data.silvafit <- for_others(function(x, effects = "all", ...) {
  effects <- one_of(effects, c("all", "fixed", "random"), "effects")
  groups <- intersect(grouping_names(x), names(x$frame))
  fixed <- unique(c(names(x$frame)[1], all.vars(stats::formula(stats::terms(x)))))
  if (effects == "all") x$frame else x$frame[if (effects == "random") groups else intersect(fixed, names(x$frame))]
}, list(source = c("environment", "frame", "mf")))

#' @rdname performance-methods
#' @param data as in the generics
get_df.silvafit <- for_others(function(x, type = "residual", ...) {
  switch(one_of(type, c("residual", "wald", "normal", "model"), "type"), model = x$fit$k, normal = Inf, stats::setNames(fixed_table(x)[, "DF"], names(fixef(x))))
})

#' @rdname performance-methods
#' @param REML,estimator the likelihood that the fit maximizes; another one stops
get_loglikelihood.silvafit <- for_others(function(x, estimator = own_estimator(x), REML = NULL, ...) {
  if (!is.null(REML)) estimator <- if (isTRUE(REML)) "REML" else "ML"
  require_own_estimator(x, estimator)
  logLik(x)
}, list(check_response = FALSE))

#' @rdname performance-methods
#' @param predict `"expectation"`, or `"prediction"` of new observations, which have other intervals
#' @param include_random with the random effects of the groups; by default if `data` has groups of the fit only
#' @details `get_predicted()` has intervals with `ci`, as `as.data.frame()` of it shows.
get_predicted.silvafit <- for_others(function(x, data = NULL, predict = "expectation", ci = NULL, include_random = "default", ...) {
  predict <- one_of(predict, c("expectation", "response", "relation", "link", "prediction"), "predict")
  if (identical(include_random, "default")) include_random <- has_groups_of_fit(x, if (is.null(data)) x$frame else data)
  check_flag(include_random, "include_random")
  level <- if (include_random) "conditional" else "population"
  if (is.null(ci)) return(structure(as.vector(stats::predict(x, data, level = level)), class = c("get_predicted", "numeric"), data = data, predict = predict))
  found <- stats::predict(x, data, level = level, interval = if (predict == "prediction") predict else "confidence", coverage = ci, se.fit = TRUE)
  structure(found$fit, class = c("get_predicted", "numeric"), data = data, ci = ci, predict = predict,
            ci_data = data.frame(SE = found$se.fit, CI_low = found$lwr, CI_high = found$upr))
}, list(ci_method = "wald"))

# Whether the random effects of all rows are known.
has_groups_of_fit <- function(x, data) {
  columns <- grouping_names(x)
  all(columns %in% names(data)) && all(vapply(columns, function(name) all(as.character(data[[name]]) %in% as.character(x$frame[[name]])), NA))
}

#' @rdname performance-methods
find_algorithm.silvafit <- for_others(function(x, ...) list(algorithm = method_title(x)))

#' @rdname performance-methods
#' @param component component of the variance
#' @details `get_variance()`, and with it `performance::icc()`, has the shares of the variance of Johnson (2014), as [r2()][performance::r2] has.
get_variance.silvafit <- for_others(function(x, component = "all", ...) {
  component <- one_of(component, c("all", "fixed", "random", "residual", "distribution", "dispersion"), "component")
  if (!has_random(x)) stop_usage("the fit has no random effects")
  marginal <- number_or_na(x$fit$r2_marginal)
  conditional <- number_or_na(x$fit$r2_conditional)
  fixed <- stats::var(as.vector(fitted(x, level = "population")), na.rm = TRUE)
  total <- fixed / marginal
  values <- list(var.fixed = fixed, var.random = (conditional - marginal) * total, var.residual = (1 - conditional) * total,
                 var.distribution = (1 - conditional) * total, var.dispersion = 0)
  if (component == "all") values else values[[paste0("var.", component)]]
}, list(tolerance = NULL, name_fun = NULL, name_full = NULL))

#' @rdname performance-methods
#' @method find_statistic silvafit
find_statistic.silvafit <- for_others(function(x, ...) "t-statistic")

#' @rdname performance-methods
get_statistic.silvafit <- for_others(function(x, ...) data.frame(Parameter = names(fixef(x)), Statistic = as.vector(fixed_table(x)[, "t-value"])))

#' @rdname performance-methods
degrees_of_freedom.silvafit <- for_others(function(model, method = "wald", ...) {
  if (interval_kind(method) == "normal") Inf else as.vector(fixed_table(model)[, "DF"])
})

#' @rdname performance-methods
#' @method ci silvafit
ci.silvafit <- for_others(function(x, ci = 0.95, method = NULL, ...) {
  do.call(rbind, lapply(ci, function(level) {
    limits <- fixed_limits(x, level, interval_kind(method))
    data.frame(Parameter = rownames(limits), CI = level, CI_low = as.vector(limits[, 1]), CI_high = as.vector(limits[, 2]))
  }))
})

# Intervals of the fixed effects; those that are held have none.
fixed_limits <- function(x, level, kind = "wald") {
  limits <- limits_of_kind(x, level, kind)
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
#' @details `lrtest()` has the tests of [anova.silvafit()] and stops where that has none: for fits to other rows or groups, of other responses, by other methods, not nested, or by REML
#'   with other fixed effects.
lrtest.silvafit <- function(object, ...) {
  fits <- list(object, ...)
  if (length(fits) < 2 || !all(vapply(fits, inherits, NA, "silvafit"))) stop_usage("lrtest() compares fits of silvafit(), such as lrtest(fit, larger)")
  table <- utils::getS3method("lrtest", "default", envir = asNamespace("lmtest"))(object, ...)
  for (i in seq_along(fits)[-1]) {
    compared <- compared_fits(fits[c(i - 1, i)], c("1", "2"))
    if (!any(nzchar(compared$Test))) stop_usage("fits ", i - 1, " and ", i, " cannot be compared: ", paste(c(attr(compared, "notes"), "they are not nested")[1]))
    table$`Pr(>Chisq)`[i] <- compared$`p-value`[nzchar(compared$Test)]
  }
  table
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
ngrps.silvafit <- for_others(function(object, ...) grouping_counts(object))

#' @rdname performance-methods
#' @method isREML silvafit
isREML.silvafit <- for_others(function(x, ...) isTRUE(x$fit$reml))

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
get_vcov.silvafit <- function(model, vcov = NULL, ...) {
  if (is.matrix(vcov)) return(vcov)
  if (is.function(vcov)) return(vcov(model))
  if (!is.null(vcov) && !isTRUE(vcov)) stop_usage("`vcov` has to be a matrix or a function of the fit; other covariance matrices than that of the fit, such as \"HC3\", are not available")
  vcov.silvafit(model)
}

#' @rdname performance-methods
#' @param newdata data frame
#' @param re.form as in [predict.silvafit()]
#' @details For \pkg{marginaleffects}, whose predictions are those of the population unless there is `re.form = NULL`, set `options(marginaleffects_model_classes = "silvafit")`.
#' @method get_predict silvafit
get_predict.silvafit <- function(model, newdata = model$frame, type = "response", re.form = NA, ...) {
  one_of(type, c("response", "link"), "type")
  data.frame(rowid = seq_len(nrow(newdata)), estimate = as.vector(stats::predict(model, newdata, re.form = re.form)))
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
  name <- as.character(response)
  if (is.data.frame(newresp)) newresp <- newresp[[1]]
  if (!is.null(newresp)) data[[name]] <- response_like(newresp, data[[name]], object)
  stats::update(object, data = data, subset = NULL)
}

# New responses as those of the data: plain numbers are in the unit of the fit.
response_like <- function(values, own, object) {
  if (!is.numeric(values) || length(values) != length(own)) stop_usage("`newresp` has to be ", length(own), " numbers, one for each row of the fit")
  frame <- stats::setNames(data.frame(values), as.character(object$formula[[2]]))
  if (!inherits(values, "units")) return(if (inherits(own, "units")) units::set_units(as.vector(values), units::deparse_unit(own), mode = "standard") else as.vector(values))
  values <- in_units_of_fit(frame, object, "newresp")[[1]]
  units::set_units(values, units::deparse_unit(own), mode = "standard")
}

#' @rdname performance-methods
#' @method refitML silvafit
refitML.silvafit <- strict(function(x, ...) if (isTRUE(x$fit$reml)) stats::update(x, reml = FALSE) else x)

#' @rdname performance-methods
#' @method isLMM silvafit
isLMM.silvafit <- strict(function(x, ...) FALSE)

#' @rdname performance-methods
#' @method isGLMM silvafit
isGLMM.silvafit <- isLMM.silvafit

#' @rdname performance-methods
#' @method isNLMM silvafit
isNLMM.silvafit <- strict(function(x, ...) has_random(x))

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
