# SPDX-License-Identifier: MIT
# Printed fits.

#' Print and summarize a fit
#'
#' @param x,object a fit of [silvafit()]
#' @param digits significant digits
#' @param ... no further arguments; unknown names stop
#' @return `summary()` returns a list of class `summary.silvafit`; its element `tTable` has the estimates, standard errors, degrees of
#'   freedom, t and p values of the fixed effects, as in nlme.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' fit
#' summary(fit)$tTable
print.silvafit <- strict(function(x, digits = max(3, getOption("digits") - 3), ...) {
  print_head(x)
  cat("  Log-likelihood:", format(signif(number_or_na(x$fit$log_likelihood), 7)), "\n")
  cat("\nFixed effects:\n")
  print(fixef(x), digits = digits)
  print_variances(x, digits)
  print_sizes(x)
  print_convergence(x)
  invisible(x)
})

# The covariance of the random effects, or sigma, the derived quantities, and what is known of the residuals.
print_variances <- function(x, digits) {
  if (has_random(x)) {
    cat("\nRandom effects:\n")
    print(VarCorr(x), digits = digits)
  } else {
    cat("\nResidual standard error:", format(signif(sigma(x), digits)), "\n")
  }
  print_variance(x)
}

print_head <- function(x) {
  cat(method_title(x), "\n", sep = "")
  cat("  Model: ", if (is.null(x$formula)) x$fit$formula else paste(deparse(x$formula), collapse = "\n    "), "\n", sep = "")
  if (is.call(x$call) && !is.null(x$call$data)) cat("  Data: ", deparse1(x$call$data), "\n", sep = "")
}

print_derived <- function(x) {
  if (length(x$fit$derived) == 0) return(invisible())
  cat("\nDerived quantities:\n")
  values <- data.matrix(records(x$fit$derived, c("estimate", "se", "df")))
  dimnames(values) <- list(names(x$fit$derived), c("Value", "Std.Error", "DF"))
  print(values, digits = 6)
}

print_variance <- function(x) {
  print_derived(x)
  correlation <- x$fit$correlation
  if (!is.null(correlation)) {
    values <- vapply(correlation$parameters, function(v) format(signif(as.numeric(v), 6)), "")
    cat("\nCorrelation of the residuals: ", correlation$structure, "\n  ", paste(names(values), "=", values, collapse = ", "), "\n", sep = "")
  }
  if (variance_is_constant(x)) return(invisible())
  cat("\nVariance function:\n")
  cat(r_names(x, variance_lines(x)), sep = "\n")
}

print_sizes <- function(x) {
  cat("\nNumber of observations: ", x$fit$n, sep = "")
  if (length(x$na.action) > 0) cat(" (", length(x$na.action), " omitted because of missing values)", sep = "")
  cat("\n")
  groups <- grouping_counts(x)
  if (length(groups) > 0) cat("Number of groups: ", paste0(groups, " (", names(groups), ")", collapse = ", "), "\n", sep = "")
}

print_convergence <- function(x) {
  state <- convergence(x)
  cat(strwrap(paste0(if (!state$converged) "NOT CONVERGED. ", state$message), exdent = 2), sep = "\n")
}

#' @rdname print.silvafit
summary.silvafit <- strict(function(object, ...) {
  table <- fixed_table(object)
  covariance <- vcov(object)
  deviation <- sqrt(diag(covariance))
  structure(list(object = object, tTable = table, coefficients = table, corFixed = covariance / outer(deviation, deviation), VarCorr = if (has_random(object)) variance_components(object),
                 AIC = number_or_na(object$fit$aic), BIC = stats::BIC(object), logLik = logLik(object), sigma = sigma(object),
                 residuals = if (!is.null(object$frame)) stats::quantile(residuals(object, type = "pearson"), na.rm = TRUE),
                 r2 = c(marginal = number_or_na(object$fit$r2_marginal), conditional = number_or_na(object$fit$r2_conditional))),
            class = "summary.silvafit")
})

coef.summary.silvafit <- strict(function(object, ...) object$tTable)

print.summary.silvafit <- strict(function(x, digits = max(3, getOption("digits") - 3), ...) {
  object <- x$object
  print_head(object)
  cat("\n")
  print(data.frame(AIC = x$AIC, BIC = x$BIC, logLik = c(x$logLik), row.names = ""), digits = digits + 3)
  print_variances(object, digits)
  cat("\nFixed effects:\n")
  print_fixed(x$tTable, digits)
  if (nrow(x$tTable) > 1 && all(is.finite(x$corFixed))) {
    cat(" Correlation:\n")
    print_correlation(x$corFixed)
  }
  if (!is.null(x$residuals)) {
    cat("\nStandardized residuals", if (has_random(object)) " within groups", ":\n", sep = "")
    print(stats::setNames(x$residuals, c("Min", "Q1", "Med", "Q3", "Max")), digits = digits)
  }
  if (is.finite(x$r2[["conditional"]])) {
    cat("\nR2 of the fixed effects: ", format(x$r2[["marginal"]], digits = 3), ", with random effects: ", format(x$r2[["conditional"]], digits = 3), "\n", sep = "")
  }
  print_sizes(object)
  print_convergence(object)
  invisible(x)
})

print_fixed <- function(table, digits) {
  # Coefficients of very different sizes have the same number of significant digits.
  significant <- function(values) vapply(values, function(value) format(signif(value, digits + 2), scientific = 6), "")
  shown <- data.frame(Value = significant(table[, "Value"]), Std.Error = significant(table[, "Std.Error"]),
                      DF = table[, "DF"], "t-value" = round(table[, "t-value"], 3),
                      "p-value" = format.pval(table[, "p-value"], digits = 3, eps = 1e-4, na.form = "NA"), check.names = FALSE,
                      row.names = rownames(table))
  print(shown)
}

print_correlation <- function(correlation) {
  shown <- format(round(correlation, 3))
  shown[!lower.tri(shown)] <- ""
  print(shown[-1, -ncol(shown), drop = FALSE], quote = FALSE)
}
