# SPDX-License-Identifier: MIT
# Plateaus whose optimum is at an observation, or one of several between them: the tables of libfit/src/fit_model/kinked_fit_test.cpp,
# and the maxima of the profile over m of lm() and lmer(REML = FALSE), from all values of x and a grid between them.
#   Rscript reference_kinks.R
# Debian: r-cran-lme4.
suppressMessages(library(lme4))
set.seed(7)
tables <- lapply(1:20, function(k) {
  n <- 40
  x <- round(runif(n, 0, 20), if (k %% 2) 0 else 2)
  y <- 3 + 0.5 * pmin(x, 11) + rnorm(n, 0, 0.5)
  g <- rep(1:8, 5)
  data.frame(x = x, y = round(y, 3), g = g, y2 = round(y + rep(rnorm(8, 0, 0.6), 5), 3))
})
precise <- lmerControl(optimizer = "bobyqa", optCtrl = list(rhoend = 1e-10))
profile_of <- list(
  lm = function(table) function(m) as.numeric(logLik(lm(y ~ pmin(x, m), table))),
  lmer = function(table) function(m) {
    table$z <- pmin(table$x, m)
    as.numeric(logLik(suppressMessages(suppressWarnings(lmer(y2 ~ z + (1 | g), table, REML = FALSE, control = precise)))))
  })
report <- function(number, method) {
  table <- tables[[number]]
  profile <- profile_of[[method]](table)
  at <- sort(unique(c(table$x[table$x > 9 & table$x < 13], seq(9, 13, 0.02))))
  values <- vapply(at, profile, 0)
  best <- which.max(values)
  between <- optimize(profile, at[best] + c(-0.02, 0.02), maximum = TRUE, tol = 1e-10)
  is_between <- between$objective > values[best]
  cat(sprintf("table %d, %s: m = %.8f, log-likelihood %.9f\n", number, method, if (is_between) between$maximum else at[best], max(between$objective, values[best])))
  cat(" x:", table$x, "\n y:", if (method == "lm") table$y else table$y2, "\n")
}
report(1, "lm")
report(2, "lm")
report(5, "lmer")
report(10, "lmer")
