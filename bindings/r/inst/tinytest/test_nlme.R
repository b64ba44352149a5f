# SPDX-License-Identifier: MIT
# The same models by nlme in the same session. nlme stops near the fixed point of its two steps, so that its control is tight.
source("helpers.R", local = TRUE)
if (!requireNamespace("nlme", quietly = TRUE)) exit_file("nlme is not installed")
tight <- nlme::nlmeControl(tolerance = 1e-8, pnlsTol = 1e-6, msTol = 1e-10, maxIter = 200, msMaxIter = 200, pnlsMaxIter = 50)

# nlme prints its coefficients in the order of its start values.
agree <- function(ours, theirs, tolerance = 1e-4, newdata = NULL) {
  expect_true(convergence(ours)$converged)
  expect_true(relative(unname(fixef(ours)), unname(nlme::fixef(theirs))) < tolerance)
  expect_true(relative(sqrt(diag(vcov(ours))), summary(theirs)$tTable[, "Std.Error"]) < tolerance)
  expect_equal(as.numeric(logLik(ours)), as.numeric(logLik(theirs)), tolerance = 1e-6)
  expect_equal(attr(logLik(ours), "df"), attr(logLik(theirs), "df"))
  expect_equal(AIC(ours), AIC(theirs), tolerance = 1e-6)
  expect_equal(BIC(ours), BIC(theirs), tolerance = 1e-6)
  expect_equal(nobs(ours), nrow(theirs$groups))
  expect_true(relative(sigma(ours), theirs$sigma) < tolerance)
  effects <- nlme::ranef(theirs)
  own <- ranef(ours)[rownames(effects), , drop = FALSE]
  expect_true(relative(as.matrix(own), as.matrix(effects)) < 10 * tolerance)
  expect_true(relative(fitted(ours), fitted(theirs)) < tolerance)
  expect_true(relative(fitted(ours, level = 0), fitted(theirs, level = 0)) < tolerance)
  # Residuals are differences of nearly equal values: their errors are those of the fitted values.
  expect_true(max(abs(residuals(ours) - residuals(theirs))) < tolerance * max(abs(fitted(theirs))))
  expect_true(relative(residuals(ours, type = "pearson"), residuals(theirs, type = "pearson")) < 100 * tolerance)
  expect_equal(unname(summary(ours)$tTable[, "DF"]), unname(summary(theirs)$tTable[, "DF"]))
  expect_true(relative(as.matrix(coef(ours)[rownames(coef(theirs)), ]), as.matrix(coef(theirs))) < tolerance)
  if (!is.null(newdata)) {
    for (level in 0:1) expect_true(relative(predict(ours, newdata, level = level), predict(theirs, newdata, level = level)) < tolerance)
  }
}

# Loblolly, the example of ?nlme.
asymptotic <- nlme::nlme(height ~ SSasymp(age, Asym, R0, lrc), data = Loblolly, fixed = Asym + R0 + lrc ~ 1, random = Asym ~ 1,
                         start = c(Asym = 103, R0 = -8.5, lrc = -3.3), control = tight)
own <- silvafit(height ~ SSasymp(age, Asym, R0, lrc), data = Loblolly, random = Asym ~ 1 | Seed)
agree(own, asymptotic, newdata = Loblolly[seq(1, 84, 5), ])
# As formula instead of the self-starting model
formula_fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly, random = Asym ~ 1 | Seed)
expect_equal(logLik(formula_fit), logLik(own), tolerance = 1e-10)

# Orange
logistic <- nlme::nlme(circumference ~ SSlogis(age, Asym, xmid, scal), data = Orange, fixed = Asym + xmid + scal ~ 1, random = Asym ~ 1 | Tree,
                       start = c(Asym = 192, xmid = 728, scal = 348), control = tight)
own <- silvafit(circumference ~ SSlogis(age, Asym, xmid, scal), data = Orange, random = Asym ~ 1 | Tree)
agree(own, logistic, newdata = Orange[c(3, 17, 30), ])

# Soybean with a factor on one parameter, random effects with nlme's class, and a variance function object
Soybean <- nlme::Soybean
soybean <- nlme::nlme(weight ~ Asym / (1 + exp((xmid - Time) / scal)), data = Soybean,
                      fixed = list(Asym ~ Variety, xmid ~ 1, scal ~ 1), random = nlme::pdDiag(Asym + xmid ~ 1), groups = ~ Plot,
                      weights = nlme::varPower(), start = c(17, 4, 52, 7.5), control = tight)
own <- silvafit(weight ~ Asym / (1 + exp((xmid - Time) / scal)), data = Soybean, parameters = list(Asym ~ Variety),
                random = nlme::pdDiag(Asym + xmid ~ 1), groups = ~ Plot, variance = nlme::varPower())
expect_equal(names(fixef(own)), c("Asym", "Asym:VarietyP", "xmid", "scal"))
agree(own, soybean, tolerance = 3e-4)
expect_true(relative(own$fit$variance$delta, coef(soybean$modelStruct$varStruct, unconstrained = FALSE)) < 1e-4)
ours <- intervals(own)
theirs <- nlme::intervals(soybean)
expect_true(relative(ours$fixed, theirs$fixed) < 1e-3)
expect_true(relative(unlist(ours$sigma), unlist(theirs$sigma)) < 1e-2)

# Correlated residuals by nlme's classes
texts <- c("ar1" = "corAR1()", "ar1(Time)" = "corAR1(form = ~ Time | Mare)", "ar1(1 | Mare)" = "corAR1(form = ~ 1 | Mare)", "car1(Time)" = "corCAR1(form = ~ Time)",
           "arma(1, 2, Time)" = "corARMA(form = ~ Time, p = 1, q = 2)", "arma(0, 1, 1 | Mare)" = "corARMA(form = ~ 1 | Mare, q = 1)",
           "compound-symmetry" = "corCompSymm(form = ~ 1)", "symmetric" = "corSymm()", "exponential(x, y; nugget)" = "corExp(form = ~ x + y, nugget = TRUE)",
           "rational-quadratic(x, y)" = "corRatio(form = ~ x + y)")
for (text in names(texts)) {
  object <- eval(str2lang(texts[[text]]), list(), asNamespace("nlme"))
  groups <- if (text %in% c("ar1(Time)")) "Mare" else character()
  expect_equal(silvafit:::correlation_text(object, groups), text)
}
ovary <- nlme::lme(follicles ~ sin(2 * pi * Time) + cos(2 * pi * Time), data = nlme::Ovary, random = ~ 1, correlation = nlme::corAR1())
own <- silvafit(follicles ~ a + b * sin(2 * pi * Time) + c * cos(2 * pi * Time), data = nlme::Ovary, random = a ~ 1, correlation = nlme::corAR1(), reml = TRUE)
expect_equal(as.numeric(logLik(own)), as.numeric(logLik(ovary)), tolerance = 1e-7)
expect_equal(own$fit$correlation$parameters$phi, as.numeric(coef(ovary$modelStruct$corStruct, unconstrained = FALSE)), tolerance = 1e-4)
# The inverse factor of AR1 on nlme's Pearson residuals. nlme's own normalized residuals of these data mix two groups at 15 of their ends:
# the levels of Mare are not in the order of the rows.
pearson <- as.numeric(residuals(ovary, type = "pearson"))
phi <- as.numeric(coef(ovary$modelStruct$corStruct, unconstrained = FALSE))
before <- c(NA, pearson[-length(pearson)])
expected <- ifelse(duplicated(nlme::Ovary$Mare), (pearson - phi * before) / sqrt(1 - phi^2), pearson)
expect_equal(as.numeric(residuals(own, type = "normalized")), expected, tolerance = 1e-4)

# REML, without random effects: gnls
least <- nlme::gnls(weight ~ Asym / (1 + exp((xmid - Time) / scal)), data = Soybean, start = c(Asym = 19, xmid = 55, scal = 8),
                    weights = nlme::varPower(), control = nlme::gnlsControl(tolerance = 1e-8, nlsTol = 1e-5, msTol = 1e-10))
own <- silvafit(weight ~ Asym / (1 + exp((xmid - Time) / scal)), data = Soybean, variance = nlme::varPower())
expect_true(relative(coef(own), coef(least)) < 1e-4)
expect_equal(as.numeric(logLik(own)), as.numeric(logLik(least)), tolerance = 1e-6)
expect_true(relative(sqrt(diag(vcov(own))), sqrt(diag(vcov(least)))) < 1e-4)

# spati, heights of Scots pine, from the checkout
file <- reference("data-gpl", "spati.csv")
if (file == "") {
  skipped("spati needs the checkout")
} else {
  spati <- read.csv(file)
  spati <- spati[!is.na(spati$h) & spati$h > 1.3, ]
  # The likelihood has two maxima. From usual start values nlme ends at the lower one; from the random effects of the higher one it stays there.
  own <- silvafit(h ~ 1.3 + a * (1 - exp(-b * d / 10)), data = spati, random = a + b ~ 1 | plot)
  near <- function(start) nlme::nlme(h ~ 1.3 + a * (1 - exp(-b * d / 10)), data = spati, fixed = a + b ~ 1, random = a + b ~ 1 | plot, start = start, control = tight)
  expect_true(logLik(own) > logLik(near(c(a = 20, b = 0.7))) + 0.4)
  # From all digits nlme's step halving fails, because nothing is left to gain.
  higher <- near(list(fixed = signif(fixef(own), 6), random = signif(as.matrix(ranef(own)), 6)))
  agree(own, higher, newdata = spati[1:20, ])
}

# Plots in stands: all levels of prediction, and the sums of coefficients and random effects
file <- reference("data", "stands.csv")
if (file == "") {
  skipped("nested groups need the checkout")
} else {
  stands <- read.csv(file, stringsAsFactors = TRUE)
  nested <- nlme::nlme(h ~ 1.3 + a * (1 - exp(-b * dbh)), data = stands, fixed = a + b ~ 1, random = list(stand = a ~ 1, plot = a + b ~ 1),
                       start = c(a = 29, b = 0.047), control = tight)
  own <- silvafit(h ~ 1.3 + a * (1 - exp(-b * dbh)), data = stands, random = list(stand = a ~ 1, plot = a + b ~ 1))
  expect_equal(as.numeric(logLik(own)), as.numeric(logLik(nested)), tolerance = 1e-6)
  theirs <- predict(nested, stands, level = 0:2)
  ours <- predict(own, stands, level = 0:2)
  for (column in c("predict.fixed", "predict.stand", "predict.plot")) expect_true(relative(ours[[column]], theirs[[column]]) < 1e-4)
  expect_true(relative(as.matrix(coef(own)[rownames(coef(nested)), ]), as.matrix(coef(nested))) < 1e-4)
  expect_equal(names(ranef(own)), c("stand", "plot"))
  expect_equal(names(intervals(own)$reStruct), c("stand", "plot"))
  # Groups of the finer grouping have the names stand/plot.
  expect_equal(sort(rownames(ranef(own)$plot)), sort(rownames(nlme::ranef(nested, level = 2))))
  covariate <- nlme::nlme(h ~ 1.3 + a * (1 - exp(-b * dbh)), data = stands, fixed = list(a ~ species * crowding, b ~ 1), random = a ~ 1 | plot,
                          start = c(29, 0, 0, 0, 0.047), control = tight)
  own <- silvafit(h ~ 1.3 + a * (1 - exp(-b * dbh)), data = stands, parameters = a ~ species * crowding, random = a ~ 1 | plot)
  agree(own, covariate)
}

# Functions of the coefficients. R 4.2.2: vcov(lm(weight ~ group, PlantGrowth)).
plants <- transform(PlantGrowth, one = 1)
fit <- silvafit(weight ~ a * one, plants, parameters = a ~ group, derive = c(difference = "`a.grouptrt2` - `a.grouptrt1`"))
expect_equal(fit$fit$derived$difference$estimate, 0.865, tolerance = 1e-10)
expect_equal(fit$fit$derived$difference$se, 0.2787816084, tolerance = 1e-9)
limits <- 0.865 + 0.2787816084 * qt(0.975, 27) * c(-1, 1)
expect_equal(as.numeric(confint(fit, "difference")), limits, tolerance = 1e-9)
for (which in c("all", "fixed")) {
  expect_equal(intervals(fit, which = which)$derived["difference", ], c(lower = limits[1], est. = 0.865, upper = limits[2]), tolerance = 1e-9)
}
expect_null(intervals(fit, which = "var-cov")$derived)
expect_error(silvafit(weight ~ a * one, plants, derive = c(r = "aa/2")), "did you mean")
# Marginal means are those of the groups, whatever the contrasts.
for (contrast in c("contr.treatment", "contr.sum")) {
  found <- silvafit(weight ~ a * one, plants, parameters = a ~ group, contrasts = list(group = contrast), means = "group")$fit$derived
  expect_equal(names(found), paste0("a (group ", c("ctrl", "trt1", "trt2"), ")"))
  expect_equal(vapply(found, `[[`, 0, "estimate"), c(5.032, 4.661, 5.526), tolerance = 1e-12, check.attributes = FALSE)
  expect_equal(vapply(found, `[[`, 0, "se"), rep(stats::sigma(stats::lm(weight ~ group, plants)) / sqrt(10), 3), tolerance = 1e-9, check.attributes = FALSE)
}
expect_error(silvafit(weight ~ a * one, plants, means = "group"), "not a factor of a sub-model")
plants$half <- rep(c(TRUE, FALSE), 15)
expect_error(silvafit(weight ~ a * one, plants, parameters = a ~ group + half, means = "group"), "half is logical")
expect_error(silvafit(weight ~ a * one, plants, parameters = a ~ group + offset(one), means = "group"), "not available with offsets")
found <- silvafit(weight ~ a * one, plants, parameters = a ~ group, means = ~group)
expect_equal(nrow(drop1(found)), 2L)
saved <- tempfile()
fit_json(found, saved)
expect_equal(read_fit(saved)$fit$derived, found$fit$derived)
orthodont <- as.data.frame(nlme::Orthodont)
mixed <- silvafit(distance ~ a + b * age, orthodont, parameters = a ~ Sex, random = a ~ 1 | Subject, reml = TRUE, means = "Sex")
theirs <- as.data.frame(emmeans::emmeans(nlme::lme(distance ~ age + Sex, orthodont, random = ~ 1 | Subject), ~ Sex, at = list(age = 0)))
by_name <- theirs[match(c("Female", "Male"), theirs$Sex), ]
for (column in c("estimate", "se", "df")) {
  ours <- vapply(mixed$fit$derived, `[[`, 0, column)
  expect_equal(ours, by_name[[c(estimate = "emmean", se = "SE", df = "df")[column]]], tolerance = 1e-5, check.attributes = FALSE)
}
expect_equal(as.data.frame(emmeans::emmeans(mixed, ~ Sex, param = "a"))$df, theirs$df)

# A linear coefficient far below its standard error, as of an uncentred polynomial, is near zero; it
# is no limit of a curve.
orthodont <- as.data.frame(nlme::Orthodont)
expected <- nlme::lme(distance ~ age + I(age^2), orthodont, random = ~ 1 | Subject, method = "ML")
for (method in c("lb", "focei", "laplace")) {
  fit <- silvafit(distance ~ a + b * age + c * age^2, orthodont, random = a ~ 1 | Subject, method = method)
  expect_true(convergence(fit)$converged)
  expect_false(grepl("poorly|limit", convergence(fit)$message))
  expect_equal(as.numeric(logLik(fit)), as.numeric(logLik(expected)), tolerance = 1e-9)
  # The standard errors of lme's summary and of lb have the factor N / (N - p) of the variance.
  factor <- if (method == "lb") 108 / 105 else 1
  expect_equal(unname(sqrt(diag(vcov(fit)))), unname(sqrt(factor * diag(vcov(expected)))), tolerance = 1e-4)
}
# Calls without `random`: nlme() then has random effects of all coefficients of `fixed`
children <- nlme::Orthodont
expect_message(by_default <- silvafit(distance ~ a + b * age, children, fixed = a + b ~ 1, start = c(16, 0.6), method = "ML"), "as in nlme")
theirs <- nlme::nlme(distance ~ a + b * age, children, fixed = a + b ~ 1, start = c(16, 0.6), method = "ML")
expect_equal(as.numeric(logLik(by_default)), as.numeric(logLik(theirs)), tolerance = 1e-7)
expect_equal(as.numeric(logLik(suppressMessages(update(by_default, start = NULL)))), as.numeric(logLik(by_default)), tolerance = 1e-9)
expect_false(length(suppressMessages(silvafit(distance ~ a + b * age, children, fixed = a + b ~ 1, random = NULL))$fit$random) > 0)
plain <- as.data.frame(children)
expect_equal(class_of_error(silvafit(distance ~ a + b * age, plain, fixed = a + b ~ 1)), "silvafit_usage_error")
expect_true(grepl("order", message_of_error(silvafit(distance ~ a + b * age, plain, start = c(16, 0.6)))))

# A correlation is over columns, not over expressions of them; nested groups need labels of their own.
stems <- data.frame(site = rep(c("A", "B"), each = 12), tree = rep(rep(1:3, each = 4), 2), t = rep(1:4, 6), y = sin((1:24)^2))
of_time <- function(form) silvafit(y ~ a + b * t, stems, correlation = corCAR1(form = form))
expect_error(of_time(~ I(t / 10) | tree), "add a column to the data", class = "silvafit_formula_error")
expect_error(of_time(~ t | site / tree), "labels of tree recur", class = "silvafit_usage_error")
stems$own <- interaction(stems$site, stems$tree)
expect_equal(c(logLik(of_time(~ t | own))), c(logLik(nlme::gls(y ~ t, stems, correlation = nlme::corCAR1(form = ~ t | own), method = "ML"))), tolerance = 1e-6)
# Names with blanks, in the groups, the time and the variance.
spaced <- stats::setNames(stems, sub("^t$", "t years", sub("^own$", "own tree", names(stems))))
expect_equal(c(logLik(silvafit(y ~ a + b * `t years`, spaced, correlation = corCAR1(form = ~ `t years` | `own tree`)))), c(logLik(of_time(~ t | own))), tolerance = 1e-8)
expect_equal(c(logLik(silvafit(y ~ a + b * `t years`, spaced, random = a ~ 1 | `own tree`, variance = varPower(form = ~ `t years`)))),
             c(logLik(silvafit(y ~ a + b * t, stems, random = a ~ 1 | own, variance = varPower(form = ~ t)))), tolerance = 1e-8)
# Intervals of the correlation are those of gls, whose second derivatives are differences.
ovary <- as.data.frame(nlme::Ovary)
theirs <- nlme::gls(follicles ~ sin(2 * pi * Time) + cos(2 * pi * Time), ovary, correlation = nlme::corAR1(form = ~ 1 | Mare), method = "ML")
ours <- silvafit(follicles ~ a + b * sin(2 * pi * Time) + c * cos(2 * pi * Time), ovary, correlation = corAR1(form = ~ 1 | Mare))
expect_equal(as.numeric(intervals(ours)$corStruct), as.numeric(nlme::intervals(theirs)$corStruct), tolerance = 1e-3)

# Marginal means have the codings of the fit: contrasts of the factor, ordered and logical columns, and options that change later.
coded <- transform(as.data.frame(nlme::Orthodont), group = factor(rep(c("b", "a", "c"), 36)), old = age > 10)
coded$size <- factor(coded$group, levels = c("b", "a", "c"), ordered = TRUE)
stats::contrasts(coded$group) <- stats::contr.helmert(3)
before <- options(contrasts = c("contr.sum", "contr.poly"))
means_of <- function(fit, ...) suppressMessages(as.data.frame(emmeans::emmeans(fit, ...)))$emmean
for (column in c("group", "size", "old")) {
  terms <- stats::reformulate(c("age", column))
  by_lme <- eval(bquote(nlme::lme(.(stats::update(terms, distance ~ .)), coded, random = ~ 1 | Subject, method = "ML")))
  sub_model <- list(stats::as.formula(paste("a ~", column)))
  own <- silvafit(distance ~ a + b * age, coded, parameters = sub_model, random = a ~ 1 | Subject)
  expect_equal(unname(fixef(own)["b"]), unname(nlme::fixef(by_lme)["age"]), tolerance = 1e-6)
  theirs <- means_of(by_lme, stats::reformulate(column), at = list(age = 0))
  # Names of variables and options that have changed.
  sub_model <- list(a ~ Sex)
  options(contrasts = c("contr.treatment", "contr.poly"))
  expect_equal(means_of(own, stats::reformulate(column), param = "a"), theirs, tolerance = 1e-6)
  options(contrasts = c("contr.sum", "contr.poly"))
}
options(before)
