# SPDX-License-Identifier: MIT
# Predictions, intervals, tests, simulation, and methods of other packages.
source("helpers.R", local = TRUE)
curve <- height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age)
fit <- silvafit(curve, data = Loblolly, random = Asym ~ 1 | Seed)

# Generics of nlme find the methods whatever is loaded first.
expect_equal(nlme::fixef(fit), fixef(fit))
expect_equal(nlme::VarCorr(fit), VarCorr(fit))
expect_equal(nlme::ranef(fit), ranef(fit))

# Levels
expect_equal(unname(predict(fit)), unname(fitted(fit)))
expect_equal(unname(predict(fit, Loblolly, level = 0)), unname(fitted(fit, level = "population")))
beta <- fixef(fit)
expect_equal(unname(predict(fit, data.frame(age = 7), level = "population")), unname(beta["Asym"] + (beta["R0"] - beta["Asym"]) * exp(-exp(beta["lrc"]) * 7)), tolerance = 1e-12)
# The model is linear in the random effect, so that the mean over the groups is the population's.
expect_equal(predict(fit, data.frame(age = 7), level = "marginal"), predict(fit, data.frame(age = 7), level = "population"), tolerance = 1e-9)
# Calibration by the rows of a group gives its own effect; a linear effect has the BLUP of the normal distribution.
own <- Loblolly[Loblolly$Seed == "301", ]
new <- transform(own, Seed = "new")
expect_equal(as.vector(predict(fit, new, level = "calibrated")), as.vector(predict(fit, own)), tolerance = 1e-8)
slope <- 1 - exp(-exp(beta["lrc"]) * own$age)
error <- own$height - predict(fit, own, level = 0)
variance <- VarCorr(fit)$Seed[1, 1]
blup <- variance * sum(slope * error) / (variance * sum(slope^2) + sigma(fit)^2)
expect_equal(ranef(fit)["301", "Asym"], unname(blup), tolerance = 1e-6)
one <- transform(new, height = ifelse(age == 10, height, NA))
expect_equal(unique(attr(predict(fit, one, level = "calibrated"), "measured")), 1L)
expect_true(all(is.na(predict(fit, data.frame(age = 5, Seed = "unknown"), new_groups = "missing"))))
expect_equal(class_of_error(predict(fit, data.frame(age = 5, Seed = "unknown"), new_groups = "error")), "silvafit_input_error")
expect_equal(class_of_error(predict(fit, data.frame(age = 5, Seed = "301"), level = "calibrated")), "silvafit_input_error")
interval <- predict(fit, Loblolly[1:5, ], interval = "prediction", se.fit = TRUE)
expect_equal(names(interval), c("fit", "lwr", "upr", "se.fit"))
expect_true(all(interval$lwr < interval$fit & interval$fit < interval$upr))
# A straight line has the intervals of lm.
line <- silvafit(dist ~ a + b * speed, data = cars)
expected <- predict(lm(dist ~ speed, cars), data.frame(speed = c(5, 20)), interval = "prediction", se.fit = TRUE)
got <- predict(line, data.frame(speed = c(5, 20)), interval = "prediction")
expect_true(relative(as.matrix(got), expected$fit) < 1e-7)
got <- predict(line, data.frame(speed = c(5, 20)), interval = "confidence", se.fit = TRUE)
expect_true(relative(got$se.fit, expected$se.fit) < 1e-7)
expect_equal(df.residual(line), 48L)
expect_true(relative(confint(line, c("a", "b")), confint(lm(dist ~ speed, cars))) < 1e-7)

# Confidence intervals
wald <- confint(fit)
expect_equal(rownames(wald), c("Asym", "R0", "lrc", "sd(Asym)", "sigma"))
profile <- confint(fit, "Asym", method = "profile")
expect_true(relative(profile, wald["Asym", , drop = FALSE]) < 0.05)
expect_equal(class_of_error(confint(fit, "nothing")), "silvafit_usage_error")

# Likelihood-ratio test of a variance: half the p value of chi-squared
none <- silvafit(curve, data = Loblolly, variance = "none", method = "gnls")
two <- silvafit(curve, data = Loblolly, random = list(Asym ~ 1 | Seed, R0 ~ 1 | Seed))
test <- anova(fit, two)
statistic <- 2 * (as.numeric(logLik(two)) - as.numeric(logLik(fit)))
expect_equal(test$L.Ratio[2], statistic, tolerance = 1e-6)
expect_equal(test$`p-value`[2], pchisq(statistic, 1, lower.tail = FALSE) / 2, tolerance = 1e-3)
expect_true(all(dim(anova(fit)) == c(3, 4)))
expect_equal(class_of_error(anova(fit, lm(dist ~ speed, cars))), "silvafit_usage_error")

# simulate() has the variances of the model: sigma^2 + slope^2 psi^2 of each row
drawn <- simulate(fit, nsim = 2000, seed = 2)
expect_equal(dim(drawn), c(84L, 2000L))
slope <- 1 - exp(-exp(beta["lrc"]) * Loblolly$age)
expect_true(relative(apply(drawn, 1, var), sigma(fit)^2 + slope^2 * variance) < 5 * sqrt(2 / 2000))
expect_equal(simulate(fit, seed = 5), simulate(fit, seed = 5))

# update(), summary, printing
expect_true(logLik(update(fit, variance = "power")) > logLik(fit))
expect_equal(update(fit, . ~ .)$fit$log_likelihood, fit$fit$log_likelihood)
shown <- capture.output(print(summary(fit)))
expect_true(any(grepl("Number of observations: 84", shown)))
expect_true(any(grepl("Std.Error", shown)))
expect_silent(invisible(capture.output(print(fit), print(VarCorr(fit)), print(intervals(fit)), print(anova(fit)), print(convergence(fit)))))
grDevices::pdf(NULL)
expect_silent(plot(fit))
expect_silent(qqnorm(fit))
expect_silent(qqnorm(fit, of = "ranef"))
invisible(grDevices::dev.off())

# Nothing is written to the standard output by C++
expect_equal(length(capture.output(silvafit(curve, data = Loblolly, random = Asym ~ 1 | Seed))), length(capture.output(print(fit))))
expect_equal(capture.output(quiet <- silvafit(curve, data = Loblolly, random = Asym ~ 1 | Seed)), character())

# Held and bounded coefficients, start values with names of nlme
held <- silvafit(curve, data = Loblolly, random = Asym ~ 1 | Seed, fixed = c(R0 = -8))
expect_equal(unname(fixef(held)["R0"]), -8)
expect_true(is.na(summary(held)$tTable["R0", "Std.Error"]))
expect_equal(class_of_error(silvafit(curve, data = Loblolly, fixed = c(nothing = 1))), "silvafit_usage_error")

if (requireNamespace("broom", quietly = TRUE)) {
  tidy <- broom::tidy(fit, conf.int = TRUE)
  expect_equal(tidy$term, c("Asym", "R0", "lrc", "sd__Asym", "sd__Observation"))
  expect_equal(tidy$conf.low, unname(confint(fit)[c("Asym", "R0", "lrc", "sd(Asym)", "sigma"), 1]))
  expect_equal(broom::glance(fit)$AIC, AIC(fit))
  expect_equal(broom::augment(fit)$.resid, as.vector(residuals(fit)))
} else skipped("broom is not installed")
if (requireNamespace("emmeans", quietly = TRUE)) {
  soybean <- silvafit(weight ~ a / (1 + exp((m - Time) / s)), data = nlme::Soybean, parameters = a ~ Variety, random = a ~ 1 | Plot)
  means <- as.data.frame(emmeans::emmeans(soybean, ~ Variety, param = "a"))
  expect_equal(means$emmean[2], unname(fixef(soybean)["a"] + fixef(soybean)["a:VarietyP"]), tolerance = 1e-10)
  expect_equal(means$SE[1], unname(sqrt(vcov(soybean)["a", "a"])), tolerance = 1e-10)
} else skipped("emmeans is not installed")
if (requireNamespace("performance", quietly = TRUE)) {
  expect_equal(unname(performance::r2(fit)$R2_conditional), fit$fit$r2_conditional)
} else skipped("performance is not installed")
if (requireNamespace("ggplot2", quietly = TRUE)) {
  expect_true(inherits(ggplot2::autoplot(fit), "ggplot"))
} else skipped("ggplot2 is not installed")
