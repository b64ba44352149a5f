# SPDX-License-Identifier: MIT
# Coordinate reference systems and columns with units: expected values are those of the same data in cm and m.
source("helpers.R", local = TRUE)
quietly <- function(expression) suppressMessages(expression)
set.seed(11)
trees <- data.frame(plot = "1", tree = 1:60, species = sample(c("SM", "OF"), 60, TRUE), x = runif(60, 0, 40), y = runif(60, 0, 40), dbh = runif(60, 8, 40))
trees$h <- 1.3 + 22 * (1 - exp(-0.06 * trees$dbh)) + rnorm(60, sd = 0.5)
in_meters <- quietly(stand_summary(trees, plot_area = 1600, trust_units = TRUE))$plots
units_in_meters <- quietly(structural_units(trees, trust_units = TRUE))

if (requireNamespace("sf", quietly = TRUE)) {
  corners <- rbind(c(0, 0), c(40, 0), c(40, 40), c(0, 40), c(0, 0))
  square <- function(scale, crs) sf::st_sf(plot = "1", geometry = sf::st_sfc(sf::st_polygon(list(corners * scale)), crs = crs))
  points <- function(scale, crs, ...) sf::st_as_sf(transform(trees, x = x * scale, y = y * scale), coords = c("x", "y"), crs = crs, ...)
  metric <- points(1, 32632)
  window <- quietly(stand_summary(metric, window = square(1, 32632), trust_units = TRUE))$plots
  expect_equal(window$stems_per_ha, 60 / 0.16, tolerance = 1e-12)
  # US survey feet, international feet, kilometers
  for (crs in list(2264, 2225, "EPSG:2222", "+proj=tmerc +lat_0=0 +lon_0=9 +units=km")) {
    scale <- 1 / as.numeric(units::set_units(sf::st_crs(crs)$ud_unit, "m", mode = "standard"))
    for (remove in c(TRUE, FALSE)) {
      expect_equal(quietly(stand_summary(points(scale, crs, remove = remove), window = square(scale, crs), trust_units = TRUE))$plots, window, tolerance = 1e-9)
      expect_equal(quietly(structural_units(points(scale, crs, remove = remove), trust_units = TRUE))$core, units_in_meters$core)
    }
    expect_equal(class_of_error(stand_summary(trees, window = square(scale, crs), trust_units = TRUE)), "silvafit_usage_error")
  }
  # sf does not know the length of Clarke's foot
  expect_equal(class_of_error(structural_units(points(1, 2314), trust_units = TRUE)), "silvafit_input_error")
  # As sf::st_intersection(), which stops
  for (other in list(sf::st_crs(2154), sf::NA_crs_)) {
    expect_equal(class_of_error(stand_summary(metric, window = square(1, other), trust_units = TRUE)), "silvafit_usage_error")
    expect_error(sf::st_intersection(sf::st_geometry(metric), sf::st_geometry(square(1, other))))
  }
} else skipped("sf is not installed")

lme4_refit <- silvafit:::refit.silvafit
if (requireNamespace("units", quietly = TRUE)) {
  as_unit <- function(values, from, to) units::set_units(units::set_units(values, from, mode = "standard"), to, mode = "standard")
  measured <- trees
  measured$dbh <- as_unit(trees$dbh, "cm", "inch")
  for (name in c("x", "y", "h")) measured[[name]] <- as_unit(trees[[name]], "m", "ft")
  expect_equal(quietly(stand_summary(measured, plot_area = units::set_units(0.16, "ha", mode = "standard"), trust_units = TRUE))$plots, in_meters, tolerance = 1e-12)
  expect_equal(quietly(structural_units(measured, buffer = units::set_units(500, "cm", mode = "standard"), trust_units = TRUE))$core, units_in_meters$core)
  expect_equal(class_of_error(structural_units(measured, buffer = units::set_units(5, "kg", mode = "standard"))), "silvafit_input_error")
  expect_equal(class_of_error(structural_units(measured, circle = units::set_units(c(0, 0, 9), "m", mode = "standard"))), "silvafit_usage_error")
  expect_equal(class_of_error(stand_summary(measured, plot_area = 1600, stratum_areas = list(A = units::set_units(9, "ha", mode = "standard")))), "silvafit_usage_error")
  expect_equal(class_of_error(structural_units(transform(measured, dbh = units::set_units(trees$dbh, "kg", mode = "standard")))), "silvafit_input_error")
  expect_equal(class_of_error(stand_summary(transform(trees, bhd = measured$dbh), plot_area = 1600)), "silvafit_input_error")
  # Imputed heights have the unit of the column
  gaps <- measured
  gaps$h[seq(2, 60, 2)] <- NA
  bare <- trees
  bare$h[seq(2, 60, 2)] <- NA
  expect_equal(quietly(impute(gaps, "h", random = "none", trust_units = TRUE))$h, as_unit(quietly(impute(bare, "h", random = "none", trust_units = TRUE))$h, "m", "ft"), tolerance = 1e-9)
  limits <- function(table) quietly(impute(table, "h", random = "none", coverage = 0.9, trust_units = TRUE))$h_upper
  expect_equal(limits(gaps), as_unit(limits(bare), "m", "ft"), tolerance = 1e-9)

  # Fits have the units of their data
  curve <- h ~ 1.3 + a * (1 - exp(-b * dbh))
  plain <- silvafit(curve, trees)
  fit <- silvafit(curve, transform(trees, dbh = units::set_units(dbh, "cm", mode = "standard"), h = units::set_units(h, "m", mode = "standard")))
  expect_equal(fixef(fit), fixef(plain))
  expect_equal(residuals(fit), residuals(plain))
  expect_equal(predict(fit, data.frame(dbh = measured$dbh[1:3])), predict(plain, data.frame(dbh = trees$dbh[1:3])), tolerance = 1e-12)
  expect_equal(class_of_error(predict(fit, data.frame(dbh = units::set_units(1:3, "kg", mode = "standard")))), "silvafit_input_error")
  expect_equal(class_of_error(predict(plain, data.frame(dbh = measured$dbh[1:3]))), "silvafit_input_error")
  expect_message(predict(fit, data.frame(dbh = 20)), "dbh in cm")
  expect_equal(quietly(predict(fit, data.frame(dbh = 20))), predict(plain, data.frame(dbh = 20)))
  expect_silent(predict(fit, se.fit = TRUE))
  # Declared units are not in doubt, and new responses are numbers of the unit of the fit.
  expect_silent(in_feet <- silvafit(curve, measured))
  expect_equal(fixef(lme4_refit(in_feet, units::set_units(trees$h, "m", mode = "standard"))), fixef(in_feet), tolerance = 1e-9)
  expect_equal(fixef(lme4_refit(in_feet, as.numeric(measured$h))), fixef(in_feet), tolerance = 1e-9)
  for (other in list(units::set_units(trees$h, "kg", mode = "standard"), 3, as.character(trees$h))) expect_true(class_of_error(lme4_refit(in_feet, other)) %in% c("silvafit_input_error", "silvafit_usage_error"))
  expect_equal(class_of_error(lme4_refit(plain, measured$h)), "silvafit_input_error")
} else skipped("units is not installed")
