# SPDX-License-Identifier: MIT
# Formulas of R as R reads them: an expression as response, self-starting models, tests of terms. With the numbers that users of
# statsmodels expect of a linear model. Run from this folder: Rscript reference_formulas.R
library(nlme)
source("json.R")

stands <- read_data("stands.csv")
stands$species <- factor(stands$species)
tight <- nlmeControl(maxIter = 200, tolerance = 1e-8, pnlsTol = 1e-6, msTol = 1e-10)

linear <- lm(log(h) ~ log(dbh), stands)
table <- coef(summary(linear))
new <- data.frame(dbh = c(8, 20, 45))
mean <- predict(linear, new, interval = "confidence", level = 0.9, se.fit = TRUE)
observation <- predict(linear, new, interval = "prediction", level = 0.9)
log_h <- list(params = unname(table[, 1]), bse = unname(table[, 2]), tvalues = unname(table[, 3]), pvalues = unname(table[, 4]),
              llf = as.numeric(logLik(linear)), conf_int = unname(confint(linear, level = 0.9)), cov_params = unname(vcov(linear)),
              rsquared = summary(linear)$r.squared, scale = summary(linear)$sigma^2, resid = unname(resid(linear)[1:10]),
              fittedvalues = unname(fitted(linear)[1:10]), dbh = new$dbh, mean = unname(mean$fit[, 1]), mean_se = unname(mean$se.fit),
              mean_ci = unname(mean$fit[, 2:3]), obs_ci = unname(observation[, 2:3]))

# R's own start values fail for some of them.
nls_of <- function(formula, start) {
  fit <- nls(formula, stands, start = start, control = nls.control(tol = 1e-9, maxiter = 500))
  list(formula = deparse1(formula), params = as.list(coef(fit)), llf = as.numeric(logLik(fit)))
}
self_starting <- list(nls_of(h ~ SSlogis(dbh, Asym, xmid, scal), list(Asym = 25, xmid = 15, scal = 8)),
                      nls_of(h ~ SSasymp(dbh, Asym, R0, lrc), list(Asym = 28, R0 = 1, lrc = -3)),
                      nls_of(h ~ SSgompertz(dbh, Asym, b2, b3), list(Asym = 26, b2 = 2.5, b3 = 0.92)),
                      nls_of(h ~ SSmicmen(dbh, Vm, K), list(Vm = 40, K = 25)))
# Values at 3 of the models in the order of their arguments.
values <- list("SSasymp(x, 20, 2, -1.5)" = SSasymp(3, 20, 2, -1.5), "SSasympOff(x, 20, -1.5, 0.5)" = SSasympOff(3, 20, -1.5, 0.5),
               "SSasympOrig(x, 20, -1.5)" = SSasympOrig(3, 20, -1.5), "SSbiexp(x, 5, 0.2, 2, -1.1)" = SSbiexp(3, 5, 0.2, 2, -1.1),
               "SSfol(4, x, -2.5, 0.5, -3)" = SSfol(4, 3, -2.5, 0.5, -3), "SSfpl(x, 1, 20, 4, 1.5)" = SSfpl(3, 1, 20, 4, 1.5),
               "SSgompertz(x, 20, 2, 0.7)" = SSgompertz(3, 20, 2, 0.7), "SSlogis(x, 20, 4, 1.5)" = SSlogis(3, 20, 4, 1.5),
               "SSmicmen(x, 200, 0.5)" = SSmicmen(3, 200, 0.5), "SSweibull(x, 20, 18, -3, 2)" = SSweibull(3, 20, 18, -3, 2))

# Wald tests of terms: a factor with three levels and a covariate, in one parameter.
stands$size <- factor(cut(stands$crowding, c(-Inf, 0.5, 0.8, Inf), labels = c("low", "medium", "high")))
mixed <- nlme(h ~ 1.3 + a * (1 - exp(-b * dbh / 10)), stands, fixed = list(a ~ size + species, b ~ 1), random = a ~ 1 | plot,
              start = c(29, 0, 0, 0, 0.48), method = "ML", control = tight)
plain <- gls(h ~ size * dbh, stands, method = "REML")
tests_of <- function(fit) {
  table <- anova(fit, type = "marginal")
  denominator <- if (is.null(table$denDF)) fit$dims$N - fit$dims$p else table$denDF
  list(names = rownames(table), F = table[["F-value"]], p = table[["p-value"]], df = table$numDF, df_denominator = denominator)
}

write_expected("formulas.json", c(script = "reference_formulas.R", versions("nlme")),
               list(log_h = log_h, self_starting = self_starting, values = values,
                    terms = list(limits = c(0.5, 0.8), mixed = tests_of(mixed), linear = tests_of(plain))))
