# SPDX-License-Identifier: MIT
# Residuals of nlme at both levels on the shipped data, and R2 of linear mixed models by the formulas of Nakagawa and Schielzeth
# (2013) and Johnson (2014). Run from this folder: Rscript residuals_nlme.R
library(nlme)
source("json.R")

stands <- read_data("stands.csv")
stands$stand <- factor(stands$stand, levels = unique(stands$stand))
stands$plot <- factor(stands$plot, levels = unique(stands$plot))
tight <- nlmeControl(maxIter = 200, tolerance = 1e-8, pnlsTol = 1e-6, msTol = 1e-10)
rows <- seq(1, nrow(stands), by = 7)

# Effects of each group under the labels of the data; nlme's are in the order of the levels.
effects_of <- function(x) setNames(lapply(seq_len(nrow(x)), function(i) as.list(unlist(x[i, , drop = FALSE]))), rownames(x))

residuals_of <- function(fit, levels) {
  resid_of <- function(type, level) unname(as.numeric(resid(fit, type = type, level = level)))[rows]
  list(fitted_population = unname(as.numeric(fitted(fit, level = 0)))[rows],
       fitted_conditional = unname(as.numeric(fitted(fit, level = levels)))[rows],
       response_population = resid_of("response", 0), response_conditional = resid_of("response", levels),
       pearson_population = resid_of("pearson", 0), pearson_conditional = resid_of("pearson", levels),
       normalized_conditional = resid_of("normalized", levels))
}

record <- function(id, fit, levels, variance, delta) {
  random <- ranef(fit)
  if (levels == 1) random <- list(plot = random)
  list(id = id, variance = variance, delta = delta, sigma = fit$sigma, fixed = as.list(fixef(fit)),
       random = lapply(random, effects_of), rows = rows, residuals = residuals_of(fit, levels))
}

start <- c(a = 28, b = 0.05)
formula <- h ~ 1.3 + a * (1 - exp(-b * dbh))
one <- nlme(formula, fixed = a + b ~ 1, random = a + b ~ 1 | plot, data = stands, start = start, weights = varPower(), control = tight)
plain <- nlme(formula, fixed = a + b ~ 1, random = a ~ 1 | plot, data = stands, start = start, control = tight)
nested <- nlme(formula, fixed = a + b ~ 1, random = a ~ 1 | stand/plot, data = stands, start = start, weights = varExp(), control = tight)

# Linear models, whose R2 are the textbook's.
shares <- function(fit, design) {
  psi <- as.matrix(getVarCov(fit))
  class(psi) <- "matrix"
  s_fixed <- var(as.numeric(fitted(fit, level = 0)))
  z <- design(stands)
  s_random <- mean(rowSums((z %*% psi) * z))
  total <- s_fixed + s_random + fit$sigma^2
  list(marginal = s_fixed / total, conditional = (s_fixed + s_random) / total)
}
lme_tight <- lmeControl(maxIter = 200, tolerance = 1e-12, msTol = 1e-14, opt = "nlminb")
intercept <- lme(h ~ dbh, random = ~ 1 | plot, data = stands, method = "ML", control = lme_tight)
slope <- lme(h ~ dbh, random = ~ dbh | plot, data = stands, method = "ML", control = lme_tight)

write_expected("nlme_residuals.json", list(script = "residuals_nlme.R", versions = versions("nlme"), data = "stands.csv"),
               list(residuals = list(record("power", one, 1, "power", as.numeric(coef(one$modelStruct$varStruct, unconstrained = FALSE))),
                                     record("none", plain, 1, "none", NULL),
                                     record("nested", nested, 2, "exponential", as.numeric(coef(nested$modelStruct$varStruct, unconstrained = FALSE)))),
                    shares = list(intercept = shares(intercept, function(d) cbind(rep(1, nrow(d)))),
                                  slope = shares(slope, function(d) cbind(1, d$dbh)))))
