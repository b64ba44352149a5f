# SPDX-License-Identifier: MIT
# Methods for generics of other packages, registered when these are loaded.

#' Tidy a fit
#'
#' Methods for \pkg{broom} and \pkg{broom.mixed}, whose generics are those of \pkg{generics}, and for \pkg{ggplot2}.
#'
#' @param x a fit of [silvafit()]
#' @param effects one or several of `"fixed"`, `"ran_pars"` (standard deviations and correlations), `"ran_vals"` (the random effects of each group) and
#'   `"ran_coefs"` (the coefficients of each group)
#' @param conf.method `"wald"`, `"profile"` or `"boot"`, as in [confint.silvafit()]
#' @param conf.int add Wald confidence intervals
#' @param conf.level confidence level
#' @param data the data of the fit, with further columns; others are an error
#' @param newdata data to predict
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
tidy.silvafit <- strict(function(x, effects = c("fixed", "ran_pars"), conf.int = FALSE, conf.level = 0.95, conf.method = "wald", ...) {
  check_flag(conf.int, "conf.int")
  effects <- match.arg(effects, c("fixed", "ran_pars", "ran_vals", "ran_coefs"), several.ok = TRUE)
  of_groups <- intersect(effects, c("ran_vals", "ran_coefs"))
  if (length(of_groups) > 0) {
    if (conf.int || length(of_groups) < length(effects)) stop_usage("`effects` of groups have no intervals, and are a table of their own")
    return(as_tibble_if_there(do.call(rbind, lapply(of_groups, tidy_groups, x = x))))
  }
  table <- fixed_table(x)
  parts <- list()
  if ("fixed" %in% effects) {
    parts$fixed <- data.frame(effect = "fixed", group = NA_character_, term = rownames(table), estimate = table[, "Value"], std.error = table[, "Std.Error"],
                              df = table[, "DF"], statistic = table[, "t-value"], p.value = table[, "p-value"])
  }
  if ("ran_pars" %in% effects) {
    components <- as.data.frame(variance_components(x))
    term <- ifelse(is.na(components$var1), "sd__Observation",
                   ifelse(is.na(components$var2), paste0("sd__", components$var1), paste0("cor__", components$var1, ".", components$var2)))
    parts$random <- data.frame(effect = "ran_pars", group = components$grp, term = term, estimate = components$sdcor, std.error = NA_real_,
                               df = NA_real_, statistic = NA_real_, p.value = NA_real_)
  }
  result <- do.call(rbind, parts)
  row.names(result) <- NULL
  if (conf.int) {
    intervals <- parameter_intervals(x, conf.level, tolower(conf.method))
    at <- c(if ("fixed" %in% effects) rownames(table), if ("ran_pars" %in% effects) names_of_components(x))
    result[c("conf.low", "conf.high")] <- as.data.frame(intervals)[match(at, intervals$name), c("lower", "upper")]
  }
  as_tibble_if_there(result)
})

# A row for each group and effect, or coefficient.
tidy_groups <- function(x, kind) {
  coefficients <- coef(x)
  parts <- lapply(names(random_terms_of(x)), function(group) {
    term <- random_terms_of(x)[[group]]
    values <- if (kind == "ran_vals") term$modes else if (is.data.frame(coefficients)) coefficients else coefficients[[group]]
    errors <- if (kind == "ran_vals" && !is.null(term$errors)) unlist(term$errors, use.names = FALSE) else NA_real_
    data.frame(effect = kind, group = group, level = rep(rownames(values), ncol(values)), term = rep(names(values), each = nrow(values)),
               estimate = unlist(values, use.names = FALSE), std.error = errors)
  })
  do.call(rbind, parts)
}

# The names that intervals have for the rows of as.data.frame(VarCorr(x)).
names_of_components <- function(x) {
  components <- as.data.frame(variance_components(x))
  suffix <- if (length(grouping_counts(x)) > 1) paste0(" | ", components$grp) else ""
  ifelse(is.na(components$var1), "sigma", ifelse(is.na(components$var2), paste0("sd(", components$var1, suffix, ")"),
                                                 paste0("cor(", components$var1, ", ", components$var2, suffix, ")")))
}

#' @rdname broom-methods
glance.silvafit <- strict(function(x, ...) {
  as_tibble_if_there(data.frame(
    sigma = sigma(x), logLik = as.numeric(logLik(x)), AIC = number_or_na(x$fit$aic), BIC = stats::BIC(x), nobs = nobs(x),
    df.residual = df.residual(x), method = x$fit$method, converged = x$fit$converged,
    r2.marginal = number_or_na(x$fit$r2_marginal), r2.conditional = number_or_na(x$fit$r2_conditional)))
})

#' @rdname broom-methods
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
    require_data_of_fit(x, data)
    frame <- data
  }
  as_tibble_if_there(cbind(frame, data.frame(.fitted = fitted_at(x, "conditional"), .resid = response_values(x) - fitted_at(x, "conditional"),
                                             .std.resid = (response_values(x) - fitted_at(x, "conditional")) / x$residual_sd, .fixed = fitted_at(x, "population"))))
}

# Fitted values belong to the rows of the fit, in their order.
require_data_of_fit <- function(x, data) {
  for (name in names(x$frame)) {
    is_response <- name == names(x$frame)[1] && !is.name(x$formula[[2]])
    if (is_response || (name %in% names(data) && has_values(x$frame[[name]], data[[name]]))) next
    stop_usage("`data` ", if (name %in% names(data)) "has other values of" else "lacks the column", " '", name, "', ", if (name %in% names(data)) "or in another order, than the fit; " else "which the fit reads; ",
               "omit `data` for the rows of the fit, or use newdata for predictions")
  }
}

#' @rdname broom-methods
#' @param model a fit of [silvafit()]
fortify.silvafit <- function(model, data = NULL, ...) {
  frame <- as.data.frame(augment.silvafit(model, data, ...))
  names(frame)[names(frame) == ".std.resid"] <- ".stdresid"
  frame
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
  formulas <- sub_model_formulas(object$arguments$parameters)
  if (missing(param) || is.null(param) || !param %in% names(formulas)) {
    stop_usage("`param` has to name a parameter with a sub-model: ", paste(names(formulas), collapse = ", "))
  }
  formulas[[param]]
}

#' @rdname emmeans-methods
recover_data.silvafit <- function(object, param, data = NULL, ...) {
  # A text is the message of an error there.
  if (is.null(object$arguments)) return("the fit was read from a file; emmeans() needs a fit that silvafit() has made in R")
  terms <- stats::delete.response(stats::terms(sub_model_of(object, param)))
  frame <- object$frame
  for (name in names(frame)) if (is.character(frame[[name]])) frame[[name]] <- factor(frame[[name]])
  emmeans::recover_data(object$call, terms, na.action = NULL, data = frame, ...)
}

#' @rdname emmeans-methods
emm_basis.silvafit <- function(object, trms, xlev, grid, param, ...) {
  frame <- stats::model.frame(trms, grid, na.action = stats::na.pass, xlev = xlev)
  # The codings of the fit, whatever the options and the factors of `grid` are.
  codings <- sapply(names(frame), function(name) object$codings[[paste0(factor_column_of(str2lang(name)), "")]], simplify = FALSE)
  matrix <- stats::model.matrix(trms, frame, contrasts.arg = Filter(Negate(is.null), codings))
  columns <- ifelse(colnames(matrix) == "(Intercept)", param, paste0(param, ":", colnames(matrix)))
  at <- match(columns, names(fixef(object)))
  if (anyNA(at)) stop_usage("the coefficients ", paste(columns[is.na(at)], collapse = ", "), " are not in the fit")
  df <- fixed_table(object)[, "DF"]
  # Coefficients that vary between groups are known from these only.
  for (term in random_terms_of(object)) {
    varying <- intersect(term$effects, names(df))
    df[varying] <- pmin(df[varying], nrow(term$modes) - 1)
  }
  df <- df[at]
  list(X = matrix, bhat = fixef(object)[at], nbasis = matrix(NA), V = vcov(object)[at, at, drop = FALSE],
       # The coefficients of the contrast, as of lme().
       dffun = function(k, dfargs) min(dfargs$df[abs(k) > 1e-8], na.rm = TRUE), dfargs = list(df = df), misc = list())
}
