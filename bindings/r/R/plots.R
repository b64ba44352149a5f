# SPDX-License-Identifier: MIT
# Diagnostic plots.

#' Diagnostic plots
#'
#' `plot()` shows standardized residuals against fitted values; `qqnorm()` shows normal quantiles of the residuals or of the random effects.
#'
#' @param x,y,object a fit of [silvafit()]
#' @param form formula of [nlme::plot.lme()] or [nlme::qqnorm.lme()], such as `resid(., type = "p") ~ fitted(.) | Seed` or `~ ranef(.)`; with it, or with the arguments `id`,
#'   `idLabels`, `abline` or `grid`, the plots of nlme are drawn
#' @param level level of the fitted values, as in [fitted.silvafit()]
#' @param type type of the residuals, as in [residuals.silvafit()]
#' @param of `"residuals"` or `"ranef"`
#' @param ... graphical parameters, with `form` arguments of nlme and lattice
#' @return `plot()` and `qqnorm()` return their object invisibly, with `form` a plot of lattice; `autoplot()`, if \pkg{ggplot2} is loaded, a plot.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' plot(fit)
#' qqnorm(fit)
plot.silvafit <- function(x, form = NULL, level = "conditional", type = "pearson", ...) {
  if (is_for_nlme(form, list(...))) return(by_nlme("plot", match.call(), parent.frame(), also = lattice_names()))
  no_further(list(...), graphical_names())
  needs_data(x, "plot()")
  residuals <- stats::na.omit(residuals(x, level = level, type = type))
  fitted <- stats::na.omit(fitted(x, level = level))
  draw <- function(xlab = "Fitted values", ylab = if (type == "response") "Residuals" else "Standardized residuals", ...) {
    graphics::plot(as.vector(fitted), as.vector(residuals), xlab = xlab, ylab = ylab, ...)
  }
  draw(...)
  graphics::abline(h = 0, col = "grey50")
  invisible(x)
}

#' @rdname plot.silvafit
qqnorm.silvafit <- function(y, form = NULL, of = c("residuals", "ranef"), ...) {
  if (is_for_nlme(form, list(...))) return(by_nlme("qqnorm", match.call(), parent.frame(), also = lattice_names()))
  no_further(list(...), graphical_names())
  of <- match.arg(of)
  needs_data(y, "qqnorm()")
  draw <- function(values, main, ...) {
    stats::qqnorm(values, main = main, ...)
    stats::qqline(values, col = "grey50")
  }
  if (of == "residuals") {
    draw(as.vector(stats::na.omit(residuals(y, type = "normalized"))), main = "Standardized residuals", ...)
  } else {
    terms <- random_terms_of(y)
    if (length(terms) == 0) stop_usage("the fit has no random effects")
    count <- sum(vapply(terms, function(term) length(term$effects), 0L))
    before <- graphics::par(mfrow = grDevices::n2mfrow(count))
    on.exit(graphics::par(before))
    for (term in terms) for (effect in term$effects) draw(term$modes[[effect]], main = paste0(effect, " (", term$group, ")"), ...)
  }
  invisible(y)
}

# Whether a plot of nlme is meant: with a formula, or with arguments that only nlme has.
is_for_nlme <- function(form, given) {
  if (is.character(form)) stop_usage("`form` has to be a formula, as in resid(., type = \"p\") ~ fitted(.) | plot")
  !is.null(form) || any(names(given) %in% c("id", "idLabels", "idResType", "abline", "grid"))
}

#' @rdname plot.silvafit
autoplot.silvafit <- function(object, level = "conditional", type = "pearson", ...) {
  needs_data(object, "autoplot()")
  data <- data.frame(fitted = fitted_at(object, level), residual = as.vector(stats::na.omit(residuals(object, level = level, type = type))))
  ggplot2::ggplot(data, ggplot2::aes(x = .data[["fitted"]], y = .data[["residual"]])) +
    ggplot2::geom_hline(yintercept = 0, colour = "grey50") + ggplot2::geom_point(...) +
    ggplot2::labs(x = "Fitted values", y = if (type == "response") "Residuals" else "Standardized residuals")
}
utils::globalVariables(".data")
