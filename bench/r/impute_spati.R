# SPDX-License-Identifier: MIT
# Heights of the spati data imputed by nlme as lmfor's ImputeHeights does it: Naslund's curve, a and b random by plot, the
# variance a power of the diameter. Run from this folder: Rscript impute_spati.R SPATI.csv
# Which heights are hidden: every third of the measured trees, and all of each fifth plot.
library(nlme)
source("json.R")
source("definition.R")
source("nlme_record.R")

spati <- read.csv(commandArgs(trailingOnly = TRUE)[1])
measured <- which(!is.na(spati$h))
hidden <- measured[seq_along(measured) %% 3 == 0 | spati$plot[measured] %% 5 == 0]
spati$known <- spati$h
spati$known[hidden] <- NA
trees <- spati[!is.na(spati$known), ]
trees$plot <- factor(trees$plot, levels = unique(trees$plot))
# The parameters of silvafit's catalogue: dbh^2/(a dbh + b)^2. A deriv() function gives nlme exact slopes.
naslund <- deriv(~ 1.3 + d^2 / (a * d + b)^2, c("a", "b"), function(a, b, d) {})
pooled <- nls(known ~ naslund(a, b, d), data = trees, start = c(a = 0.2, b = 1))
attempt <- function(start, random, ...) {
  nlme(known ~ naslund(a, b, d), fixed = a + b ~ 1, random = a + b ~ 1 | plot, data = trees, start = list(fixed = start, random = random),
       weights = varPower(form = ~ d), control = nlmeControl(maxIter = 500, ...))
}
# nlme's controls are made tighter step by step, since its step halving fails far from the solution.
fit <- attempt(coef(pooled), NULL, tolerance = 1e-4, pnlsTol = 1e-2, msTol = 1e-6)
for (digits in 5:9) {
  tighter <- tryCatch(attempt(fixef(fit), as.matrix(ranef(fit)), tolerance = 10^-digits, pnlsTol = 10^(2 - digits), msTol = 1e-11),
                      error = function(e) { cat("tolerance 1e-", digits, ": ", conditionMessage(e), "\n", sep = ""); NULL })
  if (!is.null(tighter)) fit <- tighter
}

# nlme's tolerance leaves some 1e-6 m: from its result, its two steps alternate until nothing moves in double precision.
smooth <- deriv(~ 1.3 + d^2 / (a * d + b)^2, c("a", "b"), c("a", "b", "d"), hessian = TRUE)
problem <- make_problem(trees, "known", smooth, c("a", "b"), "d", list(list(group = "plot", effects = c("a", "b"), form = 2)),
                        of_column(power_of, "d"))
read <- function(theta) list(factors = list(factor_of(2, 2, theta[1:3])), sigma = exp(theta[4]), par = theta[5])
psi <- pdMatrix(fit$modelStruct$reStruct)[[1]] * fit$sigma^2
effects <- lapply(problem$pieces, function(piece) as.numeric(unlist(ranef(fit)[piece$label, ])))
theta <- c(factor_parameters(2, psi), log(fit$sigma), as.numeric(coef(fit$modelStruct$varStruct, unconstrained = FALSE)))
end <- lindstrom_bates_fixed_point(problem, fixef(fit), effects, as.numeric(theta), read, rounds = 400)
cat("rounds ", end$rounds, ", last relative step ", end$step, ", last move ", end$moved, " standard errors\n", sep = "")
stopifnot(end$positive, end$step < 1e-9)

value <- function(coefficients, rows) 1.3 + spati$d[rows]^2 / (coefficients[, 1] * spati$d[rows] + coefficients[, 2])^2
label <- as.character(spati$plot[hidden])
predicted <- function(population, effects) {
  coefficients <- matrix(population, length(hidden), 2, byrow = TRUE)
  is_known <- label %in% rownames(effects)
  coefficients[is_known, ] <- coefficients[is_known, ] + effects[label[is_known], ]
  value(coefficients, hidden)
}
by_nlme <- predicted(fixef(fit), as.matrix(ranef(fit)))
is_known <- label %in% rownames(ranef(fit))
level_1 <- as.numeric(predict(fit, newdata = data.frame(d = spati$d[hidden], plot = factor(label)), level = 1))
stopifnot(max(abs(level_1[is_known] - by_nlme[is_known])) < 1e-10)
rested <- do.call(rbind, end$effects)
rownames(rested) <- vapply(problem$pieces, function(piece) piece$label, "")
by_fixed_point <- predicted(end$beta, rested)
cat("nlme's heights are within", max(abs(by_nlme - by_fixed_point)), "m of the fixed point's\n")

write_expected("impute_spati.json", list(script = "impute_spati.R", versions = versions("nlme"), data = "spati.csv of R package lmfor 1.7"),
               list(log_likelihood_nlme = as.numeric(logLik(fit)), log_likelihood = end$log_likelihood, n = nrow(trees), row = hidden,
                    plot = spati$plot[hidden], level = ifelse(is_known, "plot", "population"), h_nlme = by_nlme, h = by_fixed_point))
