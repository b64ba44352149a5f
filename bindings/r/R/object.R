# SPDX-License-Identifier: MIT
# The object of a fit: what R keeps of it.

new_fit <- function(result, model, call, options, na.action) {
  is_complete <- length(result$rows) == nrow(model$frame)
  omitted <- if (!is_complete) setdiff(seq_len(nrow(model$frame)), result$rows)
  structure(
    list(call = call, formula = model$formula, texts = model$texts, labels = model$labels,
         codings = model$codings, handle = result$fits[[1]]$handle, fit = in_order_of_levels(result$fits[[1]]$fit, model$frame),
         frame = rows_of(model$frame, if (!is_complete) result$rows),
         na.action = if (length(omitted) > 0) {
           structure(omitted, names = row.names(model$frame)[omitted], class = na.action)
         },
         fitted_values = result$tables$rows[c("population", "conditional")],
         # For refits to other data.
         options = options[c("hold", "bounds", "maximum_iterations")],
         residual_sd = result$tables$rows$residual_sd, cpu_seconds = result$json$cpu_seconds),
    class = "silvafit")
}

# Elements that fits of other packages have, and the functions that have them here.
generics_of_elements <- c(sigma = "sigma", coef = "coef", coefficients = "coef", logLik = "logLik", loglik = "logLik", resid = "residuals", residuals = "residuals",
                          fitted = "fitted", fitted.values = "fitted", vcov = "vcov", varcov = "vcov", AIC = "AIC", BIC = "BIC", df.residual = "df.residual",
                          deviance = "deviance", fixef = "fixef", ranef = "ranef", se = "summary", predictions = "predict")

# Elements are internal, and names are not completed.
`$.silvafit` <- function(x, name) {
  value <- .subset2(x, name)
  generic <- generics_of_elements[name]
  if (is.null(value) && !is.na(generic)) stop_usage("a fit has no element '", name, "'; use ", generic, "(fit)")
  value
}

# Groups of a factor have the order of its levels, as in nlme.
in_order_of_levels <- function(fit, frame) {
  if (length(fit$random) == 0) return(fit)
  column <- frame[[fit$random[[1]]$group]]
  if (!is.factor(column)) return(fit)
  for (kind in intersect(c("eblup", "eblup_se", "eblup_covariance"), names(fit$random[[1]]))) {
    old <- fit$random[[1]][[kind]]
    if (length(old$groups) == 0) next
    order <- order(match(old$groups, levels(column)))
    fit$random[[1]][[kind]] <- list(groups = old$groups[order], values = as.vector(matrix(old$values, ncol = length(order))[, order]))
  }
  fit
}

report_convergence <- function(object, method = NULL) {
  state <- convergence(object)
  if (!state$converged) {
    warn(paste0("the fit has not converged: ", state$message), "silvafit_convergence_warning", status = state$status)
  } else if (state$status == "boundary") {
    tell(state$message, "silvafit_boundary_message")
  } else if (has_doubts(object) || (object$fit$method == "focei" && !identical(method, "focei"))) {
    tell(state$message)
  }
  invisible(object)
}

# Whether the message begins with names that may be misspelt columns, with an unsuitable response, or names values that were changed.
has_doubts <- function(object) {
  kinds <- vapply(object$fit$evidence$findings, `[[`, "", "kind")
  any(kinds %in% c("taken_as_parameter", "response_values", "missing_code", "floored_values"))
}

# Names of coefficients and other texts of the C++ libraries with the names that R uses.
r_names <- function(object, texts) {
  labels <- object$labels[order(-nchar(names(object$labels)))]
  # An expression in I(...) is stored without it. A label may contain another name, so that numbers stand for labels until all are found.
  bare <- sub("^([^:]+):I\\((.*)\\)$", "\\1:(\\2)", names(labels))
  for (i in seq_along(labels)) {
    for (name in unique(c(names(labels)[i], bare[i]))) texts <- gsub(paste0("\\Q", name, "\\E(?![[:alnum:]_.])"), paste0("\001", i, "\002"), texts, perl = TRUE)
  }
  for (i in seq_along(labels)) texts <- gsub(paste0("\001", i, "\002"), labels[[i]], texts, fixed = TRUE)
  texts
}

# Objects of JSON as a data frame; a value that one lacks is NA.
records <- function(objects, keys = unique(unlist(lapply(objects, names)))) {
  column <- function(key) unlist(lapply(objects, function(one) if (is.null(one[[key]])) NA else one[[key]]), use.names = FALSE)
  as.data.frame(sapply(keys, column, simplify = FALSE), optional = TRUE)
}

fixed_table <- function(object) {
  table <- data.matrix(records(object$fit$fixed, c("estimate", "se", "df", "t", "p")))
  dimnames(table) <- list(r_names(object, names(object$fit$fixed)), c("Value", "Std.Error", "DF", "t-value", "p-value"))
  table
}

# The only function that reads random effects of a fit.
# \return  a list with an entry for each grouping, the coarser first: group (column), effects (names),
#          form, covariance, modes and their standard errors (a row for each group)
random_terms_of <- function(object) {
  if (length(object$fit$random) == 0) return(list())
  result <- lapply(object$fit$random, function(term) {
    effects <- r_names(object, term$effects)
    list(group = paste(c(unlist(term$within), term$group), collapse = ":"), effects = effects, form = term$form,
         covariance = matrix_of(term$covariance, effects),
         modes = frame_of(term$eblup, effects), errors = if (!is.null(term$eblup_se)) frame_of(term$eblup_se, effects),
         covariances = if (!is.null(term$eblup_covariance)) array_of(term$eblup_covariance, effects))
  })
  names(result) <- vapply(result, `[[`, "", "group")
  structure(result, is_crossed = is_crossed(object))
}

# Whether groupings are crossed or have more than two levels.
is_crossed <- function(object) {
  terms <- object$fit$random
  length(terms) > 0 && "within" %in% names(terms[[1]])
}

# The columns of all groupings.
grouping_names <- function(object) {
  if (!is_crossed(object)) return(names(grouping_counts(object)))
  unique(unlist(lapply(object$fit$random, function(term) c(unlist(term$within), term$group))))
}

matrix_of <- function(rows, names) {
  values <- if (is.list(rows)) do.call(rbind, lapply(rows, as.numeric)) else matrix(as.numeric(rows), length(names))
  dimnames(values) <- list(names, names)
  values
}

# The values of all groups, one after the other.
frame_of <- function(by_group, effects) {
  frame <- as.data.frame(matrix(as.numeric(by_group$values), ncol = length(effects), byrow = TRUE), row.names = as.character(by_group$groups))
  names(frame) <- effects
  frame
}

# The symmetric matrices of all groups, one after the other.
array_of <- function(by_group, effects) {
  size <- length(effects)
  array(as.numeric(by_group$values), c(size, size, length(by_group$groups)), list(effects, effects, as.character(by_group$groups)))
}

has_random <- function(object) length(object$fit$groups) > 0

method_title <- function(object) {
  fit <- object$fit
  by <- c(laplace = "Laplace", focei = "FOCEI", foce = "FOCE", agq = paste(fit$agq_points, "quadrature points"))
  likelihood <- if (fit$method %in% names(by)) "maximum marginal likelihood" else if (isTRUE(fit$reml)) "REML" else "maximum likelihood"
  if (fit$method == "ols") return("Nonlinear regression by ordinary least squares")
  if (fit$method == "gnls") return(paste("Generalized nonlinear least squares fit by", likelihood))
  paste0("Nonlinear mixed-effects model fit by ", likelihood, " (", if (fit$method %in% names(by)) by[[fit$method]] else "Lindstrom and Bates, as nlme", ")")
}

variance_is_constant <- function(object) identical(object$fit$variance$`function`, "none")

# One line for each factor of the variance function.
variance_lines <- function(object) {
  variance <- object$fit$variance
  factors <- if (is.null(variance$factors)) list(variance) else variance$factors
  vapply(factors, function(one) {
    of <- if (one$`function` == "stratum") paste("of", one$strata) else paste(c("of", one$of, if (!is.null(one$strata)) c("for each stratum of", one$strata)), collapse = " ")
    values <- unlist(if (one$`function` == "stratum") one$ratio else one[intersect(c("delta", "constant"), names(one))])
    paste0(" ", one$`function`, " ", of, if (length(values) > 0) paste0("\n  ", paste(names(values), "=", signif(as.numeric(values), 6), collapse = ", ")))
  }, "")
}

grouping_counts <- function(object) unlist(object$fit$groups)
