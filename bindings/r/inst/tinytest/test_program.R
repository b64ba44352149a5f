# SPDX-License-Identifier: MIT
# The same numbers as the JSON of the program, and files in both directions.
source("helpers.R", local = TRUE)
if (program() == "" || reference("data", "stands.csv") == "") exit_file("skipped: the program and its data are in the checkout only")
if (!requireNamespace("jsonlite", quietly = TRUE)) exit_file("skipped: jsonlite is not installed")
file <- reference("data", "stands.csv")
stands <- read.csv(file)

json_of_program <- function(...) jsonlite::fromJSON(paste(system2(program(), c("fit", shQuote(file), ..., "--json"), stdout = TRUE), collapse = "\n"),
                                                    simplifyVector = FALSE)
numbers <- function(json) unlist(json[c("fixed", "fixed_covariance", "sigma", "log_likelihood", "aic", "bic", "random", "variance", "statistics")])

check <- function(ours, theirs) {
  a <- suppressWarnings(as.numeric(numbers(jsonlite::fromJSON(fit_json(ours), simplifyVector = FALSE))))
  b <- suppressWarnings(as.numeric(numbers(theirs)))
  expect_equal(is.na(a), is.na(b))
  expect_equal(names(numbers(jsonlite::fromJSON(fit_json(ours), simplifyVector = FALSE))), names(numbers(theirs)))
  expect_true(max(abs(a - b) / pmax(abs(b), 1e-300), na.rm = TRUE) < 1e-12)
  expect_equal(unname(fixef(ours)), unname(vapply(theirs$fixed, `[[`, 0, "estimate")), tolerance = 1e-14)
}
check(silvafit(h ~ 1.3 + a * (1 - exp(-b * dbh)), data = stands, random = a ~ 1 | plot),
      json_of_program("--formula", shQuote("h ~ 1.3 + a*(1 - exp(-b*dbh))"), "--random", shQuote("a | plot")))
check(silvafit(h ~ 1.3 + a * (1 - exp(-b * dbh)), data = stands, parameters = list(a ~ species, b ~ 1 + crowding), random = list(stand = a ~ 1, plot = a ~ 1)),
      json_of_program("--formula", shQuote("h ~ 1.3 + a*(1 - exp(-b*dbh))"), "--parameter", shQuote("a ~ species"), "--parameter", shQuote("b ~ 1 + crowding"),
                      "--random", shQuote("a | stand; a | plot")))
laplace <- silvafit(h ~ 1.3 + a * (1 - exp(-b * dbh)), data = stands, random = a + b ~ 1 | plot, variance = "power(dbh)", method = "laplace")
check(laplace, json_of_program("--formula", shQuote("h ~ 1.3 + a*(1 - exp(-b*dbh))"), "--random", shQuote("a + b | plot"), "--variance", shQuote("power(dbh)"), "--method", "laplace"))

# The program predicts from a fit of R, and R from one of the program.
path <- tempfile(fileext = ".json")
fit_json(laplace, path)
out <- tempfile(fileext = ".csv")
system2(program(), c("predict", path, shQuote(file), "--level", "conditional", "--digits", "17", "--out", out), stdout = FALSE, stderr = FALSE)
expect_true(relative(read.csv(out)$h_pred, predict(laplace, stands)) < 1e-12)
expect_equal(fixef(read_fit(path)), fixef(laplace))
expect_equal(predict(read_fit(path), stands, level = "population"), predict(laplace, stands, level = "population"))

# With its data a fit of the program is as one that was made in R.
whole <- read_fit(path, stands)
for (of in list(fitted, residuals, function(fit) residuals(fit, type = "pearson"), confint, function(fit) nlme::getGroups(fit), nlme::ACF)) expect_equal(of(whole), of(laplace), tolerance = 1e-9)
expect_equal(nrow(bootstrap(whole, 3, threads = 1)$values), 3L)
expect_error(read_fit(path, transform(stands, h = h + 1)), "are not the data of the fit", class = "silvafit_input_error")
expect_error(update(whole, variance = NULL), "was read from a file", class = "silvafit_usage_error")
