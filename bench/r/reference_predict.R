# SPDX-License-Identifier: MIT
# Predictions of nlme at levels 0, 1 and 2, and random effects of plots that a fit has not seen:
# Rscript reference_predict.R, from bench/r. Writes tests/reference/expected/nlme_predict.json.
suppressMessages(library(nlme))
source("json.R")

control <- nlmeControl(tolerance = 1e-8, pnlsTol = 1e-6, msTol = 1e-10, maxIter = 300, pnlsMaxIter = 50, msMaxIter = 500, minScale = 1e-8)
stands <- read_data("stands.csv")

# Random effects of a new plot by the definition of the alternation's first step: at the fit's fixed effects,
# covariance and variance parameters, the b that minimizes sum(w (y - f(beta + b))^2) / sigma^2 + b' Psi^-1 b, with the
# weights w taken at the fitted values of the b before, until nothing moves.
random_effects_of <- function(mean, beta, psi, sigma, power, y) {
  b <- rep(0, length(beta))
  for (round in 1:500) {
    weights <- abs(mean(beta + b))^(-2 * power)
    penalised <- function(b) sum(weights * (y - mean(beta + b))^2) / sigma^2 + drop(t(b) %*% solve(psi, b))
    # Gauss-Newton with a Jacobian by central differences.
    last <- b
    for (step in 1:100) {
      jacobian <- sapply(seq_along(b), function(j) {
        h <- 1e-5 * max(abs(beta[j]), 1e-3); up <- b; down <- b; up[j] <- up[j] + h; down[j] <- down[j] - h
        (mean(beta + up) - mean(beta + down)) / (2 * h)
      })
      jacobian <- matrix(jacobian, ncol = length(b))
      gradient <- t(jacobian) %*% (weights * (y - mean(beta + b))) / sigma^2 - solve(psi, b)
      change <- drop(solve(t(jacobian) %*% (weights * jacobian) / sigma^2 + solve(psi), gradient))
      length <- 1
      while (penalised(b + length * change) > penalised(b) * (1 + 1e-12) && length > 1e-8) length <- length / 2
      b <- b + length * change
      if (max(abs(change) / sqrt(diag(psi))) < 1e-13) break
    }
    if (max(abs(b - last) / sqrt(diag(psi))) < 1e-12) break
  }
  b
}

record <- function(id, formula, random, groups, fit, rows, extra) {
  new <- stands[rows, ]
  levels <- length(groups)
  predicted <- predict(fit, new, level = 0:levels)
  c(list(id = id, formula = formula, random = random, variance = "power", rows = I(rows),
         logLik = as.numeric(logLik(fit)),
         fixed = as.list(fixef(fit)), sigma = fit$sigma, power = unname(coef(fit$modelStruct$varStruct)),
         levels = lapply(0:levels, function(level) unname(predicted[[if (level == 0) "predict.fixed" else paste0("predict.", groups[level])]]))), extra)
}

rows <- seq(1, nrow(stands), by = 7)
one <- nlme(h ~ 1.3 + a * (1 - exp(-b * dbh / 10)), data = stands, fixed = a + b ~ 1, random = a + b ~ 1 | plot,
            start = c(a = 29, b = 0.47), weights = varPower(), control = control)
# New plots: those of stand S8, after a fit of the others.
old <- stands[stands$stand != "S8", ]
left <- nlme(h ~ 1.3 + a * (1 - exp(-b * dbh / 10)), data = old, fixed = a + b ~ 1, random = a + b ~ 1 | plot,
             start = c(a = 29, b = 0.47), weights = varPower(), control = control)
psi <- unname(as.matrix(left$modelStruct$reStruct[[1]])) * left$sigma^2
power <- unname(coef(left$modelStruct$varStruct))
measured <- list()
for (plot in unique(stands$plot[stands$stand == "S8"])) {
  trees <- head(which(stands$plot == plot), 4)
  mean <- function(phi) 1.3 + phi[1] * (1 - exp(-phi[2] * stands$dbh[trees] / 10))
  measured[[plot]] <- list(rows = I(trees), effects = I(random_effects_of(mean, unname(fixef(left)), psi, left$sigma, power, stands$h[trees])))
}
nested <- nlme(h ~ 1.3 + a * (1 - exp(-b * dbh / 10)), data = stands, fixed = a + b ~ 1, random = list(stand = a ~ 1, plot = a + b ~ 1),
               start = c(a = 29, b = 0.47), weights = varPower(), control = control)

writeLines(toJSON(list(
  meta = c(versions("nlme"), list(script = "bench/r/reference_predict.R",
    notes = "rows count from 1 in stands.csv; levels are the predictions at levels 0, 1, 2; new_plots are random effects by definition in R, at the estimates given with them")),
  predictions = list(
    record("plot_ab", "h ~ 1.3 + a*(1 - exp(-b*dbh/10))", "a + b | plot", "plot", one, rows, list()),
    record("stand_a_plot_ab", "h ~ 1.3 + a*(1 - exp(-b*dbh/10))", "a | stand; a + b | plot", c("stand", "plot"), nested, rows, list())),
  new_plots = list(fixed = as.list(fixef(left)), covariance = psi, sigma = left$sigma, power = power, plots = measured)),
  digits = 15, auto_unbox = TRUE, pretty = 1), file.path(expected_folder, "nlme_predict.json"))
