# SPDX-License-Identifier: MIT
# Fits with other arguments or fewer terms.

#' Refit with other arguments
#'
#' The values of the other arguments are those of the fit, so that fits made in functions or loops can be updated. The data are those of
#' the fit, too; if their name now has a data frame with further columns, these can be used.
#'
#' @param object a fit of [silvafit()]
#' @param formula. new formula; a `.` on a side stands for that side of the old formula
#' @param ... arguments of [silvafit()] to change; `NULL` removes one
#' @param evaluate fit, or return the call
#' @return The new fit, or its call.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' update(fit, variance = "power")
update.silvafit <- function(object, formula., ..., evaluate = TRUE) {
  needs_call(object, "update()")
  check_flag(evaluate, "evaluate")
  changes <- as.list(substitute(list(...)))[-1]
  check_changes(names(changes), length(changes))
  call <- object$call
  values <- object$arguments
  if (!missing(formula.)) values$formula <- call$formula <- updated_formula(as_formula(formula., "formula."), object$formula)
  for (i in seq_along(changes)) {
    name <- own_name(names(changes)[i])
    # Of arguments that set the same, the new one counts.
    same <- switch(name, method = c("method", "reml"), nAGQ = c("method", "agq_points"), control = c("max_iterations", "trace"), name)
    call[intersect(same, names(call))] <- NULL
    values[same] <- NULL
    if (!is.null(changes[[i]])) call[[name]] <- changes[[i]]
    if (name != "subset") values[name] <- list(...elt(i))
  }
  if (!evaluate) return(call)
  if (!"data" %in% names(values)) values["data"] <- list(data_for_update(object, parent.frame()))
  values["subset"] <- list(call$subset)
  fit <- do.call(silvafit, values, envir = parent.frame())
  # The call of do.call() has values in the place of expressions.
  given <- Filter(Negate(is.null), as.list(fit$call)[-1])
  shown <- intersect(names(given), names(call))
  given[shown] <- as.list(call)[shown]
  fit$call <- as.call(c(call[[1]], given))
  fit
}

needs_call <- function(object, what) {
  if (is.null(object$arguments)) stop_usage("the fit was read from a file; ", what, " needs a fit that silvafit() has made in R")
}

own_name <- function(name) if (name %in% names(renamed_arguments)) renamed_arguments[[name]] else name

# A `.` on a side of the new formula is that side of the old one.
updated_formula <- function(formula, old) {
  for (side in 2:3) {
    whole <- if (is.call(old[[side]])) call("(", old[[side]]) else old[[side]]
    formula[[side]] <- strip_parentheses(do.call(substitute, list(formula[[side]], list(. = whole))))
    # Bars are terms of the whole sum.
    if (any(vapply(summands(formula[[side]]), is_bar, NA))) formula[[side]] <- Reduce(function(a, b) call("+", a, b), lapply(summands(formula[[side]]), bar_in_parentheses))
  }
  formula
}

bar_in_parentheses <- function(term) if (is_bar(term)) call("(", term) else term

# The data of the fit, or what has their name now if it only has further columns.
data_for_update <- function(object, frame) {
  now <- tryCatch(eval(object$call$data, frame), error = function(e) NULL)
  if (!is.data.frame(now) || identical(now, object$data)) return(object$data)
  columns <- names(object$data)
  if (all(columns %in% names(now)) && identical(as.list(now)[columns], as.list(object$data))) return(now)
  if (all(names(object$frame) %in% names(now))) {
    tell(paste0(deparse1(object$call$data), " is no longer the data of the fit; update() uses the data of the fit. Give `data` to use others"))
  }
  object$data
}

check_changes <- function(names, count) {
  available <- c(setdiff(names(formals(silvafit)), "..."), names(renamed_arguments), "control", "nAGQ")
  unknown <- setdiff(if (is.null(names)) rep("", count) else names, available)
  if (length(unknown) == 0) return(invisible())
  stop_unknown(unknown[1], available, "silvafit() has no argument")
}

#' Drop terms of the sub-models one at a time
#'
#' Refits the model without each term of the sub-models of its parameters that no other term contains.
#'
#' @param object a fit of [silvafit()] by maximum likelihood
#' @param scope terms to drop, such as `"a:species"`; all that can be dropped by default
#' @param scale 0, as in the generic
#' @param test `"Chisq"`, likelihood-ratio tests, or `"none"`
#' @param k penalty of a parameter in `AIC`
#' @param trace show the fits
#' @param ... no further arguments; unknown names stop
#' @return Data frame of class `anova` with a row for each term.
#' @examples
#' \donttest{
#' fit <- silvafit(weight ~ a / (1 + exp((m - Time) / s)), data = nlme::Soybean,
#'                 parameters = list(a ~ Variety, m ~ Year), random = a ~ 1 | Plot)
#' drop1(fit)
#' }
drop1.silvafit <- strict(function(object, scope = NULL, scale = 0, test = c("Chisq", "none"), k = 2, trace = FALSE, ...) {
  test <- match.arg(test)
  needs_call(object, "drop1()")
  if (isTRUE(object$fit$reml)) stop_usage("fits by REML with different fixed effects cannot be compared; use drop1(update(fit, method = \"ML\"))")
  formulas <- sub_model_formulas(object$arguments$parameters)
  droppable <- unlist(lapply(names(formulas), function(parameter) {
    terms <- stats::drop.scope(formulas[[parameter]])
    stats::setNames(rep(parameter, length(terms)), terms)
  }))
  names <- paste0(droppable, ":", names(droppable))
  if (length(droppable) == 0) stop_usage("no parameter has a sub-model with a term to drop")
  if (!is.null(scope) && length(setdiff(scope, names)) > 0) {
    stop_usage("`scope`: unknown term '", setdiff(scope, names)[1], "'; available: ", paste(names, collapse = ", "), "; step() does not know sub-models: drop terms by update(fit, parameters = ...)")
  }
  chosen <- if (is.null(scope)) seq_along(names) else match(scope, names)
  smaller <- lapply(chosen, function(i) {
    if (trace) cat("without", names[i], "\n")
    formulas[[droppable[i]]] <- stats::update(formulas[[droppable[i]]], paste("~ . -", names(droppable)[i]))
    # Functions of the coefficients may need those of the term.
    do.call(update.silvafit, list(object, parameters = formulas, derive = NULL, means = NULL))
  })
  all <- c(list(object), smaller)
  likelihood <- vapply(all, function(fit) as.numeric(logLik(fit)), 0)
  count <- vapply(all, function(fit) as.integer(fit$fit$k), 0L)
  table <- data.frame(Df = c(NA, count[1] - count[-1]), AIC = -2 * likelihood + k * count, row.names = c("<none>", names[chosen]))
  if (test == "Chisq") {
    table$LRT <- c(NA, 2 * (likelihood[1] - likelihood[-1]))
    table$`Pr(>Chi)` <- stats::pchisq(table$LRT, table$Df, lower.tail = FALSE)
  }
  structure(table, heading = c("Single term deletions", "\nModel:", deparse1(object$formula), ""), class = c("anova", "data.frame"))
})

#' @rdname drop1.silvafit
#' @details `add1()` stops: a term belongs to a parameter, which a formula of the whole model does not name.
add1.silvafit <- function(object, scope, ...) {
  stop_usage("add1() does not know to which parameter a term belongs; compare with fits of larger sub-models, such as anova(fit, update(fit, parameters = a ~ species))")
}
