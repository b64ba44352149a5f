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
held <- silvafit(curve, data = Loblolly, random = Asym ~ 1 | Seed, hold = c(R0 = -8))
expect_equal(unname(fixef(held)["R0"]), -8)
expect_true(is.na(summary(held)$tTable["R0", "Std.Error"]))
expect_equal(class_of_error(silvafit(curve, data = Loblolly, hold = c(nothing = 1))), "silvafit_usage_error")
# A random slope without a fixed slope, as nlme fits it
alone <- silvafit(distance ~ a + u * age, data = nlme::Orthodont, random = u ~ 1 | Subject, hold = c(u = 0))
of_nlme <- nlme::lme(distance ~ 1, data = nlme::Orthodont, random = ~ age - 1 | Subject, method = "ML")
expect_equal(as.numeric(logLik(alone)), as.numeric(logLik(of_nlme)), tolerance = 1e-8)
expect_equal(summary(alone)$tTable["a", 1:3], summary(of_nlme)$tTable[1, 1:3], tolerance = 1e-5, check.attributes = FALSE)
expect_equal(ranef(alone)[rownames(ranef(of_nlme)), "u"], ranef(of_nlme)[, "age"], tolerance = 1e-5)
expect_equal(unname(predict(alone, nlme::Orthodont)), unname(as.vector(fitted(of_nlme))), tolerance = 1e-5)

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

# Arguments that a function does not have stop, with the argument that was meant.
unknown_argument <- function(call) tryCatch({ force(call); "" }, silvafit_usage_error = function(e) conditionMessage(e))
says <- function(call, text) expect_true(grepl(text, unknown_argument(call), fixed = TRUE), info = text)
argument_fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly, random = Asym ~ 1 | Seed)
loblolly_rows <- Loblolly[c(1, 20, 40), ]
says(predict(argument_fit, loblolly_rows, levle = 0), "did you mean 'level'?")
says(predict(argument_fit, loblolly_rows, levle = "population"), "did you mean 'level'?")
says(predict(argument_fit, loblolly_rows, conf.level = 0.9), "use coverage")
says(predict(argument_fit, data = loblolly_rows), "did you mean 'newdata'?")
expect_equal(predict(argument_fit, loblolly_rows, allow.new.levels = TRUE), predict(argument_fit, loblolly_rows, new_groups = "population"))
says(predict(argument_fit, loblolly_rows, allow.new.levels = TRUE, new_groups = "error"), "give either")
says(simulate(argument_fit, newdata = loblolly_rows), "unknown argument 'newdata'")
expect_equal(simulate(argument_fit, seed = 3, re.form = NA, use.u = FALSE), simulate(argument_fit, seed = 3))
says(simulate(argument_fit, re.form = NULL), "draws new random effects")
expect_equal(confint(argument_fit, method = "Wald"), confint(argument_fit))
# Intervals of the bootstrap are about as wide as Wald's: 500 replicates give a quantile within some percent.
boot <- confint(argument_fit, "Asym", method = "boot", seed = 4)
expect_equal(boot, confint(argument_fit, "Asym", method = "boot", replicates = 500, seed = 4))
says(confint(argument_fit, seed = 4), "those of `method = \"boot\"`")
says(confint(argument_fit, method = "boot", nsim = 100), "use replicates")
widths <- c(diff(boot[1, ]), diff(confint(argument_fit, "Asym")[1, ]))
expect_true(abs(log(widths[1] / widths[2])) < 0.3)
says(confint(argument_fit, type = "profile"), "did you mean 'method'?")
says(residuals(argument_fit, scaled = TRUE), "type = \"pearson\"")
says(ranef(argument_fit, drop = TRUE), "available: se, condVar")
says(VarCorr(argument_fit, sigma = 2), "`sigma` has to be 1")
says(anova(argument_fit, test = "LRT"), "unknown argument 'test'")
says(update(argument_fit, varaince = "power"), "did you mean 'variance'?")
says(plot(argument_fit, levle = 0), "did you mean 'level'?")
# Every method stops at a name that it does not have.
for (method in c("fixef", "ranef", "coef", "vcov", "sigma", "VarCorr", "logLik", "nobs", "df.residual", "deviance", "extractAIC", "formula", "model.frame",
                 "family", "terms", "residuals", "fitted", "summary", "print", "predict", "simulate", "confint", "intervals")) {
  says(do.call(get(method), list(argument_fit, no_such_argument = 1)), "unknown argument 'no_such_argument'")
}

# re.form is lme4's, and so is postVar: the variance of one effect is the square of its standard error.
expect_equal(predict(argument_fit, loblolly_rows, re.form = NA), predict(argument_fit, loblolly_rows, level = "population"))
expect_equal(predict(argument_fit, loblolly_rows, re.form = NULL), predict(argument_fit, loblolly_rows, level = "conditional"))
says(predict(argument_fit, loblolly_rows, level = 0, re.form = NA), "give either `level` or `re.form`")
with_variances <- ranef(argument_fit, se = TRUE, condVar = TRUE)
expect_equal(attr(with_variances, "postVar")[1, 1, ], attr(with_variances, "se")$Asym^2, check.attributes = FALSE)

# Groups that are not in the fit are named, unless the argument says what they are.
strangers <- transform(loblolly_rows, Seed = c("301", "new", "newer"))
expect_message(predict(argument_fit, strangers), "2 rows are of groups that are not in the fit (Seed new, newer)", class = "silvafit_note", fixed = TRUE)
expect_silent(predict(argument_fit, strangers, new_groups = "population"))
expect_error(predict(argument_fit, strangers, level = "population", new_groups = "missing"), "has no effect")
expect_message(predict(argument_fit, transform(strangers, height = NA_real_), level = "calibrated"), "(Seed new, newer)", class = "silvafit_note", fixed = TRUE)
expect_error(predict(argument_fit, loblolly_rows["age"]), "level = \"population\"", class = "silvafit_input_error")

# A fit from a file has no data.
argument_file <- tempfile(fileext = ".json")
fit_json(argument_fit, argument_file)
without_data <- read_fit(argument_file)
# The order of its groups is that of the file.
groups <- rownames(coef(argument_fit))
for (extract in list(coef, ranef)) expect_equal(as.matrix(extract(without_data)[groups, , drop = FALSE]), as.matrix(extract(argument_fit)))
for (method in c("residuals", "fitted", "terms", "model.frame")) {
  says(do.call(get(method), list(without_data)), "has no data")
}
says(update(without_data), "was read from a file")
expect_error(model.matrix(argument_fit), "no model matrix", class = "silvafit_usage_error")

if (requireNamespace("insight", quietly = TRUE) && requireNamespace("performance", quietly = TRUE)) {
  expect_true(insight::is_mixed_model(argument_fit))
  expect_equal(insight::find_random(argument_fit)$random, "Seed")
  measured <- performance::model_performance(argument_fit)
  expect_equal(measured$AIC, AIC(argument_fit))
  expect_equal(measured$RMSE, sqrt(mean(residuals(argument_fit)^2)))
  expect_false(performance::check_singularity(argument_fit))
  # All groups have the same mean, so that the variance between them is 0.
  equal <- data.frame(y = rep(c(1, 2, 3, 4), 6), g = rep(letters[1:6], each = 4))
  equal_fit <- suppressMessages(silvafit(y ~ m, equal, random = m ~ 1 | g, start = c(m = 2)))
  expect_true(performance::check_singularity(equal_fit))
}

# Elements are not completed from parts of their names, and those of other packages name their function
children <- as.data.frame(nlme::Orthodont)
line <- silvafit(distance ~ a + b * age, children, random = a ~ 1 | Subject)
for (name in c("resid", "sigma", "coef", "logLik")) expect_equal(class_of_error(eval(call("$", line, name))), "silvafit_usage_error", info = name)
expect_null(line$resi)
expect_true(grepl("use residuals(fit)", message_of_error(line$resid), fixed = TRUE))

# Data and fits with the rows in other groups
file <- tempfile()
fit_json(line, file)
set.seed(1)
other <- transform(children, Subject = rep(sample(unique(as.character(Subject))), each = 4))
expect_equal(class_of_error(read_fit(file, other)), "silvafit_input_error")
expect_equal(residuals(read_fit(file, children)), residuals(line), tolerance = 1e-12)
moved <- transform(children, Subject = sample(Subject))
expect_equal(class_of_error(anova(line, silvafit(distance ~ a + b * age, moved, random = a + b ~ 1 | Subject))), "silvafit_usage_error")
expect_equal(class_of_error(anova(line, silvafit(distance ~ a + b * age, children[-1, ]))), "silvafit_usage_error")
shuffled <- children[sample(108), ]
expect_equal(anova(silvafit(distance ~ a + b * age, shuffled), line)$L.Ratio, anova(silvafit(distance ~ a + b * age, children), line)$L.Ratio, tolerance = 1e-9)

# Coefficients beside the data, as nlme has them for groups with the same columns
theirs <- nlme::lme(distance ~ age, children, random = ~ 1 | Subject, method = "ML")
expect_equal(unname(as.matrix(coef(line, augFrame = TRUE)[, 1:2])), unname(as.matrix(coef(theirs, augFrame = TRUE)[, 1:2])), tolerance = 1e-5)
expect_equal(coef(line, augFrame = TRUE)$Sex, coef(theirs, augFrame = TRUE)$Sex)
expect_true(length(capture.output(print(summary(silvafit(distance ~ a + b * age, children))))) > 10)
expect_equal(class_of_error(VarCorr(silvafit(distance ~ a + b * age, children))), "silvafit_usage_error")
expect_true(grepl("b is a column", message_of_error(silvafit(distance ~ a + b * age, transform(children, b = 1), parameters = a + b ~ 1))))

# Files: a left side that is an expression, and the names of levels
logarithmic <- silvafit(log(distance) ~ a + b * age, children, random = a ~ 1 | Subject, parameters = a ~ Sex)
fit_json(logarithmic, file)
expect_equal(fixef(read_fit(file)), fixef(logarithmic))
expect_equal(residuals(read_fit(file, children)), residuals(logarithmic), tolerance = 1e-12)
if (requireNamespace("data.table", quietly = TRUE)) {
  trees <- data.frame(plot = 1, tree = 1:12, species = "A", x = c(1:6, 6:1), y = rep(c(1, 4), each = 6), dbh = 10:21, h = 10)
  options(warn = 2)
  table <- suppressMessages(structural_units(data.table::as.data.table(trees), edge = "none", trust_units = TRUE))
  expect_true("new" %in% names(table[, `:=`(new, 1)]))
  options(warn = 0)
}
