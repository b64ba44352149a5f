# SPDX-License-Identifier: MIT
# Arguments that contradict each other or would have no effect are refused; what a call assumes is said.
source("helpers.R", local = TRUE)
quietly <- function(expression) suppressMessages(expression)
children <- as.data.frame(nlme::Orthodont)
line <- function(...) silvafit(distance ~ a + b * age, children, ...)
refused <- function(expression) expect_true(class_of_error(expression) %in% c("silvafit_usage_error", "silvafit_input_error", "silvafit_formula_error"), info = deparse1(substitute(expression)))
by_child <- line(random = a ~ 1 | Subject, parameters = a ~ Sex)

# Contradictions
refused(line(random = list(Subject = nlme::pdDiag(a + b ~ 1)), covariance = "general"))
refused(line(random = list(a ~ 1 | Subject, b ~ 1 | Subject), covariance = "general"))
refused(line(random = a ~ 1 | Subject, method = "REML", reml = FALSE))
refused(line(random = a ~ 1 | Subject, method = "ML", REML = TRUE))
refused(line(random = a ~ 1 | Subject, nAGQ = 3, agq_points = 5))
refused(line(random = a ~ 1 | Subject, max_iterations = 9, control = nlme::nlmeControl(maxIter = 10)))
expect_equal(logLik(line(random = a ~ 1 | Subject, method = "ML", REML = FALSE)), logLik(line(random = a ~ 1 | Subject)))
expect_equal(logLik(line(random = list(Subject = nlme::pdDiag(a + b ~ 1)), covariance = "diagonal")), logLik(line(random = list(a ~ 1 | Subject, b ~ 1 | Subject))))

# Without effect
refused(line(parameters = a ~ Sex, contrasts = list(Sx = "contr.sum")))
refused(line(parameters = a ~ Sex, contrasts = list(age = "contr.sum")))
refused(line(control = list(5)))
refused(line(groups = ~ Subject))
refused(line(random = a ~ 1, groups = age ~ Subject))
refused(line(random = a ~ 1 | Subject, groups = ~ Sex))
refused(predict(by_child, coverage = 0.9))
refused(predict(by_child, seen_groups = "new"))
refused(predict(by_child, level = "population", new_groups = "error"))
refused(grow_trees(children, tempfile(fileext = ".glb"), seconds = 2))
refused(grow_trees(children, tempfile(fileext = ".glb"), models = 3))
refused(add1(by_child, ~ . + age))
refused(line(parameters = a ~ 0))
expect_null(summary(line())$VarCorr)
expect_equal(quietly(logLik(line(random = a ~ 1, groups = ~ Subject))), logLik(line(random = a ~ 1 | Subject)))

# One variance for all levels of a factor is a grouping, and the message is the call: nlme's fit has the same likelihood.
assay <- as.data.frame(nlme::Assay)
blocks <- nlme::pdBlocked(list(nlme::pdIdent(A ~ 1), nlme::pdIdent(A ~ sample - 1), nlme::pdIdent(A ~ dilut - 1)))
remedy <- message_of_error(silvafit(logDens ~ A, assay, parameters = A ~ sample * dilut, random = list(Block = blocks)))
expect_true(nchar(remedy) < 250)
ours <- silvafit(logDens ~ A, assay, parameters = A ~ sample * dilut, random = sub(".*random = \"(.*)\"", "\\1", remedy))
theirs <- nlme::lme(logDens ~ sample * dilut, nlme::Assay, method = "ML",
                    random = nlme::pdBlocked(list(nlme::pdIdent(~ 1), nlme::pdIdent(~ sample - 1), nlme::pdIdent(~ dilut - 1))))
expect_equal(as.numeric(logLik(ours)), as.numeric(logLik(theirs)), tolerance = 1e-7)

# Terms are those of the formula, whatever the contrasts are
if (requireNamespace("lme4", quietly = TRUE)) {
  cake <- transform(lme4::cake, tray = recipe:replicate)
  by_terms <- anova(silvafit(angle ~ a, cake, parameters = a ~ recipe * temperature, random = a ~ 1 | tray))
  expected <- anova(nlme::lme(angle ~ recipe * temperature, cake, random = ~ 1 | tray, method = "ML"))
  expect_equal(row.names(by_terms), c("a", "a:recipe", "a:temperature", "a:recipe:temperature"))
  expect_equal(by_terms$numDF, expected$numDF)
  expect_equal(by_terms$`F-value`, expected$`F-value`, tolerance = 1e-5)
}

# Groups of a correlation, as in nlme
ovaries <- as.data.frame(nlme::Ovary)
ovaries$g <- factor(rep(1:4, length.out = nrow(ovaries)))
waves <- function(form) silvafit(follicles ~ A + B * sin(2 * pi * Time) + C * cos(2 * pi * Time), ovaries, random = A ~ 1 | Mare, correlation = nlme::corAR1(form = form))
theirs <- function(form) nlme::lme(follicles ~ sin(2 * pi * Time) + cos(2 * pi * Time), ovaries, random = ~ 1 | Mare, correlation = nlme::corAR1(form = form), method = "ML")
refused(waves(~ 1 | g))
expect_error(theirs(~ 1 | g))
expect_equal(as.numeric(logLik(waves(~ 1 | Mare/g))), as.numeric(logLik(theirs(~ 1 | Mare/g))), tolerance = 1e-7)

# Predictions of unknown levels and groups
expect_message(unknown <- predict(by_child, data.frame(Subject = "M01", age = 8, Sex = c("male", "Male"))), "male")
expect_equal(is.na(unknown), c("1" = TRUE, "2" = FALSE))
oats <- as.data.frame(nlme::Oats)
nested <- silvafit(yield ~ a, oats, random = a ~ 1 | Block/Variety)
new <- data.frame(Block = c("ZZ", "II"), Variety = "Victory")
expect_message(predict(nested, new, level = 1), "Block ZZ")
by_nlme <- nlme::lme(yield ~ 1, oats, random = ~ 1 | Block/Variety, method = "ML")
expect_equal(unname(predict(nested, new, level = 1, new_groups = "missing")), as.vector(predict(by_nlme, new, level = 1)), tolerance = 1e-6)
refused(predict(nested, new, level = 1, new_groups = "error"))
expect_message(predict(by_child, data.frame(Subject = c("ZZ", "M01"), age = 8, Sex = "Male", distance = NA_real_), level = "calibrated"), "Subject ZZ")
by_sex <- line(random = a ~ 1 | Subject, weights = nlme::varIdent(form = ~ 1 | Sex))
expect_true(grepl("Sex", message_of_error(predict(by_sex, data.frame(Subject = "M01", age = 8), interval = "prediction"))))
expect_silent(predict(by_sex, data.frame(Subject = "M01", age = 8)))

# Random numbers are those of R
set.seed(1)
first <- bootstrap(by_child, 10, threads = 1, progress = FALSE)$values
second <- bootstrap(by_child, 10, threads = 1, progress = FALSE)$values
set.seed(1)
expect_identical(bootstrap(by_child, 10, threads = 1, progress = FALSE)$values, first)
expect_false(identical(first, second))
gaps <- transform(children, h = distance, dbh = age, plot = Subject)
gaps$h[seq(1, 108, 3)] <- NA
filled <- function(...) impute(gaps, "h", formula = h ~ a + b * dbh, add_residual = TRUE, trust_units = TRUE, ...)$h
set.seed(1)
expect_message(first <- filled(), "drawn residuals")
second <- quietly(filled())
set.seed(1)
expect_identical(quietly(filled()), first)
expect_false(identical(first, second))

# What a fit assumes is said at the call
expect_message(silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), Loblolly, random = Asym ~ 1 | Seed, control = nlme::nlmeControl(maxIter = 1)), "Fitted by focei")
set.seed(1)
zeros <- data.frame(x = rep(0:9, 6))
zeros$y <- 2 + 3 * zeros$x + rnorm(60) * (0.5 + zeros$x)
# As gls(), which ends with an error, too.
expect_error(silvafit(y ~ a + b * x, zeros, variance = nlme::varPower(form = ~ x)), "variance 0")

# Generics
refused(nlme::getVarCov(nested))
expect_equal(as.vector(nlme::getVarCov(nested, level = "Block")), as.numeric(nlme::VarCorr(by_nlme)["(Intercept)", "Variance"][1]), tolerance = 1e-5)
expect_equal(deviance(line()), deviance(lm(distance ~ age, children)), tolerance = 1e-9)
restricted <- line(random = a ~ 1 | Subject, parameters = list(a ~ Sex, b ~ Sex), method = "REML")
expect_equal(BIC(restricted), BIC(nlme::lme(distance ~ Sex * age, children, random = ~ 1 | Subject)), tolerance = 1e-8)
expect_equal(BIC(line(method = "REML")), BIC(nlme::gls(distance ~ age, children)), tolerance = 1e-9)
if (requireNamespace("lmtest", quietly = TRUE)) {
  refused(lmtest::lrtest(update(restricted, parameters = NULL), restricted))
  larger <- update(restricted, method = "ML")
  expect_equal(lmtest::lrtest(update(larger, parameters = NULL), larger)$Chisq[2], anova(update(larger, parameters = NULL), larger)$L.Ratio[2], tolerance = 1e-9)
}
if (requireNamespace("emmeans", quietly = TRUE)) {
  ours <- line(random = a ~ 1 | Subject, parameters = list(a ~ Sex, b ~ Sex))
  linear <- nlme::lme(distance ~ Sex * age, children, random = ~ 1 | Subject, method = "ML")
  contrast <- function(means) as.data.frame(graphics::pairs(means))[c("estimate", "SE", "df")]
  expect_equal(quietly(contrast(emmeans::emmeans(ours, ~ Sex, param = "a"))), quietly(contrast(emmeans::emmeans(linear, ~ Sex, at = list(age = 0), mode = "containment"))), tolerance = 1e-4)
  slopes <- quietly(as.data.frame(emmeans::emmeans(ours, ~ Sex, param = "b")))
  expect_equal(slopes$df, quietly(as.data.frame(emmeans::emtrends(linear, ~ Sex, var = "age", mode = "containment")))$df)
}

# Dates
set.seed(3)
trees <- data.frame(plot = as.Date("2020-01-01") + rep(0:1, each = 20), tree = rep(1:20, 2), dbh = runif(40, 10, 40))
expect_equal(quietly(stand_summary(trees, plot_area = 400))$plots$plot, c("2020-01-01", "2020-01-02"))
twice <- rbind(transform(trees, date = as.Date("2010-05-03")), transform(trees, date = as.Date("2015-06-01"), dbh = dbh * 1.1))
grown <- quietly(stand_growth(twice, plot_area = 400))$growth_plots
expect_equal(grown$years[1], as.numeric(as.Date("2015-06-01") - as.Date("2010-05-03")) / 365.2425, tolerance = 1e-4)
expect_equal(quietly(stand_growth(transform(twice, date = as.POSIXct(date)), plot_area = 400))$growth_plots$years, grown$years, tolerance = 1e-4)

# Heights of one species in feet among others in m
species_of <- function(factor) {
  d <- data.frame(species = rep(c("oak", "fir"), each = 20), dbh = seq(20, 30, length.out = 20), h = seq(18, 24, length.out = 20) + sin(1:40))
  d$h[1:20] <- factor * d$h[1:20]
  silvafit(h ~ a + b * dbh, d)
}
expect_message(species_of(1 / 0.3048), "of species oak, unlike others, h has the median")
expect_silent(species_of(1))
