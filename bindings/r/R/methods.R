# SPDX-License-Identifier: MIT
# Estimates, likelihoods and other generics of stats and nlme.

# The page of nlme's generics.
#' @export
nlme::fixef
#' @export
nlme::ranef
#' @export
nlme::VarCorr
#' @export
nlme::intervals

#' Estimates of a fit
#'
#' @param object,x a fit of [silvafit()]
#' @param ... arguments of nlme's methods in `ranef()` and `coef()`; other names stop
#' @return `fixef()`: named vector of the fixed effects. `ranef()`: data frame of the random effects (EBLUPs; in a
#'   nonlinear model the conditional modes) with a row for each group; with two groupings a list of two. `coef()`: the sum of both for each group;
#'   without random effects the coefficients. Both have the class, and take the arguments, of [nlme::ranef.lme()] and [nlme::coef.lme()]
#'   (`level`, `standard`, `augFrame`, ...). `vcov()`: covariance matrix of
#'   the fixed effects; rows of coefficients that were held are 0. `sigma()`: residual standard deviation.
#' @name estimates
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' fixef(fit)
#' head(ranef(fit))
#' VarCorr(fit)
#' sigma(fit)
NULL

#' @rdname estimates
fixef.silvafit <- strict(function(object, ...) {
  table <- fixed_table(object)
  stats::setNames(table[, "Value"], rownames(table))
})

#' @rdname estimates
#' @param se add the conditional standard errors of the effects as attribute `se`
#' @param condVar as in lme4: add the conditional covariance matrices of the effects as attribute `postVar`, an array with a
#'   matrix for each group
ranef.silvafit <- function(object, ..., se = FALSE, condVar = FALSE) {
  check_flag(se, "se")
  check_flag(condVar, "condVar")
  terms <- random_terms_of(object)
  if (length(terms) == 0) stop_usage("the fit has no random effects")
  if (attr(terms, "is_crossed")) {
    # nlme has no such fits.
    no_further(list(...))
    effects <- lapply(terms, function(term) with_uncertainty(term$modes, term, se, condVar))
    return(if (length(effects) == 1) effects[[1]] else effects)
  }
  # coef() of nlme gives arguments by position.
  call <- match.call(utils::getS3method("ranef", "lme", envir = asNamespace("nlme")), match.call())
  call[intersect(c("se", "condVar"), names(call))] <- NULL
  effects <- by_nlme("ranef", call, parent.frame(), also = c("se", "condVar"))
  if (!se && !condVar) return(effects)
  if (attr(effects, "standardized")) stop_usage("`se` and `condVar` are those of effects that are not standardized")
  if (is.data.frame(effects)) return(with_uncertainty(effects, terms[[attr(effects, "level")]], se, condVar))
  for (group in names(effects)) effects[[group]] <- with_uncertainty(effects[[group]], terms[[group]], se, condVar)
  effects
}

with_uncertainty <- function(effects, term, se, condVar) {
  if (se) attr(effects, "se") <- term$errors
  if (condVar) attr(effects, "postVar") <- term$covariances
  effects
}

#' @rdname estimates
coef.silvafit <- function(object, ...) {
  if (!has_random(object)) {
    no_further(list(...))
    return(fixef(object))
  }
  if (!is_crossed(object)) return(by_nlme("coef", match.call(), parent.frame()))
  # As lme4 has them: the fixed effects with those of one grouping.
  no_further(list(...))
  effects <- lapply(random_terms_of(object), function(term) {
    coefficients <- as.data.frame(as.list(fixef(object)), optional = TRUE)[rep(1, nrow(term$modes)), , drop = FALSE]
    rownames(coefficients) <- rownames(term$modes)
    coefficients[term$effects] <- coefficients[term$effects] + term$modes
    coefficients
  })
  if (length(effects) == 1) effects[[1]] else effects
}

#' @rdname estimates
vcov.silvafit <- strict(function(object, ...) {
  names <- names(fixef(object))
  values <- matrix_of(object$fit$fixed_covariance, names)
  values[is.na(values)] <- 0
  values
}, "complete")

#' @rdname estimates
sigma.silvafit <- strict(function(object, ...) number_or_na(object$fit$sigma))

number_or_na <- function(value) if (is.null(value)) NA_real_ else as.numeric(value)

#' @rdname estimates
#' @param sigma 1; multiples of the standard deviations are not available
#' @details `VarCorr()` has the covariance matrix of the random effects for each grouping, with the attributes
#'   `stddev` and `correlation`; it is printed as by nlme, and `as.data.frame()` makes a table of it.
VarCorr.silvafit <- strict(function(x, sigma = 1, ...) {
  if (!identical(as.numeric(sigma), 1)) stop_usage("`sigma` has to be 1; multiply the standard deviations instead")
  if (!has_random(x)) stop_usage("the fit has no random effects; sigma(fit) is the residual standard deviation")
  variance_components(x)
})

variance_components <- function(x) {
  result <- lapply(random_terms_of(x), function(term) {
    deviation <- stats::setNames(sqrt(diag(term$covariance)), term$effects)
    structure(term$covariance, stddev = deviation, correlation = term$covariance / outer(deviation, deviation), form = term$form)
  })
  structure(result, sc = sigma(x), class = "VarCorr.silvafit")
}

# Two indices are those of nlme's matrix, as in VarCorr(fit)[, "StdDev"].
`[.VarCorr.silvafit` <- function(x, i, j, ..., drop = TRUE) {
  if (nargs() - (!missing(drop)) < 3) return(unclass(x)[i])
  deviations <- c(unlist(lapply(unname(unclass(x)), attr, "stddev")), Residual = attr(x, "sc"))
  cbind(Variance = deviations^2, StdDev = deviations)[i, j, drop = drop]
}

# As nlme: a title of each grouping, which is a row if there are several.
print.VarCorr.silvafit <- strict(function(x, digits = getOption("digits"), ...) {
  is_joint <- vapply(x, function(one) ncol(one) > 1 && !attr(one, "form") %in% c("diagonal", "identity"), NA)
  width <- max(0, (vapply(x, ncol, 0L) - 1L)[is_joint])
  table <- cbind(apply(x[, , drop = FALSE], 2, format, digits = digits), matrix("", length(x[, 1]), width))
  dimnames(table) <- list(rownames(x[, , drop = FALSE]), c("Variance", "StdDev", "Corr", rep("", width))[seq_len(2 + width)])
  titles <- vapply(names(x), function(group) {
    class <- c(general = "pdLogChol", diagonal = "pdDiag", identity = "pdIdent", block = "pdBlocked", `compound-symmetry` = "pdCompSymm")[[attr(x[[group]], "form")]]
    paste0(group, " = ", class, "(list(", paste(vapply(rownames(x[[group]]), name_text, ""), "~ 1", collapse = ","), "))")
  }, "")
  blocks <- lapply(seq_along(x), function(i) {
    block <- table[sum(vapply(x[seq_len(i - 1)], ncol, 0L)) + seq_len(ncol(x[[i]])), , drop = FALSE]
    if (is_joint[i]) block[, 2 + seq_len(ncol(x[[i]]) - 1)] <- correlation_texts(attr(x[[i]], "correlation"))
    if (length(x) > 1) rbind(matrix(c(sub(".* = ", "", titles[i]), rep("", 1 + width)), 1, dimnames = list(paste(names(x)[i], "="))), block) else block
  })
  if (length(x) == 1) cat(titles, "\n")
  print(rbind(do.call(rbind, blocks), table[nrow(table), , drop = FALSE]), quote = FALSE)
  invisible(x)
})

# Below names of the columns in the first row.
correlation_texts <- function(correlation) {
  shown <- matrix("", nrow(correlation), ncol(correlation))
  below <- lower.tri(correlation)
  shown[below] <- format(round(correlation[below], 3))
  shown[1, ] <- abbreviate(colnames(correlation), 6)
  shown[, -ncol(shown)]
}

as.data.frame.VarCorr.silvafit <- strict(function(x, row.names = NULL, optional = FALSE, ...) {
  parts <- lapply(names(x), function(group) {
    covariance <- x[[group]]
    effects <- rownames(covariance)
    pairs <- which(lower.tri(covariance), arr.ind = TRUE)
    rbind(data.frame(grp = group, var1 = effects, var2 = NA_character_, vcov = diag(covariance), sdcor = attr(covariance, "stddev")),
          if (nrow(pairs) > 0) data.frame(grp = group, var1 = effects[pairs[, 2]], var2 = effects[pairs[, 1]],
                                          vcov = covariance[pairs], sdcor = attr(covariance, "correlation")[pairs]))
  })
  table <- do.call(rbind, c(parts, list(data.frame(grp = "Residual", var1 = NA_character_, var2 = NA_character_,
                                                   vcov = attr(x, "sc")^2, sdcor = attr(x, "sc")))))
  row.names(table) <- NULL
  table
})

#' Likelihood, degrees of freedom, data and formula of a fit
#'
#' The information criteria have the number of observations in `BIC`, as in nlme; for REML without the number of fixed effects.
#'
#' @inheritParams estimates
#' @param formula as in the generic
#' @param ... no further arguments; unknown names stop
#' @return What the generics of \pkg{stats} return.
#' @name likelihood
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' logLik(fit)
#' c(AIC(fit), BIC(fit), nobs(fit), df.residual(fit))
NULL

#' @rdname likelihood
logLik.silvafit <- strict(function(object, ...) {
  structure(number_or_na(object$fit$log_likelihood), df = object$fit$k, nobs = if (isTRUE(object$fit$reml)) df.residual(object) else object$fit$n,
            nall = object$fit$n, class = "logLik")
}, instead = c(REML = "the fit has the likelihood that it maximizes; refit with update(fit, reml = ...)"))

#' @rdname likelihood
nobs.silvafit <- strict(function(object, ...) as.integer(object$fit$n), "use.fallback")

#' @rdname likelihood
df.residual.silvafit <- strict(function(object, ...) nobs(object) - sum(!is.na(fixed_table(object)[, "Std.Error"])))

#' @rdname likelihood
#' @details `deviance()` is the sum of squares of ordinary least squares, as of [stats::nls()]; of other fits -2 times the log-likelihood.
deviance.silvafit <- strict(function(object, ...) {
  if (object$fit$method == "ols") sigma(object)^2 * df.residual(object) else -2 * number_or_na(object$fit$log_likelihood)
})

#' @rdname likelihood
#' @param fit a fit of [silvafit()]
#' @param scale 0, as in the generic
#' @param k penalty of a parameter: 2 for AIC
extractAIC.silvafit <- strict(function(fit, scale = 0, k = 2, ...) {
  if (!identical(as.numeric(scale), 0)) stop_usage("`scale` has to be 0: the likelihood has its own variance")
  c(fit$fit$k, -2 * number_or_na(fit$fit$log_likelihood) + k * fit$fit$k)
})

#' @rdname likelihood
formula.silvafit <- strict(function(x, ...) x$formula, "env")

#' @rdname likelihood
model.frame.silvafit <- strict(function(formula, ...) {
  needs_data(formula, "model.frame()")
  formula$frame
}, instead = c(data = "model.frame() has the data of the fit", subset = "model.frame() has the data of the fit"))

#' @rdname likelihood
#' @details `model.matrix()` stops: a nonlinear model has no model matrix.
model.matrix.silvafit <- function(object, ...) {
  stop_usage("a nonlinear model has no model matrix; model.frame() has the data, and stats::model.matrix() with the formula of a sub-model its columns")
}

#' @rdname likelihood
family.silvafit <- strict(function(object, ...) stats::gaussian())

#' @rdname likelihood
terms.silvafit <- strict(function(x, ...) {
  needs_data(x, "terms()")
  # The response and the columns that the mean reads; the formula itself is not linear.
  columns <- setdiff(names(x$frame), c(deparse1(x$formula[[2]]), grouping_names(x)))
  stats::terms(stats::reformulate(if (length(columns) > 0) vapply(columns, name_text, "") else "1", x$formula[[2]], env = environment(x$formula)))
})

response_values <- function(object) object$frame[[1]]

#' Fitted values and residuals
#'
#' @param object a fit of [silvafit()]
#' @param level `"conditional"`, with the random effects of the groups, or `"population"`, with random effects 0; the numbers and names
#'   of nlme are accepted: 0 or `"fixed"` is the population, the number of groupings or the name of the finest the conditional level. Several levels, as in
#'   `level = 0:1`, give a matrix
#' @param type `"response"`: y - fitted; `"pearson"`: divided by the residual standard deviation; `"normalized"`:
#'   these, made independent by the correlation of the residuals if the fit has one
#' @param asList as in nlme: a list with a vector for each group
#' @param ... no further arguments; unknown names stop
#' @return A vector with an element for each row that the fit uses; with `na.action = na.exclude`, for each row of the data.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' head(residuals(fit, type = "pearson"))
#' head(fitted(fit, level = "population"))
residuals.silvafit <- strict(function(object, level = "conditional", type = c("response", "pearson", "normalized"), asList = FALSE, ...) {
  needs_data(object, "residuals()")
  type <- match.arg(type)
  if (type == "normalized" && !is.null(object$fit$correlation)) {
    if (length(level) != 1 || level_word(object, level) != "conditional") stop_usage("normalized residuals of a fit with a correlation are conditional: omit `level`")
    normalized <- analysis_of_fit("residuals", object, data = object$frame)$tables$rows$normalized
    return(at_levels(object, level, asList, stats::naresid, "Normalized residuals", function(one) normalized))
  }
  scale <- if (type == "response") 1 else object$residual_sd
  label <- c(response = "Residuals", pearson = "Standardized residuals", normalized = "Normalized residuals")[[type]]
  at_levels(object, level, asList, stats::naresid, label, function(one) (response_values(object) - fitted_at(object, one)) / scale)
}, instead = c(scaled = "use type = \"pearson\"", newdata = "residuals are those of the data of the fit"))

#' @rdname residuals.silvafit
fitted.silvafit <- strict(function(object, level = "conditional", asList = FALSE, ...) {
  needs_data(object, "fitted()")
  at_levels(object, level, asList, stats::napredict, "Fitted values", function(one) fitted_at(object, one))
})

#' @rdname residuals.silvafit
#' @param model a fit of [silvafit()]
#' @details `rstandard()` has the Pearson residuals.
rstandard.silvafit <- strict(function(model, ...) residuals.silvafit(model, type = "pearson"))

#' @rdname residuals.silvafit
#' @details `hatvalues()` and `cooks.distance()` are those of least squares, linear around the estimates; with random effects or correlated residuals
#'   they stop, because a row then changes the predictions of others through the variances, too.
hatvalues.silvafit <- strict(function(model, ...) {
  if (has_random(model) || !is.null(model$fit$correlation)) {
    stop_usage("leverages and Cook's distances are those of independent residuals without random effects; for the influence of a group refit without it, ",
               "update(fit, subset = plot != 7), and for that of all groups use cross_validate()")
  }
  for_all_rows(model, leverages(model))
})

leverages <- function(model) (predict.silvafit(model, model$frame, level = "population", se.fit = TRUE)$se.fit / unbiased_deviation(model))^2

# Values of the rows of the fit; with na.exclude also NA for the others.
for_all_rows <- function(model, values) stats::naresid(model$na.action, stats::setNames(values, row.names(model$frame)))

# Residual standard deviations as standard errors have them, with N - p in the place of N.
unbiased_deviation <- function(model) {
  is_ml <- model$fit$method == "gnls" && !isTRUE(model$fit$reml)
  model$residual_sd * if (is_ml) sqrt(nobs(model) / df.residual(model)) else 1
}

#' @rdname residuals.silvafit
cooks.distance.silvafit <- function(model, ...) {
  hatvalues.silvafit(model, ...) # stops where there are none
  leverage <- leverages(model)
  residuals <- (response_values(model) - fitted_at(model, "population")) / unbiased_deviation(model)
  for_all_rows(model, residuals^2 * leverage / (1 - leverage)^2 / (nobs(model) - df.residual(model)))
}

# Values of each row at one level; at several a matrix, or as a list of groups, as in nlme.
#
# \param with_omitted  stats::naresid or stats::napredict
# \param values        function of a level
at_levels <- function(object, level, asList, with_omitted, label, values) {
  check_flag(asList, "asList")
  rows <- row.names(object$frame)
  if (length(level) > 1) {
    if (asList) stop_usage("`asList` is for one `level`")
    table <- vapply(level, function(one) as.vector(values(level_word(object, one))), numeric(length(rows)))
    dimnames(table) <- list(rows, if (is.numeric(level)) c("fixed", names(grouping_counts(object)))[level + 1] else level)
    return(with_omitted(object$na.action, table))
  }
  word <- level_word(object, level)
  one <- stats::setNames(as.vector(values(word)), rows)
  if (asList) {
    if (!has_random(object)) stop_usage("`asList` needs groups, but the fit has no random effects")
    groups <- as.character(group_frame(object)[[if (word == "conditional") length(grouping_counts(object)) else 1]])
    return(split(unname(one), ordered(groups, levels = unique(groups))))
  }
  one <- with_omitted(object$na.action, one)
  if (isTRUE(object$has_labels)) attr(one, "label") <- paste(c(label, if (label != "Standardized residuals" && label != "Normalized residuals") attr(object$data, "units")$y), collapse = " ")
  one
}

fitted_at <- function(object, level) {
  if (level == "outer") return(stats::predict(object, object$frame, level = 1, new_groups = "population"))
  if (!level %in% c("population", "conditional")) {
    stop_usage("`level` = \"", level, "\" is for predict(); fitted values are \"population\" or \"conditional\"")
  }
  object$fitted_values[[level]]
}

# nlme counts levels from 0, and its names are "fixed" and the groups.
level_word <- function(object, level) {
  if (length(level) != 1) stop_usage("`level` has to be one value")
  groupings <- length(grouping_counts(object))
  if (is.character(level)) {
    at <- match(level, c("fixed", names(grouping_counts(object))))
    if (is.na(at)) return(level)
    level <- at - 1
  }
  if (isTRUE(level == 0)) return("population")
  if (isTRUE(level == groupings)) return("conditional")
  if (isTRUE(level == 1 && groupings == 2) && !is_crossed(object)) return("outer")
  stop_usage("`level` has to be \"population\", \"conditional\", \"calibrated\", \"marginal\", or a number from 0 to ", groupings, if (is_crossed(object)) " without those between",
             if (is.numeric(level) && isTRUE(level > 0 && level < 1)) "; the coverage of intervals is `coverage`")
}

#' Convergence of a fit
#'
#' @param object a fit of [silvafit()]
#' @return A list of class `silvafit_convergence`: `converged`; `status`, a word such as `"converged"` or `"boundary"`; the
#'   `message`, a sentence that says whether and why the fit has converged or what to try; the `newton_decrement`, the
#'   squared distance to the optimum in standard errors; `iterations`; `boundary`, the estimates at the boundary of their
#'   range; and `optima`, all local maxima that were found.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' convergence(fit)
convergence <- function(object) {
  if (!inherits(object, "silvafit")) stop_usage("`object` has to be a fit of silvafit()")
  fit <- object$fit
  structure(list(converged = fit$converged, status = fit$status,
                 message = r_names(object, in_words_of_r(fit$verdict)),
                 newton_decrement = number_or_na(fit$evidence$gradient), iterations = fit$evidence$iterations,
                 boundary = r_names(object, as.character(unlist(fit$evidence$boundary))), optima = optima_of(object)),
            class = "silvafit_convergence")
}

optima_of <- function(object) {
  optima <- object$fit$optima
  if (length(optima) == 0) return(NULL)
  fixed <- records(lapply(optima, `[[`, "fixed"))
  table <- cbind(records(optima, c("origin", "log_likelihood")), fixed)
  stats::setNames(table, c("start", "logLik", r_names(object, names(fixed))))
}

print.silvafit_convergence <- strict(function(x, ...) {
  cat(if (x$converged) "Converged" else "Not converged", " (", x$status, ")\n", sep = "")
  cat(strwrap(x$message, exdent = 2), sep = "\n")
  cat("Newton decrement: ", format(x$newton_decrement, digits = 3), ", iterations: ", x$iterations, "\n", sep = "")
  if (NROW(x$optima) > 1) {
    cat("\nLocal maxima:\n")
    print(x$optima, row.names = FALSE)
  }
  invisible(x)
})

#' A fit as JSON
#'
#' `fit_json()` writes a fit in the format that the program silvafit, the C++ libraries and the Python package read; `read_fit()`
#' reads one, for example the output of `silvafit fit --json`.
#'
#' @param object a fit of [silvafit()]
#' @param file file to write or to read; without it `fit_json()` returns the text. `read_fit()` also takes a fit without data, such as those of
#'   [read_library()] and [impute()]
#' @return `fit_json()`: the text, invisibly if a file is written. `read_fit()`: an object of class `silvafit`. Without `data` estimates and
#'   predictions are available; with the data of the fit also residuals, plots, intervals and the bootstrap.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' file <- tempfile(fileext = ".json")
#' fit_json(fit, file)
#' again <- read_fit(file)
#' all.equal(fixef(again), fixef(fit))
#' head(residuals(read_fit(file, Loblolly)))
fit_json <- function(object, file = NULL) {
  if (!inherits(object, "silvafit")) stop_usage("`object` has to be a fit of silvafit()")
  json <- engine(.Call(C_text_of_fit, object$handle))
  if (is.null(file)) return(json)
  write_text(json, file)
  invisible(json)
}

write_text <- function(text, file) {
  connection <- tryCatch(suppressWarnings(file(file, "wb")), error = function(e) stop_classed("io", paste0(file, ": the file cannot be written")))
  on.exit(close(connection))
  writeLines(enc2utf8(text), connection, useBytes = TRUE)
}

#' @rdname fit_json
#' @param data the data that the model was fitted to; they are not in the file
read_fit <- function(file, data = NULL) {
  if (!inherits(file, "silvafit")) {
    if (!is.character(file) || length(file) != 1) stop_usage("`file` has to be the path of one file, or a fit")
    if (!file.exists(file) || dir.exists(file)) stop_input(file, ": there is no such file")
    json <- paste(readLines(file, encoding = "UTF-8", warn = FALSE), collapse = "\n")
    object <- stored_fit(engine(.Call(C_read_fit, json, file)), match.call())
  } else {
    object <- file
  }
  if (is.null(data)) object else with_data(object, data)
}

# A fit without data, from what the C++ functions return of it.
stored_fit <- function(read, call) {
  fit <- read$fit
  formula <- tryCatch(stats::as.formula(fit$formula, env = globalenv()), error = function(e) NULL)
  structure(list(call = call, formula = formula, texts = NULL, labels = labels_of_levels(fit), handle = read$handle, fit = fit, frame = NULL,
                 fitted_values = NULL, residual_sd = NULL), class = "silvafit")
}

# Names of the coefficients of levels as R has them: a:SexMale for a:(Sex == "Male").
labels_of_levels <- function(fit) {
  names <- names(fit$fixed)
  labels <- names
  # Those of other contrasts are sums of comparisons.
  is_level <- !grepl(":I(", names, fixed = TRUE)
  for (column in names(fit$levels)) {
    for (level in unlist(fit$levels[[column]])) labels[is_level] <- gsub(paste0("(", name_text(column), " == ", string_text(level), ")"), paste0(column, level), labels[is_level], fixed = TRUE)
  }
  stats::setNames(labels, names)[names != labels]
}

# A left side such as log(h), which a file has as a name, unless it is one of a column.
with_left_side <- function(formula, data) {
  left <- formula[[2]]
  if (!is.name(left) || as.character(left) %in% names(data)) return(formula)
  parsed <- tryCatch(str2lang(as.character(left)), error = function(e) left)
  functions <- setdiff(all.names(parsed), all.vars(parsed))
  if (all(functions %in% c(known_functions, names(operator_precedence), "("))) formula[[2]] <- parsed
  formula
}

with_data <- function(object, data) {
  given <- data
  data <- check_data(data)
  if (is.null(object$formula)) stop_usage("the formula of the fit, ", object$fit$formula, ", has no meaning in R")
  object$formula <- with_left_side(object$formula, data)
  response <- response_of(object$formula, data)
  data[[response$name]] <- if (is.null(response$values)) data[[response$name]] else response$values
  fit <- object$fit
  columns <- intersect(unique(c(response$name, names(fit$ranges), names(fit$levels), grouping_names(object), variance_columns(fit), correlation_names(fit$correlation$structure))),
                       names(data))
  frame <- data[columns]
  found <- analysis_of_fit("residuals", object, data = frame)
  result <- found$tables$rows
  object$frame <- rows_of(frame, found$rows)
  object$data <- given
  object$units <- units_of(given)
  object$rows <- found$rows
  object$fitted_values <- list(population = result$fitted_population, conditional = result$fitted_conditional)
  object$residual_sd <- result$residual_sd
  object
}

needs_data <- function(object, what) {
  if (is.null(object$frame)) stop_usage("the fit has no data, which ", what, " needs; read_fit(fit, data) adds them")
}
