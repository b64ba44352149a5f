# SPDX-License-Identifier: MIT
# Formulas, factors, missing values, classes of data, and wrong input.
source("helpers.R", local = TRUE)
curve <- height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age)
fit <- silvafit(curve, data = Loblolly, random = Asym ~ 1 | Seed)

# Random effects in the ways of nlme and in text
same <- function(...) expect_equal(as.numeric(logLik(silvafit(curve, data = Loblolly, ...))), as.numeric(logLik(fit)), tolerance = 1e-12)
same(random = Asym ~ 1, groups = ~ Seed)
same(random = list(Seed = Asym ~ 1))
same(random = "Asym | Seed")
same(random = nlme::pdDiag(Asym ~ 1), groups = ~ Seed)
same(random = Asym ~ 1 | Seed, parameters = Asym + R0 + lrc ~ 1)
two <- silvafit(curve, data = Loblolly, random = list(Asym ~ 1 | Seed, R0 ~ 1 | Seed))
expect_equal(VarCorr(two)$Seed[1, 2], 0)
expect_equal(as.numeric(logLik(two)), as.numeric(logLik(silvafit(curve, data = Loblolly, random = Asym + R0 ~ 1 | Seed, covariance = "diagonal"))), tolerance = 1e-9)

# Contrasts: other columns, the same model. Asym of a level is the same by all of them.
set.seed(4)
trees <- data.frame(plot = rep(letters[1:10], each = 24), species = factor(rep(c("SM", "OF", "BHN"), 80), levels = c("SM", "OF", "BHN", "none")), dbh = runif(240, 5, 45))
trees$h <- with(trees, 1.3 + (20 + 2 * (species == "OF") - 3 * (species == "BHN") + rnorm(10)[factor(plot)]) * (1 - exp(-0.07 * dbh))) + rnorm(240, sd = 0.8)
height <- h ~ 1.3 + a * (1 - exp(-b * dbh))
treatment <- silvafit(height, data = trees, parameters = a ~ species, random = a ~ 1 | plot)
expect_equal(names(fixef(treatment)), c("a", "a:speciesOF", "a:speciesBHN", "b"))  # the unused level has no column
sums <- silvafit(height, data = trees, parameters = a ~ species, random = a ~ 1 | plot, contrasts = list(species = "contr.sum"))
means <- silvafit(height, data = trees, parameters = a ~ species - 1, random = "a:(species == \"SM\") | plot")
expect_equal(as.numeric(logLik(sums)), as.numeric(logLik(treatment)), tolerance = 1e-8)
expect_equal(names(fixef(sums)), c("a", "a:species1", "a:species2", "b"))
expect_equal(unname(fixef(sums)["a"]), unname(fixef(treatment)["a"] + sum(fixef(treatment)[2:3]) / 3), tolerance = 1e-6)
trees$class <- cut(trees$dbh, c(0, 15, 30, 50), ordered_result = TRUE)
ordered <- silvafit(h ~ a, data = trees, parameters = a ~ class)
expect_equal(names(fixef(ordered)), c("a", "a:class.L", "a:class.Q"))
expect_true(relative(fixef(ordered), coef(lm(h ~ class, data = trees))) < 1e-8)
# Interactions have the columns of model.matrix()
crossed <- silvafit(height, data = trees, parameters = a ~ species * I(dbh / 10))
expect_equal(names(fixef(crossed))[1:6], sub("a:\\(Intercept\\)", "a", paste0("a:", colnames(model.matrix(~ species * I(dbh / 10), droplevels(trees))))))
linear <- lm(h ~ species * I(dbh / 10), data = trees)
expect_true(relative(fixef(silvafit(h ~ a, data = trees, parameters = a ~ species * I(dbh / 10))), coef(linear)) < 1e-8)
# Offsets, and a response that is an expression
expect_true(relative(fixef(silvafit(h ~ a, data = trees, parameters = a ~ dbh + offset(dbh / 2))), coef(lm(h ~ dbh + offset(dbh / 2), data = trees))) < 1e-8)
logarithmic <- silvafit(log(h) ~ a + b * log(dbh), data = trees)
expect_true(relative(fixef(logarithmic), coef(lm(log(h) ~ log(dbh), data = trees))) < 1e-8)
expect_equal(unname(predict(logarithmic, data.frame(dbh = 20))), unname(predict(lm(log(h) ~ log(dbh), data = trees), data.frame(dbh = 20))), tolerance = 1e-8)

# Missing values
holes <- trees
holes$h[c(3, 50)] <- NA
holes$dbh[7] <- NA
omitted <- silvafit(height, data = holes, random = a ~ 1 | plot)
expect_equal(nobs(omitted), 237L)
expect_equal(unname(unclass(omitted$na.action)[1:3]), c(3L, 7L, 50L))
expect_equal(length(fitted(omitted)), 237L)
excluded <- silvafit(height, data = holes, random = a ~ 1 | plot, na.action = na.exclude)
expect_equal(which(is.na(residuals(excluded))), c("3" = 3L, "7" = 7L, "50" = 50L))
expect_true(grepl("'h' has missing values", message_of_error(silvafit(height, data = holes, na.action = na.fail))))
expect_equal(logLik(silvafit(height, data = trees, random = a ~ 1 | plot, subset = species == "SM")),
             logLik(silvafit(height, data = trees[trees$species == "SM", ], random = a ~ 1 | plot)))

# Classes of data frames
if (requireNamespace("tibble", quietly = TRUE)) {
  expect_equal(fixef(silvafit(height, data = tibble::as_tibble(trees), parameters = a ~ species)), fixef(silvafit(height, data = trees, parameters = a ~ species)))
} else skipped("tibble is not installed")
if (requireNamespace("sf", quietly = TRUE)) {
  points <- sf::st_as_sf(cbind(trees, x = runif(240, 0, 50), y = runif(240, 0, 50)), coords = c("x", "y"))
  expect_equal(fixef(silvafit(height, data = points)), fixef(silvafit(height, data = trees)))
} else skipped("sf is not installed")

# A fit in a new session
file <- tempfile(fileext = ".rds")
saveRDS(treatment, file)
again <- readRDS(file)
expect_equal(predict(again, trees[1:3, ], level = "calibrated", interval = "prediction"), predict(treatment, trees[1:3, ], level = "calibrated", interval = "prediction"))
script <- sprintf("library(silvafit); fit <- readRDS('%s'); cat(format(sum(predict(fit)), digits = 15), format(sum(predict(fit, fit$frame, level = 'population')), digits = 15))", file)
output <- system2(file.path(R.home("bin"), "Rscript"), c("-e", shQuote(script)), stdout = TRUE, env = paste0("R_LIBS=", paste(.libPaths(), collapse = ":")))
expect_equal(as.numeric(strsplit(output, " ")[[1]]), c(sum(predict(treatment)), sum(predict(treatment, level = "population"))), tolerance = 1e-12)

# Wrong input
expect_equal(class_of_error(silvafit(h ~ a + gamma(b * dbh), data = trees)), "silvafit_formula_error")
expect_true(grepl("unknown function 'gamma()'", message_of_error(silvafit(h ~ a + gamma(b * dbh), data = trees)), fixed = TRUE))
expect_true(grepl("unknown function 'poly()'", message_of_error(silvafit(height, data = trees, parameters = a ~ poly(dbh, 2))), fixed = TRUE))
expect_true(grepl("unknown column 'H'", message_of_error(silvafit(H ~ a * dbh, data = trees))))
expect_true(grepl("unknown column 'site'", message_of_error(silvafit(height, data = trees, parameters = a ~ site))))
expect_true(grepl("unknown column 'stand'", message_of_error(silvafit(height, data = trees, random = a ~ 1 | stand))))
expect_equal(class_of_error(silvafit(height, data = trees, random = q ~ 1 | plot)), "silvafit_formula_error")
expect_equal(class_of_error(silvafit(height, data = trees, method = "magic")), "silvafit_usage_error")
expect_equal(class_of_error(silvafit(height, data = trees, random = a ~ 1)), "silvafit_usage_error")
expect_equal(class_of_error(silvafit(height, data = trees[0, ])), "silvafit_input_error")
expect_equal(class_of_error(silvafit(species ~ a * dbh, data = trees)), "silvafit_input_error")
expect_equal(class_of_error(silvafit(height, data = as.list(trees))), "silvafit_usage_error")
expect_equal(class_of_error(silvafit(height, data = transform(trees, dbh = as.Date("2020-01-01") + dbh))), "silvafit_input_error")
expect_equal(class_of_error(silvafit(~ a * dbh, data = trees)), "silvafit_formula_error")
# The fit fails, so that the warning has it.
expect_warning(silvafit(h ~ 1.3 + a * (1 - exp(-b * dbhh)), data = trees), "did you mean the column dbh?", class = "silvafit_convergence_warning", fixed = TRUE)
expect_equal(names(fixef(silvafit(h ~ a * sqrt(dbh), data = trees))), "a")
years <- transform(trees, year = rep(1:4, 60))
crossed_lists <- list(list(a ~ 1 | plot, b ~ 1 | year), list(plot = a ~ 1, year = b ~ 1))
for (random in crossed_lists) {
  expect_equal(class_of_error(silvafit(height, data = years, random = random)), "silvafit_formula_error")
  expect_true(grepl("`a | plot; b | plot/year`", message_of_error(silvafit(height, data = years, random = random)), fixed = TRUE))
}
expect_equal(names(ranef(silvafit(height, data = years, random = list(a ~ 1 | plot, a ~ 1 | plot/year)))), c("plot", "year"))
# Crossed groups: the same model as a formula, as a text, and as terms of lme4.
by_both <- silvafit(height, data = years, random = a ~ 1 | plot + year)
expect_equal(lengths(lapply(ranef(by_both), row.names)), c(plot = length(unique(years$plot)), year = 4L))
expect_equal(logLik(silvafit(height, data = years, random = "(a | plot) + (a | year)")), logLik(by_both))
expect_equal(nlme::getGroupsFormula(by_both), ~ plot + year, check.attributes = FALSE)
expect_equal(coef(by_both)$year$a, fixef(by_both)[["a"]] + ranef(by_both)$year$a)
expect_equal(as.vector(predict(by_both, years)), as.vector(fitted(by_both)), tolerance = 1e-10)
expect_equal(as.vector(predict(by_both, years, level = 0)), as.vector(fitted(by_both, level = "population")), tolerance = 1e-10)
# The effects of the groups of the fit, from their trees as if they were new.
expect_equal(as.vector(predict(by_both, years, level = "calibrated", seen_groups = "new")), as.vector(fitted(by_both)), tolerance = 1e-6)
linear <- silvafit(h ~ a + b * dbh + (1 | plot) + (1 | year), data = years)
expect_equal(sort(names(ranef(linear))), c("plot", "year"))
broken <- tempfile(fileext = ".json")
writeLines("{bad", broken)
expect_true(grepl(basename(broken), message_of_error(read_fit(broken)), fixed = TRUE))
# One group, groups without differences, and rows that do not determine the parameters: the reason is said
expect_error(silvafit(height, data = trees[trees$plot == "a", ], random = a ~ 1 | plot), pattern = "all 24 rows are in the group", class = "silvafit_input_error")
alike <- transform(trees[trees$plot == "a", ], plot = rep(c("u", "v"), 12))
expect_warning(silvafit(height, data = trees[c(1, 1), ]), class = "silvafit_convergence_warning")
expect_message(silvafit(height, data = alike, random = a ~ 1 | plot), class = "silvafit_boundary_message")

# Terms of lme4 in the formula are the random effects of the parameters whose derivatives they are.
by_bar <- silvafit(height ~ a + b * log(age) + (1 | Seed), data = Loblolly)
by_argument <- silvafit(height ~ a + b * log(age), data = Loblolly, random = a ~ 1 | Seed)
expect_equal(logLik(by_bar), logLik(by_argument))
expect_equal(ranef(by_bar), ranef(by_argument))
expect_equal(predict(by_bar, Loblolly[1:3, ]), predict(by_argument, Loblolly[1:3, ]))
bars_message <- function(call) tryCatch({ force(call); "" }, silvafit_error = function(e) conditionMessage(e))
for (wrong in list(list(height ~ age + (1 | Seed), "height ~ b0 + b1*age with random = \"b0 | Seed\""),
                   list(height ~ age, "height ~ b0 + b1*age"),
                   list(height ~ a + b * age | Seed, "random = \"a | plot\""),
                   list(height ~ a * (1 | Seed), "random = a ~ 1 | plot"),
                   list(height ~ SSlogis(age, Asym, xmid, scal) ~ Asym | Seed, "random = \"Asym | Seed\""),
                   list(height ~ a * (1 - exp(-b * age)) + (1 | Seed), "coefficients: a, b"))) {
  expect_true(grepl(wrong[[2]], bars_message(silvafit(wrong[[1]], data = Loblolly)), fixed = TRUE), info = wrong[[2]])
}
expect_true(grepl("random effects", bars_message(silvafit(height ~ a + b * age, data = Loblolly, parameters = a ~ 1 + (1 | Seed)))))
# A logical or of conditions stays what it is.
expect_equal(unname(fixef(silvafit(y ~ a + b * (x < 2 | x > 3), data = data.frame(x = 1:6, y = c(3, 1, 1.2, 3.1, 2.9, 3)))))[1], mean(c(1, 1.2)))

# Responses of other distributions are named first.
expect_message(silvafit(y ~ a + b * x, data = data.frame(x = 1:8, y = c(0, 1, 0, 0, 1, 1, 0, 1))), "has two values only (0 and 1)", fixed = TRUE)
