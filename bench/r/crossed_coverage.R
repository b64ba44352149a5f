# SPDX-License-Identifier: MIT
# Coverage of the 95 % Wald intervals of fixed effects in models with crossed random effects: 200
# simulated tables each of a height curve by plot and year, Michaelis-Menten by person and day, and
# a logistic curve by site and species.
#
#   R_LIBS=build/r-library Rscript bench/r/crossed_coverage.R [SETS] [METHOD ...] > coverage.csv
library(silvafit)
arguments <- commandArgs(trailingOnly = TRUE)
sets <- if (length(arguments) > 0) as.integer(arguments[[1]]) else 200L
methods <- if (length(arguments) > 1) arguments[-1] else c("lb", "laplace")

# Observations of all pairs of groups, `each` of them, with an effect of each grouping.
pairs <- function(first, second, each, sd_first, sd_second) {
  frame <- expand.grid(copy = seq_len(each), first = seq_len(first), second = seq_len(second))
  frame$effect_first <- rnorm(first, sd = sd_first)[frame$first]
  frame$effect_second <- rnorm(second, sd = sd_second)[frame$second]
  frame
}

cases <- list(
  heights = list(
    formula = y ~ 1.3 + a * (1 - exp(-b * x)), random = "a | first + second", truth = c(a = 24, b = 0.06),
    draw = function() {
      frame <- pairs(40, 20, 2, 2.5, 1)
      frame$x <- runif(nrow(frame), 6, 45)
      frame$y <- 1.3 + (24 + frame$effect_first + frame$effect_second) * (1 - exp(-0.06 * frame$x)) + rnorm(nrow(frame), sd = 1.2)
      frame
    }),
  enzymes = list(
    formula = y ~ V * x / (K + x), random = "(V | first) + (K | second)", truth = c(V = 200, K = 0.6),
    draw = function() {
      frame <- pairs(30, 25, 2, 20, 0.1)
      frame$x <- sample(c(0.1, 0.3, 0.6, 1.2, 2.4), nrow(frame), replace = TRUE)
      frame$y <- (200 + frame$effect_first) * frame$x / (0.6 + frame$effect_second + frame$x) + rnorm(nrow(frame), sd = 8)
      frame
    }),
  logistic = list(
    formula = y ~ A / (1 + exp((m - x) / s)), random = "(A | first) + (m | second)", truth = c(A = 30, m = 20, s = 6),
    draw = function() {
      frame <- pairs(30, 25, 2, 3, 2)
      frame$x <- runif(nrow(frame), 1, 45)
      frame$y <- (30 + frame$effect_first) / (1 + exp((20 + frame$effect_second - frame$x) / 6)) + rnorm(nrow(frame), sd = 1)
      frame
    }))

cat("case,method,coefficient,sets,converged,covered,share,mean_estimate,truth\n")
for (name in names(cases)) {
  case <- cases[[name]]
  for (method in methods) {
    found <- lapply(seq_len(sets), function(set) {
      set.seed(set)
      fit <- suppressWarnings(silvafit(case$formula, case$draw(), random = case$random, method = method))
      if (!convergence(fit)$converged) return(NULL)
      limits <- confint(fit, parm = names(case$truth))
      list(covers = limits[, 1] <= case$truth & case$truth <= limits[, 2], estimate = fixef(fit)[names(case$truth)])
    })
    found <- Filter(Negate(is.null), found)
    covers <- do.call(rbind, lapply(found, `[[`, "covers"))
    means <- colMeans(do.call(rbind, lapply(found, `[[`, "estimate")))
    for (coefficient in names(case$truth)) {
      covered <- sum(covers[, coefficient])
      cat(name, method, coefficient, sets, length(found), covered, round(covered / length(found), 3), signif(means[[coefficient]], 5), case$truth[[coefficient]], sep = ",")
      cat("\n")
    }
  }
}
