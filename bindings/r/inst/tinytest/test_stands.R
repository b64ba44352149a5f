# SPDX-License-Identifier: MIT
# Inventories: against figures that are computed here from their definitions.
source("helpers.R", local = TRUE)
set.seed(11)
trees <- data.frame(plot = "1", tree = 1:60, species = sample(c("SM", "OF"), 60, TRUE), x = runif(60, 0, 40), y = runif(60, 0, 40), dbh = runif(60, 8, 40))
trees$h <- 1.3 + 22 * (1 - exp(-0.06 * trees$dbh)) + rnorm(60, sd = 0.5)

units <- suppressMessages(structural_units(trees, edge = "none", trust_units = TRUE))
expect_equal(nrow(units), 60L)
distance <- as.matrix(dist(trees[c("x", "y")]))
nearest <- t(apply(distance, 1, function(row) order(row)[2:5]))
expect_equal(units$M, unname(vapply(1:60, function(i) mean(trees$species[nearest[i, ]] != trees$species[i]), 0)), tolerance = 1e-12)
expect_equal(sort(unique(units$U)), seq(0, 1, 0.25))
expect_equal(names(units)[1:7], names(trees))
# Rows in another order have the same values, and a row that cannot be used has none.
shuffled <- trees[sample(60), ]
again <- suppressMessages(structural_units(shuffled, edge = "none", trust_units = TRUE))
expect_equal(again$W, units$W[match(shuffled$tree, trees$tree)])
broken <- rbind(trees, data.frame(plot = "1", tree = 61, species = "SM", x = NA, y = 5, dbh = 12, h = NA))
expect_true(is.na(suppressMessages(structural_units(broken, edge = "none", trust_units = TRUE))$M[61]))
expect_equal(tryCatch(structural_units(trees, edge = "none", trust_units = TRUE), silvafit_note = function(m) "a note"), "a note")

# Round numbers are labels, and whole numbers of 64 bits (bit64's class over the bytes of doubles) are read.
numbered <- transform(trees, plot = 100000 + as.integer(factor(plot)))
figures_of <- function(data) suppressMessages(stand_summary(data, plot_area = 500))$plots
expect_equal(as.character(figures_of(numbered)$plot), as.character(sort(unique(numbered$plot))))
wide <- function(values) structure(readBin(writeBin(as.integer(rbind(values, 0L)), raw(), endian = "little"), "double", length(values), endian = "little"), class = "integer64")
expect_equal(figures_of(within(numbered, plot <- wide(plot))), figures_of(numbered))
expect_message(stand_summary(within(numbered, note <- I(as.list(plot))), plot_area = 500), "not read: note")

# Windows of sf and as a file are the same.
window <- tempfile(fileext = ".wkt")
writeLines("POLYGON ((0 0, 40 0, 40 40, 0 40, 0 0))", window)
from_file <- suppressMessages(structural_units(trees, window = window, per = "stand", trust_units = TRUE))
expect_true(any(from_file$core == 0) && any(from_file$core == 1))
if (requireNamespace("sf", quietly = TRUE)) {
  polygon <- sf::st_polygon(list(rbind(c(0, 0), c(40, 0), c(40, 40), c(0, 40), c(0, 0))))
  expect_equal(suppressMessages(structural_units(trees, window = sf::st_sfc(polygon), per = "stand", trust_units = TRUE))$core, from_file$core)
  points <- sf::st_as_sf(trees, coords = c("x", "y"))
  # Points are the positions, whatever other columns are called x and y.
  beside <- transform(points, x = trees$x / 0.3048, y = trees$y / 0.3048)
  expect_equal(suppressMessages(structural_units(sf::st_as_sf(beside), trust_units = TRUE))$C, suppressMessages(structural_units(trees, trust_units = TRUE))$C)
  expect_equal(suppressMessages(structural_units(points, edge = "none", trust_units = TRUE))$W, units$W)
} else skipped("sf is not installed")

# Stand figures: stems and basal area per ha
stand <- suppressMessages(stand_summary(trees, plot_area = 1600, edge = "none", trust_units = TRUE))
expect_true(all(c("plots", "species", "diameters") %in% names(stand)))
per_ha <- unlist(stand$plots[1, grepl("stems|trees_per_ha", names(stand$plots))])
expect_true(any(abs(per_ha - 375) < 1e-9))
basal <- unlist(stand$plots[1, grepl("basal", names(stand$plots))])
expect_true(any(abs(basal - sum(pi / 4 * (trees$dbh / 100)^2) / 0.16) < 1e-9))
expect_true(length(capture.output(print(stand))) > 5)

# Imputation keeps measured values
gaps <- trees
gaps$h[seq(2, 60, 2)] <- NA
filled <- suppressMessages(impute(gaps, "h", trust_units = TRUE, random = "none"))
# A file has the rows and texts that the program reads: semicolons, decimal commas, labels such as 001 and T.
labeled <- transform(gaps, plot = sprintf("%03d", as.integer(factor(plot))), species = "T")
file <- tempfile(fileext = ".csv")
utils::write.table(labeled, file, sep = ";", dec = ",", row.names = FALSE, na = "", quote = FALSE)
of_file <- suppressMessages(impute(file, "h", trust_units = TRUE, random = "none"))
of_frame <- suppressMessages(impute(labeled, "h", trust_units = TRUE, random = "none"))
expect_equal(transform(of_file[names(of_frame)], tree = as.numeric(tree)), of_frame, check.attributes = FALSE)
expect_equal(filled$h[seq(1, 60, 2)], trees$h[seq(1, 59, 2)])
expect_true(sqrt(mean((filled$h - trees$h)^2)) < 1)
expect_equal(as.vector(table(filled$h_source)[c("imputed", "measured")]), c(30L, 30L))
# The fit of the imputation, an object of silvafit(), has the imputed values.
imputing <- attr(filled, "models")[[1]]
expect_equal(filled$h[seq(2, 60, 2)], as.vector(predict(imputing, trees[seq(2, 60, 2), ], level = "population")), tolerance = 1e-9)
expect_equal(nobs(imputing), 30L)
expect_equal(as.vector(residuals(read_fit(imputing, gaps))), trees$h[seq(1, 59, 2)] - as.vector(predict(imputing, trees[seq(1, 59, 2), ], level = "population")), tolerance = 1e-9)

# A study, its library, and predictions from it
set.seed(1)
plots <- rep(1:12, each = 25)
stems <- data.frame(plot = plots, species = "A", dbh = round(runif(300, 8, 45), 1))
stems$h <- round(1.3 + (24 + 2 * rnorm(12)[plots]) * (1 - exp(-0.06 * stems$dbh)) + rnorm(300), 1)
folder <- tempfile("study")
study <- suppressMessages(fit_study(stems, folder, responses = "h", progress = FALSE))
expect_true(file.exists(file.path(folder, "report.html")))
expect_equal(study$results$response, "h")
library <- read_library(study)
expect_true("nlme" %in% library$models$role)
new <- data.frame(plot = "x", species = "A", dbh = c(10, 20, 30), h = c(NA, 25, NA))
predicted <- suppressMessages(predict(library, new, level = "calibrated", interval = "prediction", se.fit = TRUE))
# Without an interval the standard error is that of the mean, as predict() of a fit has it.
of_mean <- suppressMessages(predict(library, new, level = "calibrated", interval = "confidence", se.fit = TRUE))
expect_equal(suppressMessages(predict(library, new, level = "calibrated", se.fit = TRUE))$h_se, of_mean$h_se)
expect_true(all(of_mean$h_se < predicted$h_se))
expect_true(all(c("h_pred", "h_lower", "h_upper", "h_se", "flag") %in% names(predicted)))
expect_true(all(predicted$h_lower < predicted$h_pred & predicted$h_pred < predicted$h_upper))
kept <- tempfile(fileext = ".rds")
saveRDS(library, kept)
expect_equal(suppressMessages(predict(readRDS(kept), new, level = "calibrated", interval = "prediction", se.fit = TRUE)), predicted)
# Its fits are objects of silvafit().
one <- library$fits[["A h nlme"]]
expect_equal(vapply(library$fits, nobs, 0L, USE.NAMES = FALSE), as.integer(library$models$n))
expect_equal(predicted$h_pred, as.vector(predict(one, new, level = "calibrated")), tolerance = 1e-12)
expect_true(nrow(summary(one)$tTable) == length(fixef(one)))
expect_equal(class_of_error(residuals(one)), "silvafit_usage_error")
expect_equal(class_of_error(read_library("no-such-library")), "silvafit_input_error")
expect_true(nrow(read_library("shanxia-2023")$models) > 0)

# Every setting of the program is an argument, by its name there
file <- tempfile(fileext = ".json")
writeLines('{"responses": ["cw"], "covariates": [], "minimum_trees": 400, "tests": "shown"}', file)
chosen <- suppressMessages(fit_study(stems, tempfile("study"), config = file, responses = "h", minimum_trees = 200, candidates = list(h = "M4"),
                                     criteria = "bic", choice = "parsimonious", maximum_random_effects = 1, progress = FALSE))
if (requireNamespace("jsonlite", quietly = TRUE)) {
  run <- jsonlite::fromJSON(file.path(chosen$out, "run.json"), simplifyVector = FALSE)$options
  expect_equal(run$responses, list("h"))
  expect_equal(run$covariates, list())
  expect_equal(run$candidates$h, list("M4"))
  expect_equal(c(run$minimum_trees, run$maximum_random_effects), c(200, 1))
  expect_equal(c(run$choice, run$tests, run$criteria$random), c("parsimonious", "shown", "bic"))
  expect_equal(setdiff(names(run), silvafit:::setting_list("reading", "rows", "units", "sampling", "study")$name), character(0))
}
expect_error(fit_study(stems, tempfile("study"), choice = "worst"), pattern = "best, parsimonious")
expect_error(fit_study(stems, tempfile("study"), criteria = c(random = "aic", last = "bic")), pattern = "available: base, covariates, random, variance")
expect_error(fit_study(stems, tempfile("study"), equaly_good = 1), pattern = "equally_good")

# Of repeated measurements the first are used, or those of all periods
stems$tree <- seq_len(300)
twice <- rbind(transform(stems, year = 2010), transform(stems, year = 2020, dbh = dbh + 1, h = h + 0.5))
of <- function(...) suppressMessages(fit_study(twice, tempfile("study"), responses = "h", progress = FALSE, ...))$results$n
expect_equal(c(of(), of(period = "year")), c(300, 600))

# Trees in three dimensions
figures <- transform(trees[1:3, ], hcb = h / 2, cw = 3)
file <- tempfile(fileext = ".glb")
grown <- suppressMessages(grow_trees(figures, file, lod = 3, trust_units = TRUE))
expect_equal(readBin(file, "raw", 4), charToRaw("glTF"))
expect_equal(nrow(grown), 3L)
page <- suppressMessages(view_stand(figures, open = FALSE, trust_units = TRUE))
expect_true(any(grepl("<html", readLines(page, warn = FALSE), ignore.case = TRUE)))

# Wrong input
expect_equal(class_of_error(structural_units(data.frame(dbh = 1:3))), "silvafit_input_error")
expect_equal(class_of_error(structural_units(trees, edge = "none", depth = 3)), "silvafit_usage_error")
expect_equal(class_of_error(structural_units(trees, edge = "sharp", trust_units = TRUE)), "silvafit_usage_error")
expect_equal(class_of_error(structural_units("no.csv")), "silvafit_input_error")

# Sampled plots: concentric circles, a table of plots with strata, against the formulas of stratified sampling.
sampled <- data.frame(plot = c(1, 1, 2, 3, 3, 3), tree = 1:6, species = "A", dbh = c(10, 35, 40, 12, 31, 50))
plots <- data.frame(plot = 1:4, stratum = c("a", "a", "b", "b"), stratum_area = c(30, 30, 10, 10))
stand <- suppressMessages(stand_summary(sampled, plots = plots, circles = c("7" = 5, "30" = 10), trust_units = TRUE))
factor <- ifelse(sampled$dbh < 30, 1e4 / (pi * 25), 1e4 / (pi * 100))
per_plot <- tapply(factor, factor(sampled$plot, 1:4), sum, default = 0)
expect_equal(stand$plots$stems_per_ha, as.vector(per_plot))
means <- tapply(per_plot, plots$stratum, mean)
errors <- tapply(per_plot, plots$stratum, sd) / sqrt(2)
expect_equal(stand$strata$stems_per_ha, c(as.vector(means), sum(means * c(30, 10)) / 40))
expect_equal(stand$strata$stems_per_ha_se, c(as.vector(errors), sqrt(sum((errors * c(30, 10))^2)) / 40))

# Growth: increments are differences per year
measured <- data.frame(plot = 1, tree = c(1, 2, 1, 3), year = c(2010, 2010, 2015, 2015), dbh = c(20, 30, 22, 8), status = c("alive", "alive", "alive", "alive"))
measured <- rbind(measured, data.frame(plot = 1, tree = 2, year = 2015, dbh = NA, status = "cut"))
growth <- suppressMessages(stand_growth(measured, plot_area = 500))
expect_equal(growth$growth_trees$fate, c("survivor", "cut", "ingrowth"))
expect_equal(growth$growth_trees$id[1], 2 / 5)
expect_equal(growth$growth_plots$stems_cut, 20 / 5)

# Biomass by an equation of the catalogue, and carbon of it
biomass <- exp(-2.5356 + 2.4349 * log(sampled$dbh))
with_mass <- suppressMessages(stand_summary(sampled, plot_area = 500, equations = c("jenkins-pine", "ipcc-carbon"), trust_units = TRUE))
expect_equal(with_mass$plots$carbon_kg_per_ha, as.vector(tapply(0.47 * biomass, sampled$plot, sum)) * 20)
# Predictions have them, too, with the predicted height where none was measured.
library <- read_library(study)
new <- data.frame(plot = "x", species = "A", dbh = c(10, 20))
predicted <- suppressMessages(predict(library, new, equations = c("laasasenaho-pine", "jenkins-pine", "ipcc-carbon")))
expect_equal(predicted$carbon_kg, 0.47 * exp(-2.5356 + 2.4349 * log(c(10, 20))))
with_height <- suppressMessages(predict(library, transform(new, h = predicted$h_pred), equations = "laasasenaho-pine"))
expect_equal(predicted$volume_m3, with_height$volume_m3)
expect_equal(class_of_error(stand_summary(sampled, plot_area = 500, dominant_trees = -1, trust_units = TRUE)), "silvafit_usage_error")
expect_true(grepl("dominant_trees", message_of_error(stand_summary(sampled, plot_area = 500, dominant_trees = -1, trust_units = TRUE))))

# Columns of the user are not replaced by results of the same name.
lettered <- data.frame(x = c(1, 3, 6, 4, 8, 9, 2, 7), y = c(1, 7, 2, 5, 9, 4, 9, 7), dbh = c(20, 15, 30, 22, 18, 25, 28, 14), species = rep(c("A", "B"), 4),
                       W = letters[1:8])
expect_error(suppressMessages(structural_units(lettered, edge = "none")), "has a column 'W' with other values", class = "silvafit_usage_error")
once <- suppressMessages(structural_units(lettered[names(lettered) != "W"], edge = "none"))
expect_equal(suppressMessages(structural_units(once, edge = "none"))$W, once$W)
flagged <- data.frame(species = "SM", dbh = c(10, 20), C = 0.5, M = 0.2, U = 0.5, flag = c("mine", "mine"))
expect_error(suppressMessages(predict(read_library("shanxia-2023"), flagged)), "has a column 'flag'", class = "silvafit_usage_error")
expect_error(structural_units(lettered, edgge = "none"), "did you mean 'edge'?", class = "silvafit_usage_error", fixed = TRUE)
