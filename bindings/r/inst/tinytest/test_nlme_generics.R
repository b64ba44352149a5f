# SPDX-License-Identifier: MIT
# Arguments and generics of nlme: the same results as nlme's own in the same session, to the precision of its fits.
source("helpers.R", local = TRUE)
library(nlme)
tight <- nlmeControl(tolerance = 1e-8, pnlsTol = 1e-6, msTol = 1e-10, maxIter = 200, msMaxIter = 200, pnlsMaxIter = 50)
quiet <- suppressMessages
same <- function(ours, theirs, tolerance = 1e-5) expect_equal(ours, theirs, tolerance = tolerance, check.attributes = FALSE)
asymptotic <- height ~ SSasymp(age, Asym, R0, lrc)
arguments <- list(asymptotic, data = Loblolly, fixed = Asym + R0 + lrc ~ 1, random = Asym ~ 1, start = c(103, -8.5, -3.3), control = tight)
theirs <- do.call(nlme, arguments)

# The call of nlme(): fixed, random with the groups of the groupedData, start without names, control. What the control has no use for is said.
expect_message(ours <- do.call(silvafit, arguments), "`control`: .*tolerance.* not used", class = "silvafit_note")
same(fixef(ours), fixef(theirs))
expect_equal(logLik(ours), logLik(silvafit(asymptotic, data = Loblolly, random = Asym ~ 1 | Seed)), tolerance = 1e-8)
expect_equal(ours$call$max_iterations, 200)

# Data, groups, response
expect_equal(getGroups(ours), getGroups(theirs))
expect_equal(getData(ours), getData(theirs))
same(getResponse(ours), getResponse(theirs), 1e-12)
expect_equal(attr(getResponse(ours), "label"), attr(getResponse(theirs), "label"))
for (part in list(getGroupsFormula, getResponseFormula, getCovariateFormula)) expect_equal(deparse(part(ours)), deparse(part(theirs)))
expect_equal(getVarCov(ours)[1, 1], VarCorr(ours)$Seed[1, 1])

# Covariance of the responses of groups, in linear models, where nlme has it: given the random effects, and marginal
linear <- lme(distance ~ age, Orthodont, random = ~ age, method = "ML", control = lmeControl(msTol = 1e-12, tolerance = 1e-12))
own_linear <- silvafit(distance ~ a + b * age, Orthodont, random = a + b ~ 1 | Subject)
for (type in c("random.effects", "conditional", "marginal")) same(unclass(getVarCov(own_linear, "M05", type = type)), unclass(getVarCov(linear, "M05", type = type)))
correlated <- lme(distance ~ age, Orthodont, random = ~ 1, correlation = corCAR1(form = ~ age), weights = varPower(), method = "ML", control = lmeControl(msTol = 1e-12, tolerance = 1e-12))
own_correlated <- silvafit(distance ~ a + b * age, Orthodont, random = a ~ 1, correlation = corCAR1(form = ~ age), weights = varPower())
same(unclass(getVarCov(own_correlated, "F02", type = "marginal")), unclass(getVarCov(correlated, "F02", type = "marginal")), 1e-3)
# Of a nonlinear model by hand: the derivative of the asymptote is 1 - exp(-exp(lrc) age).
slope <- 1 - exp(-exp(fixef(ours)[["lrc"]]) * c(3, 5, 10, 15, 20, 25))
expect_equal(unclass(getVarCov(ours, "301", type = "marginal"))[["301"]], VarCorr(ours)$Seed[1, 1] * outer(slope, slope) + diag(sigma(ours)^2, 6), tolerance = 1e-9, check.attributes = FALSE)
expect_error(getVarCov(ours, "999", type = "marginal"), "no row of the fit is of Seed 999", class = "silvafit_usage_error")
expect_equal(c(isBalanced(ours), isBalanced(ours, countOnly = TRUE)), c(isBalanced(Loblolly), TRUE))
expect_false(isBalanced(silvafit(asymptotic, Loblolly[-1, ], random = Asym ~ 1)))
expect_equal(as.vector(getCovariate(ours)), as.vector(getCovariate(Loblolly)))
expect_equal(getCovariate(ours, ~ age), Loblolly$age)

# VarCorr() is printed as by nlme, but for the last digits of estimates.
digits_of <- function(object) gsub(" +", " ", gsub("[0-9.]+", "#", capture.output(print(object))))
expect_equal(digits_of(getVarCov(own_linear, 2:3, type = "marginal")), digits_of(getVarCov(linear, 2:3, type = "marginal")))
expect_equal(digits_of(VarCorr(update(ours, random = list(Seed = pdSymm(Asym + R0 ~ 1))))),
             gsub("pdSymm", "pdLogChol", digits_of(VarCorr(update(theirs, random = list(Seed = pdSymm(Asym + R0 ~ 1)))))))
expect_equal(digits_of(VarCorr(update(ours, random = pdDiag(Asym + R0 ~ 1)))), digits_of(VarCorr(update(theirs, random = pdDiag(Asym + R0 ~ 1)))))

# Profiles: the limits of lme4's profiles of the same linear model, and the exact ones
profiled <- profile(own_linear, c("a", "b", "sigma"))
same(unclass(confint(profiled)), unclass(confint(own_linear, c("a", "b", "sigma"), method = "profile")), 1e-4)
if (requireNamespace("lme4", quietly = TRUE)) {
  limits <- suppressWarnings(confint(profile(lme4::lmer(distance ~ age + (age | Subject), Orthodont, REML = FALSE), which = "beta_"), level = 0.9))
  same(confint(profiled, 1:2, level = 0.9), limits, 1e-4)
}
squares <- silvafit(distance ~ a + b * age, Orthodont)
line <- lm(distance ~ age, Orthodont)
# The profile of a linear model is a straight line, so that its limits are those of lm().
same(confint(profile(squares), c("a", "b")), confint(line), 1e-5)
expect_error(profile(squares, "c"), "available parameters are a, b, sigma", class = "silvafit_usage_error")
grDevices::pdf(NULL)
expect_silent(plot(profiled))
invisible(grDevices::dev.off())

# Leverages and Cook's distances are those of lm(), also with known weights.
same(hatvalues(squares), hatvalues(line), 1e-9)
same(cooks.distance(squares), cooks.distance(line), 1e-9)
weighted <- silvafit(distance ~ a + b * age, Orthodont, variance = "power(age, delta = 0.5)")
same(cooks.distance(weighted), cooks.distance(lm(distance ~ age, Orthodont, weights = 1 / age)), 1e-6)
holes <- transform(as.data.frame(Orthodont), distance = replace(distance, c(2, 5, 108), NA))
omitted <- silvafit(distance ~ a + b * age, holes, na.action = na.exclude)
by_lm <- lm(distance ~ age, holes, na.action = na.exclude)
same(cooks.distance(omitted), cooks.distance(by_lm), 1e-9)
expect_equal(predict(omitted, se.fit = TRUE)$se.fit, unname(predict(by_lm, se.fit = TRUE)$se.fit), tolerance = 1e-6)
expect_error(cooks.distance(ours), "update(fit, subset", fixed = TRUE, class = "silvafit_usage_error")

# Levels and types
expect_equal(fitted(ours, level = 0:1), fitted(theirs, level = 0:1), tolerance = 1e-5)
expect_equal(as.vector(fitted(ours, level = "Seed")), as.vector(fitted(theirs)), tolerance = 1e-5)
for (type in c("response", "pearson", "normalized")) {
  same(resid(ours, level = 0:1, type = type), resid(theirs, level = 0:1, type = type), 1e-3)
  same(resid(ours, type = substr(type, 1, 1), asList = TRUE), resid(theirs, type = type, asList = TRUE), 1e-3)
}
expect_equal(names(resid(ours, asList = TRUE)), names(resid(theirs, asList = TRUE)))
expect_equal(predict(ours, Loblolly[1:9, ], level = 0:1), predict(theirs, Loblolly[1:9, ], level = 0:1), tolerance = 1e-5, check.attributes = FALSE)
expect_equal(rstandard(ours), resid(ours, type = "pearson"))
expect_error(fitted(ours, level = 2), "`level` has to be", class = "silvafit_usage_error")

# Tables of random effects and coefficients, with their classes and order of groups
expect_equal(ranef(ours), ranef(theirs), tolerance = 1e-3)
expect_equal(ranef(ours, augFrame = TRUE, standard = TRUE), ranef(theirs, augFrame = TRUE, standard = TRUE), tolerance = 1e-3)
expect_equal(ranef(ours, aug = TRUE, stand = TRUE), ranef(ours, augFrame = TRUE, standard = TRUE))
expect_equal(coef(ours), coef(theirs), tolerance = 1e-5)

# Correlation of residuals and predictions over a covariate
expect_equal(ACF(ours), ACF(theirs), tolerance = 1e-3)
expect_equal(ACF(ours, maxLag = 3, resType = "response"), ACF(theirs, maxLag = 3, resType = "response"), tolerance = 1e-3)
expect_equal(Variogram(ours, form = ~ age), Variogram(theirs, form = ~ age), tolerance = 1e-3)
expect_equal(augPred(ours, level = 0:1), augPred(theirs, level = 0:1), tolerance = 1e-5)
same(augPred(ours, ~ age, length.out = 11), augPred(theirs, ~ age, length.out = 11))
plain <- update(ours, data = as.data.frame(Loblolly), random = Asym ~ 1 | Seed)
same(augPred(plain)$height, augPred(ours)$height, 1e-6)
other <- update(ours, random = R0 ~ 1)
other_of_nlme <- update(theirs, random = R0 ~ 1)
compared <- comparePred(ours, other)
same(compared[1:3], comparePred(theirs, other_of_nlme)[1:3])
expect_equal(levels(compared$.type), c("ours", "other", "original"))

# Wald tests of terms
for (type in c("sequential", "marginal")) same(anova(ours, type = type), anova(theirs, type = type), 1e-4)
same(anova(ours, Terms = 2:3), anova(theirs, Terms = 2:3), 1e-4)
same(anova(ours, L = c(1, 2, 0)), anova(theirs, L = c(1, 2, 0)), 1e-4)
same(anova(ours, other)$AIC, anova(theirs, other_of_nlme)$AIC, 1e-6)

# Plots of lattice have the same points in the same panels.
grDevices::pdf(NULL)
plots <- expression(plot(fit, resid(., type = "p") ~ fitted(.) | Seed, abline = 0), plot(fit, Seed ~ resid(.)), plot(fit, height ~ fitted(.)), plot(fit, id = 0.05),
                    qqnorm(fit, ~ resid(., type = "p") | Seed), qqnorm(fit, ~ ranef(.)), plot(augPred(fit)), plot(ranef(fit)), plot(ACF(fit), alpha = 0.01))
for (drawn in plots) {
  our_plot <- eval(drawn, list(fit = ours))
  their_plot <- eval(drawn, list(fit = theirs))
  same(our_plot$panel.args, their_plot$panel.args, 1e-3)
  expect_equal(unclass(our_plot)[c("xlab", "ylab", "condlevels")], unclass(their_plot)[c("xlab", "ylab", "condlevels")], info = deparse(drawn))
}
two <- silvafit(circumference ~ SSlogis(age, Asym, xmid, scal), data = Orange, random = list(Tree = pdDiag(Asym + xmid ~ 1)))
expect_equal(unname(pairs(two)$panel.args[[1]]$x), coef(two)$Asym)
invisible(grDevices::dev.off())

# Plots in stands
file <- reference("data", "stands.csv")
if (file == "") {
  skipped("nested groups need the checkout")
} else {
  stands <- read.csv(file, stringsAsFactors = TRUE)
  arguments <- list(h ~ 1.3 + a * (1 - exp(-b * dbh)), data = stands, fixed = a + b ~ 1, random = list(stand = a ~ 1, plot = a + b ~ 1), start = c(a = 29, b = 0.047), control = tight)
  nested <- do.call(nlme, arguments)
  own <- quiet(do.call(silvafit, arguments))
  for (level in list(1, 2, 1:2)) expect_equal(getGroups(own, level = level), getGroups(nested, level = level))
  expect_equal(fitted(own, level = 0:2), fitted(nested, level = 0:2), tolerance = 1e-5)
  same(fitted(own, level = 1), fitted(nested, level = 1))
  expect_equal(predict(own, stands[1:60, ], level = 0:2), predict(nested, stands[1:60, ], level = 0:2), tolerance = 1e-5)
  expect_equal(ACF(own), ACF(nested), tolerance = 1e-3)
  expect_equal(coef(own, level = 1), coef(nested, level = 1), tolerance = 1e-5)
  same(ranef(own), ranef(nested), 1e-3)
  expect_equal(dim(attr(ranef(own, condVar = TRUE)$plot, "postVar")), c(2L, 2L, 32L))
  expect_equal(attr(ranef(own, se = TRUE, level = 1), "se")$a, sqrt(attr(ranef(own, condVar = TRUE)$stand, "postVar")[1, 1, ]), check.attributes = FALSE)
  same(augPred(own, ~ dbh, level = 0:2, length.out = 5), augPred(nested, ~ dbh, level = 0:2, length.out = 5), 1e-4)

  # Rows with missing values
  holes <- transform(stands, h = replace(h, c(3, 50), NA))
  excluded <- silvafit(h ~ 1.3 + a * (1 - exp(-b * dbh)), holes, random = a ~ 1 | plot, na.action = na.exclude)
  expect_equal(which(rowSums(is.na(resid(excluded, level = 0:1))) == 2), c("3" = 3L, "50" = 50L))
  expect_equal(nrow(getData(excluded)), 912L)
  expect_true(inherits(plot(excluded, resid(.) ~ fitted(.) | species), "trellis"))

  # Single-term deletions are likelihood-ratio tests of refits.
  whole <- silvafit(h ~ 1.3 + a * (1 - exp(-b * dbh)), stands, fixed = list(a ~ species * crowding, b ~ crowding), random = a ~ 1 | plot)
  smaller <- update(whole, fixed = list(a ~ species + crowding, b ~ crowding))
  dropped <- drop1(whole)
  expect_equal(rownames(dropped), c("<none>", "a:species:crowding", "b:crowding"))
  expect_equal(dropped["a:species:crowding", "LRT"], 2 * as.numeric(logLik(whole) - logLik(smaller)), tolerance = 1e-6)
  expect_equal(dropped$AIC[1:2], c(AIC(whole), AIC(smaller)), tolerance = 1e-9)
  expect_error(drop1(update(whole, method = "REML")), "method = \"ML\"", class = "silvafit_usage_error")
}

# Without random effects: gnls(), whose sigma has N - p in the place of N
logistic <- weight ~ Asym / (1 + exp((xmid - Time) / scal))
# Some methods of nlme evaluate the call again, in another environment.
least <- do.call(gnls, list(logistic, data = Soybean, start = c(Asym = 19, xmid = 55, scal = 8), weights = varPower(),
                            control = gnlsControl(tolerance = 1e-8, nlsTol = 1e-5, msTol = 1e-10)))
own <- silvafit(model = logistic, data = Soybean, params = Asym + xmid + scal ~ 1, start = c(19, 55, 8), weights = varPower())
expect_equal(ACF(own, form = ~ 1 | Plot), ACF(least, form = ~ 1 | Plot), tolerance = 1e-3)
same(augPred(own)$weight, augPred(least)$weight, 1e-4)
expect_null(getGroups(own))
expect_error(pairs(own), "no random effects", class = "silvafit_usage_error")

# A list of formulas without groups is one correlated term, as in nlme; formulas with groups of their own are independent.
joint <- nlme(logistic, data = Soybean, fixed = Asym + xmid + scal ~ 1, random = list(Asym ~ 1, xmid ~ 1), groups = ~ Plot, start = c(19, 55, 8), control = tight)
own <- silvafit(logistic, data = Soybean, random = list(Asym ~ 1, xmid ~ 1), groups = ~ Plot)
expect_equal(as.numeric(logLik(own)), as.numeric(logLik(joint)), tolerance = 1e-6)
expect_equal(as.vector(VarCorr(own)$Plot), as.vector(getVarCov(own)))
expect_equal(attr(VarCorr(own)$Plot, "correlation")[1, 2], as.numeric(VarCorr(joint)["xmid", "Corr"]), tolerance = 5e-3)
expect_equal(VarCorr(own)[, "StdDev"], sapply(VarCorr(joint)[, "StdDev"], as.numeric), tolerance = 5e-3)

# weights, method, nAGQ and REML are variance, reml and agq_points.
powered <- silvafit(logistic, data = Soybean, random = Asym ~ 1 | Plot, weights = varPower())
expect_equal(logLik(powered), logLik(silvafit(logistic, data = Soybean, random = Asym ~ 1 | Plot, variance = "power")))
restricted <- update(powered, method = "REML")
line <- gls(distance ~ age, data = Orthodont)
expect_equal(as.numeric(logLik(silvafit(distance ~ a + b * age, data = Orthodont, method = "REML"))), as.numeric(logLik(line)), tolerance = 1e-8)
expect_equal(logLik(restricted), logLik(update(powered, reml = TRUE)))
expect_equal(logLik(restricted), logLik(update(powered, REML = TRUE)))
expect_equal(logLik(update(restricted, method = "ML")), logLik(powered), tolerance = 1e-8)
expect_equal(update(powered, nAGQ = 1, weights = NULL)$fit$method, "laplace")
expect_equal(update(update(powered, nAGQ = 1, weights = NULL), nAGQ = 3)$fit$agq_points, 3)
expect_equal(update(powered, control = list(maxIter = 50))$call$max_iterations, 50)
says <- function(call, text) expect_true(grepl(text, message_of_error(call), fixed = TRUE), info = text)
says(silvafit(logistic, Soybean, randm = Asym ~ 1), "did you mean 'random'?")
says(silvafit(logistic, Soybean, method = "laplace", nAGQ = 2), "give either `method` or `nAGQ`")
says(silvafit(logistic, Soybean, weigths = varPower()), "did you mean 'weights'?")
says(silvafit(logistic, Soybean, weights = varPower(), variance = "power"), "give either `variance` or `weights`")
says(silvafit(logistic, Soybean, fixed = c(Asym = 19)), "use hold = c(")
says(silvafit(logistic, Soybean, correlation = corAR1(0.3, fixed = TRUE)), "fixed = TRUE is not available")
says(silvafit(logistic, Soybean, correlation = varPower()), "an object of nlme: corAR1")
says(silvafit(logistic, Soybean, control = list(maxIt = 5)), "did you mean 'maxIter'?")
says(silvafit(fixed = weight ~ Time, data = Soybean, random = ~ 1 | Plot), "`formula` is missing")
gap <- transform(Soybean[1:3, ], Time = c(NA, 20, 30))
says(predict(powered, gap, na.action = na.fail), "no prediction because of missing values")
expect_equal(names(predict(powered, gap, na.action = na.omit)), rownames(Soybean)[2:3])
says(update(powered, weigths = NULL), "did you mean 'weights'?")
says(ACF(ours, maxlag = 3), "did you mean 'maxLag'?")
says(augPred(ours, levle = 1), "did you mean 'level'?")
says(plot(ours, resid(.) ~ fitted(.), gird = TRUE), "did you mean 'grid'?")
says(comparePred(ours, theirs), "`object2` has to be a fit of silvafit()")
says(anova(ours, Terms = "age"), "unknown term 'age'; available: Asym, R0, lrc")

# update() of fits that were made where their variables are no longer.
make <- function(trees, limit, model) silvafit(asymptotic, data = trees, random = model, subset = age > limit)
made <- make(Loblolly, 4, Asym ~ 1 | Seed)
expect_equal(made$call$subset, quote(age > 4))
direct <- silvafit(asymptotic, data = Loblolly, random = Asym ~ 1 | Seed, weights = varPower(), subset = age > 4)
expect_equal(logLik(update(made, weights = varPower())), logLik(direct))
through <- function(fit, ...) update(fit, ...)
forwarded <- function(...) silvafit(asymptotic, data = Loblolly, ...)
expect_equal(as.list(forwarded(random = Asym ~ 1, weights = varPower(), subset = age > 4)$call)[c("random", "variance", "subset")],
             list(random = quote(Asym ~ 1), variance = quote(varPower()), subset = quote(age > 4)))
expect_equal(nobs(forwarded(subset = age > 4)), nobs(made))
least_age <- 9
expect_equal(nobs(through(made, subset = age > least_age)), sum(Loblolly$age > 9))
expect_equal(nobs(update(made, subset = NULL)), 84L)
expect_equal(nobs(update(made, data = Loblolly[1:42, ])), sum(Loblolly$age[1:42] > 4))
changed <- as.data.frame(Loblolly)
one <- silvafit(asymptotic, data = changed, random = Asym ~ 1 | Seed)
changed$half <- changed$age / 2
expect_equal(names(fixef(update(one, fixed = lrc ~ half))), c("Asym", "R0", "lrc", "lrc:half"))
changed$height <- 2 * changed$height
expect_message(expect_equal(logLik(update(one, starts = 1)), logLik(one), tolerance = 1e-8), "no longer the data of the fit", class = "silvafit_note")
expect_equal(update(one, log(.) ~ ., evaluate = FALSE)$formula, log(height) ~ SSasymp(age, Asym, R0, lrc))
expect_equal(unname(fixef(update(one, data = changed))["Asym"]), 2 * unname(fixef(one)["Asym"]), tolerance = 1e-5)
