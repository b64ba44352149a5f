# SPDX-License-Identifier: MIT
# Methods for insight, performance, parameters, lmtest, multcomp, lme4, broom.mixed and ggplot2. Expected values are those of lme() for a linear model.
source("helpers.R", local = TRUE)
library(nlme)  # update() of its fits calls its functions by name
there <- function(package) requireNamespace(package, quietly = TRUE) || { skipped(paste(package, "is not installed")); FALSE }
theirs <- nlme::lme(distance ~ age, data = nlme::Orthodont, random = ~ 1 | Subject, method = "ML", control = nlme::lmeControl(msTol = 1e-12, tolerance = 1e-12))
fit <- silvafit(distance ~ a + b * age, data = nlme::Orthodont, random = a ~ 1 | Subject)
table <- summary(theirs)$tTable

if (there("insight")) {
  expect_equal(insight::find_predictors(fit), list(conditional = "age"))
  expect_equal(insight::find_response(fit), "distance")
  expect_equal(insight::find_random(fit)$random, "Subject")
  expect_true(insight::model_info(fit)$is_mixed)
  expect_equal(insight::get_data(fit)$distance, nlme::Orthodont$distance)
  expect_equal(as.numeric(insight::get_predicted(fit)), as.vector(fitted(fit)))
  expect_equal(insight::get_loglikelihood(fit), logLik(fit))
  expect_equal(unname(insight::get_df(fit)), unname(table[, "DF"]))
  expect_equal(insight::get_df(fit, type = "model"), attr(logLik(theirs), "df"))
  expect_equal(insight::get_df(fit, type = "normal"), Inf)
  # Parameters of the model are no variables.
  expect_equal(insight::find_variables(fit), list(response = "distance", conditional = "age", random = "Subject"))
  expect_equal(names(insight::get_random(fit)), "Subject")
  # What lmer() predicts, whose standard errors have no factor N / (N - p).
  new <- data.frame(age = c(8, 11), Subject = c("M01", "F02"))
  shown <- function(model, ...) as.data.frame(suppressMessages(insight::get_predicted(model, new, ...)))
  expect_equal(shown(fit)$Predicted, as.vector(predict(theirs, new, level = 1)), tolerance = 1e-6)
  expect_equal(shown(fit, include_random = FALSE)$Predicted, as.vector(predict(theirs, new, level = 0)), tolerance = 1e-6)
  if (there("lme4")) {
    linear <- lme4::lmer(distance ~ age + (1 | Subject), data = nlme::Orthodont, REML = FALSE)
    expect_equal(shown(fit, include_random = FALSE, ci = 0.9)$SE, shown(linear, include_random = FALSE, ci = 0.9)$SE * sqrt(108 / 106), tolerance = 1e-4)
  }
  expect_equal(shown(fit, ci = 0.9, predict = "prediction")[c("CI_low", "CI_high")], predict(fit, new, interval = "prediction", coverage = 0.9)[c("lwr", "upr")], check.attributes = FALSE)
  # Arguments that would change nothing stop.
  for (call in list(quote(get_predicted(fit, foo = 1)), quote(get_predicted(fit, predict = "terms")), quote(get_loglikelihood(fit, REML = TRUE)), quote(get_parameters(fit, effects = "nope")),
                    quote(get_df(fit, type = "nope")), quote(get_statistic(fit, foo = 1)))) {
    call[[1]] <- call("::", quote(insight), call[[1]])
    expect_equal(class_of_error(eval(call)), "silvafit_usage_error", info = deparse1(call))
  }
}
if (there("performance")) {
  expect_true(performance::check_convergence(fit))
  expect_equal(performance::performance_aicc(fit), -2 * as.numeric(logLik(fit)) + 2 * 4 * 108 / (108 - 4 - 1), tolerance = 1e-9)
}
if (there("parameters")) {
  parameters <- parameters::model_parameters(fit, effects = "fixed")
  expect_equal(parameters$Coefficient, unname(table[, "Value"]), tolerance = 1e-6)
  expect_equal(parameters$SE, unname(table[, "Std.Error"]), tolerance = 1e-6)
  expect_equal(parameters$p, unname(table[, "p-value"]), tolerance = 1e-5)
  expect_equal(parameters$CI_low, unname(table[, "Value"] - stats::qt(0.975, table[, "DF"]) * table[, "Std.Error"]), tolerance = 1e-5)
}
if (there("parameters")) {
  limits <- function(...) as.matrix(as.data.frame(parameters::model_parameters(fit, ...))[c("CI_low", "CI_high")])
  profile <- confint(fit, method = "profile")
  expect_equal(unname(limits(ci_method = "profile")), unname(unclass(profile)[1:4, ]), check.attributes = FALSE)
  expect_equal(unname(limits(ci_method = "normal", effects = "fixed"))[, 2], unname(table[, "Value"] + qnorm(0.975) * table[, "Std.Error"]), tolerance = 1e-6)
  expect_equal(as.matrix(bayestestR::ci(fit, method = "profile")[c("CI_low", "CI_high")]), unclass(profile)[1:2, ], check.attributes = FALSE)
  expect_equal(is.na(limits(ci_random = FALSE)[, 1]), c(FALSE, FALSE, TRUE, TRUE), check.attributes = FALSE)
  expect_false("CI_low" %in% names(parameters::model_parameters(fit, ci = NULL)))
  expect_equal(class_of_error(parameters::model_parameters(fit, foo = 1)), "silvafit_usage_error")
  expect_equal(class_of_error(parameters::model_parameters(fit, ci_method = "hdi")), "silvafit_usage_error")
  # Groups stay together: the widths of 200 replicates are within 25 % of those of Wald's intervals. Rows without their groups gave a fourth in data of few plots.
  set.seed(1)
  drawn <- as.data.frame(parameters::model_parameters(fit, bootstrap = TRUE, iterations = 200))
  expect_equal(drawn$CI_high - drawn$CI_low, apply(confint(fit, c("a", "b")), 1, diff), tolerance = 0.25, check.attributes = FALSE)
}
if (there("parameters") && there("lme4")) {
  linear <- lme4::lmer(distance ~ age + (1 | Subject), data = nlme::Orthodont, REML = FALSE)
  ours <- as.data.frame(parameters::model_parameters(fit))
  expected <- suppressMessages(as.data.frame(parameters::model_parameters(linear)))
  for (column in c("Coefficient", "Effects", "Group")) expect_equal(ours[[column]], expected[[column]], tolerance = 1e-5, info = column)
  expect_equal(ours$Parameter[3:4], c("SD (a)", "SD (Observations)"))
  random <- parameters::model_parameters(fit, effects = "random")
  expect_equal(as.data.frame(random)$CI_low, unname(confint(fit)[3:4, 1]))
  expect_true(any(grepl("SD \\(a: Subject\\)", capture.output(print(random)))))
  if (there("performance")) {
    second <- lme4::lmer(distance ~ age + (age | Subject), data = nlme::Orthodont, REML = FALSE)
    compared <- performance::compare_performance(fit, update(fit, random = a + b ~ 1 | Subject))
    expected <- suppressMessages(performance::compare_performance(linear, second))
    expect_equal(compared$Name[1], "fit")
    for (column in setdiff(names(expected), c("Name", "Model"))) expect_equal(compared[[column]], expected[[column]], tolerance = 1e-4, info = column)
    expect_equal(performance::compare_performance(fit, linear)$Model, c("silvafit", "lmerMod"))
  }
}
if (there("lmtest")) {
  tested <- lmtest::coeftest(fit)
  expect_equal(unname(tested[, 1:3]), unname(table[, c("Value", "Std.Error", "t-value")]), tolerance = 1e-6)
  expect_equal(unname(lmtest::coeftest(fit, vcov. = 4 * vcov(fit))[, 2]), 2 * unname(table[, "Std.Error"]), tolerance = 1e-6)
  expect_equal(lmtest::coefci(fit)[, 1], confint(fit, c("a", "b"))[, 1])
  fewer <- update(fit, hold = c(b = 0))
  for (other in list(quote(silvafit(log(distance) ~ a + b * age, data = nlme::Orthodont, random = a ~ 1 | Subject)), quote(update(fit, method = "laplace")),
                     quote(silvafit(distance ~ a * age^b, data = nlme::Orthodont, random = a ~ 1 | Subject)))) {
    expect_equal(class_of_error(lmtest::lrtest(fewer, eval(other))), "silvafit_usage_error", info = deparse1(other))
  }
  expect_equal(lmtest::lrtest(fewer, fit)$Chisq[2], as.numeric(2 * (logLik(theirs) - logLik(update(theirs, distance ~ 1)))), tolerance = 1e-5)
}
if (there("multcomp")) {
  ours <- summary(multcomp::glht(fit, linfct = rbind(slope = c(0, 1), at_8 = c(1, 8))), test = multcomp::adjusted("none"))$test
  lme_test <- summary(multcomp::glht(theirs, linfct = rbind(slope = c(0, 1), at_8 = c(1, 8))), test = multcomp::adjusted("none"))$test
  expect_equal(ours$coefficients, lme_test$coefficients, tolerance = 1e-6)
  # vcov() of lme() has no factor N / (N - p).
  expect_equal(ours$sigma, lme_test$sigma * sqrt(108 / 106), tolerance = 1e-5)
}
if (there("lme4")) {
  expect_equal(lme4::ngrps(fit), c(Subject = 27L), check.attributes = FALSE)
  expect_false(lme4::isREML(fit))
  expect_true(lme4::isREML(update(fit, REML = TRUE)))
  if (there("performance")) {
    linear <- lme4::lmer(distance ~ age + (1 | Subject), data = nlme::Orthodont, REML = FALSE)
    expected <- insight::get_variance(linear)
    for (part in c("var.fixed", "var.random", "var.residual")) {
      expect_equal(insight::get_variance(fit)[[part]], unname(expected[[part]]), tolerance = 1e-4, info = part)
    }
    expect_equal(performance::icc(fit)$ICC_adjusted, performance::icc(linear)$ICC_adjusted, tolerance = 1e-4)
  }
}
if (there("broom.mixed")) {
  expected <- broom.mixed::tidy(theirs)
  ours <- broom.mixed::tidy(fit)
  expect_equal(ours$estimate, expected$estimate, tolerance = 1e-5)
  expect_equal(ours$term[3:4], c("sd__a", "sd__Observation"))
}
if (there("generics")) {
  expect_equal(generics::glance(fit)$logLik, as.numeric(logLik(fit)))
  expect_equal(generics::augment(fit, data = nlme::Orthodont)$.fitted, as.vector(fitted(fit)))
  for (other in list(nlme::Orthodont[108:1, ], data.frame(row = 1:108))) expect_equal(class_of_error(generics::augment(fit, data = other)), "silvafit_usage_error")
}
if (there("ggplot2")) {
  expect_equal(ggplot2::fortify(fit)$.stdresid, as.vector(resid(fit, type = "pearson")))
  expect_equal(names(ggplot2::fortify(fit))[1:4], c("distance", "age", "Subject", ".fitted"))
}
# Coefficients that are held have no errors.
held <- silvafit(distance ~ a + b * age, data = nlme::Orthodont, random = a ~ 1 | Subject, hold = c(b = 0.5))
if (there("parameters")) expect_equal(is.na(parameters::model_parameters(held, effects = "fixed")$CI_low), c(FALSE, TRUE))
if (there("lmtest")) {
  expect_equal(is.na(lmtest::coeftest(held)[, "Pr(>|t|)"]), c(a = FALSE, b = TRUE))
  expect_equal(lmtest::coefci(held)["a", ], confint(held, "a")[1, ])
}

# What marginaleffects calls: coefficients in the place of those of the fit change predictions as the model says.
moved <- silvafit:::set_coef.silvafit(fit, c(1, 2))
expect_equal(silvafit:::get_predict.silvafit(moved, data.frame(age = c(3, 5)))$estimate, c(7, 11))
expect_equal(predict(fit, data.frame(age = 0), level = 0), fixef(fit)["a"], check.attributes = FALSE)
expect_equal(silvafit:::get_predict.silvafit(fit, nlme::Orthodont[1:3, ], re.form = NULL)$estimate, as.vector(fitted(fit))[1:3])
expect_equal(silvafit:::get_vcov.silvafit(fit, 4 * vcov(fit)), 4 * vcov(fit))
expect_equal(class_of_error(silvafit:::get_vcov.silvafit(fit, "HC3")), "silvafit_usage_error")
if (there("marginaleffects")) {
  options(marginaleffects_model_classes = "silvafit")
  expect_equal(mean(marginaleffects::slopes(fit, variables = "age")$estimate), unname(fixef(fit)["b"]), tolerance = 1e-4)
}

# lme4 and car, beside the same model of lmer(). Estimates agree to the tolerance of lmer's search.
if (requireNamespace("lme4", quietly = TRUE) && requireNamespace("car", quietly = TRUE)) {
  sleep <- lme4::sleepstudy
  ours <- silvafit(Reaction ~ a + b * Days, data = sleep, random = a + b ~ 1 | Subject)
  theirs <- suppressMessages(lme4::lmer(Reaction ~ Days + (Days | Subject), sleep, REML = FALSE))
  expect_equal(lme4::getME(ours, "theta"), unname(lme4::getME(theirs, "theta")), tolerance = 1e-4)
  expect_equal(lme4::getME(ours, c("lower", "n", "p", "q", "l_i")), lapply(lme4::getME(theirs, c("lower", "n", "p", "q", "l_i")), unname))
  expect_equal(lme4::getME(ours, "beta"), unname(lme4::getME(theirs, "beta")), tolerance = 1e-6)
  expect_false(lme4::isSingular(ours))
  flat <- data.frame(y = c(1, 2, 3, 3.1, 2.1, 0.9), x = c(1, 2, 3, 3, 2, 1), g = rep(c("a", "b", "c"), each = 2))
  expect_true(lme4::isSingular(suppressMessages(silvafit(y ~ a + b * x, data = flat, random = a ~ 1 | g))))
  expect_error(lme4::getME(ours, "theeta"), "did you mean 'theta'")
  expect_true(lme4::isNLMM(ours))
  doubled <- lme4::refit(ours, 2 * sleep$Reaction)
  expect_equal(fixef(doubled), 2 * fixef(ours), tolerance = 1e-6)
  expect_false(lme4::isREML(lme4::refitML(update(ours, reml = TRUE))))
  # chi-squared of b = 10: the square of Wald's z.
  z <- (fixef(ours)[["b"]] - 10) / sqrt(vcov(ours)["b", "b"])
  expect_equal(car::linearHypothesis(ours, "b = 10")$Chisq[2], z^2)
  # The delta method by hand: se(a/b)^2 = g' V g.
  g <- c(1 / fixef(ours)[["b"]], -fixef(ours)[["a"]] / fixef(ours)[["b"]]^2)
  expect_equal(car::deltaMethod(ours, "a/b")$SE, sqrt(drop(g %*% vcov(ours) %*% g)), tolerance = 1e-6)
  expect_equal(row.names(car::Anova(ours)), c("a", "b"))
  expect_true(grepl("Type III", attr(car::Anova(ours), "heading")))
  for (argument in list(list(type = "II"), list(type = 2), list(test.statistic = "Chisq"))) expect_equal(class_of_error(do.call(car::Anova, c(list(ours), argument))), "silvafit_usage_error")
  values <- generics::tidy(ours, effects = "ran_vals")
  expect_equal(values$estimate[values$level == "308"], unlist(ranef(ours)["308", ], use.names = FALSE))
  expect_equal(values$std.error[values$level == "308"], unlist(attr(ranef(ours, se = TRUE), "se")["308", ], use.names = FALSE))
  coefficients <- generics::tidy(ours, effects = "ran_coefs")
  expect_equal(coefficients$estimate[coefficients$term == "b"], unname(coef(ours)[, "b"]))
}
