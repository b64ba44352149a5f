# SPDX-License-Identifier: MIT
# Arguments and data as users give them by mistake, and as other functions of R make them.
source("helpers.R", local = TRUE)
curve <- height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age)
trees <- as.data.frame(Loblolly)
trees$Seed <- as.character(trees$Seed)
fit <- silvafit(curve, data = trees, random = Asym ~ 1 | Seed)
line <- lm(height ~ age, trees)

# T and F are names like others, of columns and of parameters.
named <- silvafit(height ~ F + b * T, data = transform(trees, T = age))
expect_equal(unname(fixef(named)), unname(coef(line)), tolerance = 1e-7)
# scale() makes a matrix of one column.
scaled <- trees
scaled$age <- scale(trees$age)
expect_equal(unname(fixef(silvafit(height ~ a + b * age, data = scaled))), unname(coef(lm(height ~ scale(age), trees))), tolerance = 1e-7)
# An empty text is a missing value, in fits and in predictions, as text and as factor.
gaps <- transform(trees, Seed = ifelse(Seed == "301", "", Seed))
expected <- silvafit(curve, data = trees[trees$Seed != "301", ], random = Asym ~ 1 | Seed)
for (data in list(gaps, transform(gaps, Seed = factor(Seed)))) {
  without <- silvafit(curve, data = data, random = Asym ~ 1 | Seed)
  expect_equal(nobs(without), 78L)
  expect_equal(fixef(without), fixef(expected), tolerance = 1e-10)
  expect_equal(predict(without, data)[gaps$Seed != ""], fitted(without))
}

# A number of the caller is not data, as it is to nls(), and this is said; not if its coefficient was named otherwise.
told <- function(expression) tryCatch({ expression; "" }, silvafit_note = conditionMessage)
breast_height <- 1.3
with_number <- height ~ breast_height + b * age
expect_true(grepl("your object breast_height (1.3) is not used", told(silvafit(with_number, data = trees)), fixed = TRUE))
expect_equal(told(silvafit(with_number, data = trees, start = c(breast_height = 1, b = 1))), "")
expect_equal(told(silvafit(with_number, data = trees, random = breast_height ~ 1 | Seed)), "")

# Columns that cannot be used are named.
lists <- trees
lists$age <- as.list(trees$age)
expect_true(grepl("'age' is of class list", message_of_error(silvafit(curve, data = lists))))

# Arguments of a wrong type, size or range are named; none is ignored or rounded.
wrong <- function(expression, argument) {
  expect_equal(class_of_error(expression), "silvafit_usage_error", info = argument)
  expect_true(grepl(paste0("`", argument, "`"), message_of_error(expression), fixed = TRUE), info = argument)
}
wrong(silvafit(curve, data = trees, max_iterations = 1e10), "max_iterations")
wrong(silvafit(curve, data = trees, random = Asym ~ 1 | Seed, control = nlme::nlmeControl(sigma = 1)), "control")
wrong(silvafit(curve, data = trees, random = Asym ~ 1 | Seed, covariance = 1), "covariance")
wrong(silvafit(curve, data = trees, na.action = "skip"), "na.action")
wrong(silvafit(curve, data = trees, contrasts = "contr.sum"), "contrasts")
wrong(predict(fit, trees, interval = "prediction", coverage = c(0.5, 0.9)), "coverage")
wrong(predict(fit, trees, interval = "prediction", coverage = "wide"), "coverage")
wrong(predict(fit, trees, threads = -1), "threads")
wrong(predict(fit, trees, se.fit = NA), "se.fit")
wrong(predict(fit, trees, na.action = "skip"), "na.action")
wrong(simulate(fit, 1.5), "nsim")
wrong(simulate(fit, seed = "first"), "seed")
wrong(confint(fit, threads = -1), "threads")
wrong(anova(fit, type = "third"), "type")
wrong(read_fit(3), "file")
expect_true(grepl("available: Asym", message_of_error(confint(fit, 99))))
stand <- data.frame(plot = 1, tree = 1:6, species = "SM", x = c(0, 5, 9, 4, 2, 8), y = c(0, 1, 6, 9, 4, 3), dbh = 20:25, h = c(15:19, NA))
wrong(structural_units(stand, edge = "none", neighbors = 1.5), "neighbors")
wrong(structural_units(stand, edge = "none", neighbors = -1), "neighbors")
wrong(structural_units(stand, edge = "none", trust_units = NA), "trust_units")
wrong(structural_units(stand, per = 1), "per")
wrong(structural_units(stand, edge = "none", alpha = 181), "alpha")
expect_equal(tryCatch(structural_units(stand, edge = "none", alpha = 181), error = function(e) e$column), "alpha")
wrong(stand_summary(stand, class_width = 0, progress = FALSE), "class_width")
wrong(impute(stand, seed = "first"), "seed")
wrong(impute(stand, minimum_trees = "few"), "minimum_trees")

# Calibration is by measured numbers.
new <- data.frame(Seed = "new", age = c(5, 10), height = c("12", NA))
expect_true(grepl("height.*has text", message_of_error(predict(fit, new, level = "calibrated"))))
new$height <- c(Inf, NA)
expect_true(grepl("infinite", message_of_error(predict(fit, new, level = "calibrated"))))
new$height <- NA
expect_equal(attr(predict(fit, new, level = "calibrated"), "measured"), c(0L, 0L))
# Settings in messages of the libraries are arguments.
centimeters <- data.frame(plot = 1, tree = 1:60, species = "SM", x = 1:60 %% 9, y = 1:60 %% 7, dbh = 20 + 1:60 %% 5, h = 100 * (16 + 1:60 %% 5))
expect_true(grepl("use columns = c(h = \"h/100\"); if it is correct, use trust_units = TRUE", message_of_error(structural_units(centimeters, edge = "none")), fixed = TRUE))
