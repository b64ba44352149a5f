# SPDX-License-Identifier: MIT
# Marginal log-likelihoods by definition: FOCE, FOCEI, Laplace, adaptive Gauss-Hermite and the integral itself, at
# stated parameters and at the optima of the first three. See definition.R.
# Run from this folder: Rscript reference_integrals.R [values|correlated|optima]
source("json.R")
source("definition.R")
wanted <- commandArgs(trailingOnly = TRUE)
is_wanted <- function(what) length(wanted) == 0 || what %in% wanted

stands <- read_data("stands.csv")
orange <- read_data("Orange.csv")
height_text <- "h ~ 1.3 + a*(1 - exp(-b*dbh/10))"
crowded_text <- "h ~ 1.3 + a*(1 - exp(-(b + c*crowding)*dbh/10))"
logistic_text <- "circumference ~ Asym/(1 + exp(-(age - xmid)/scal))"
mean_of <- function(text, coefficients, columns) deriv(as.formula(text)[[3]], coefficients, c(coefficients, columns), hessian = TRUE)
height <- mean_of(height_text, c("a", "b"), "dbh")
crowded <- mean_of(crowded_text, c("a", "b", "c"), c("dbh", "crowding"))
logistic <- mean_of(logistic_text, c("Asym", "xmid", "scal"), "age")

# The integral on two grids; digits are those on which they agree.
integral <- function(problem, beta, factors, sigma, par, grids) {
  values <- vapply(grids, function(g) integral_log_likelihood(problem, beta, factors, sigma, par, g[1], g[2]), 0)
  cat("  integral", format(values, digits = 15), "\n")
  stopifnot(abs(values[1] - values[2]) < 1e-8)
  list(logLik = values[2], agreement_of_grids = abs(values[1] - values[2]))
}

# correlation: its text; its parameters follow those of the variance in `par`.
at_parameters <- function(id, text, file, problem, variance, beta, factors, sigma, par, points = c(), grids = NULL, correlation = NULL,
                          correlation_parameters = NULL) {
  variance_parameters <- par
  par <- c(par, correlation_parameters)
  cat(id, "\n")
  check_derivatives(problem, beta, factors, sigma, par)
  value <- function(method) log_likelihood(problem, method, beta, factors, sigma, par)
  levels <- problem$levels
  record <- list(id = id, formula = text, data = file,
                 random = setNames(lapply(seq_along(levels), function(k) list(effects = I(levels[[k]]$effects), covariance = tcrossprod(factors[[k]]))),
                                   vapply(levels, function(x) x$group, "")),
                 fixed = named(beta), sigma = sigma, variance = variance, variance_parameters = as.list(variance_parameters),
                 logLik = list(foce = value("foce"), focei = value("focei"), laplace = value("laplace")))
  for (k in points) record$logLik[[paste0("agq_", k)]] <- agq_log_likelihood(problem, k, beta, factors, sigma, par)
  if (!is.null(grids)) {
    whole <- integral(problem, beta, factors, sigma, par, grids)
    record$logLik$integral <- whole$logLik
    record$agreement_of_grids <- whole$agreement_of_grids
  }
  if (!is.null(correlation)) record <- c(record, list(correlation = correlation, correlation_parameters = as.list(correlation_parameters)))
  record
}

# theta = beta, lower triangles of the factors by level, log sigma, variance parameters.
optimum <- function(id, text, file, problem, variance, method, beta, factors, sigma, par, value = NULL, correlation = NULL) {
  sizes <- vapply(factors, nrow, 0L)
  read <- function(theta) {
    b <- setNames(theta[seq_along(beta)], names(beta))
    theta <- theta[-seq_along(beta)]
    L <- lapply(sizes, function(q) {
      count <- q * (q + 1) / 2
      one <- matrix(0, q, q)
      one[lower.tri(one, diag = TRUE)] <- theta[seq_len(count)]
      theta <<- theta[-seq_len(count)]
      one
    })
    list(beta = b, factors = L, sigma = exp(theta[1]), par = if (length(theta) > 1) theta[-1])
  }
  if (is.null(value)) value <- function(t) log_likelihood(problem, method, t$beta, t$factors, t$sigma, t$par)
  start <- c(beta, unlist(lapply(factors, function(L) L[lower.tri(L, diag = TRUE)])), log(sigma), par)
  scale <- pmax(abs(start), 0.01)
  seconds <- system.time(best <- minimize(function(x) -value(read(x * scale)), as.numeric(start / scale)))[["elapsed"]]
  end <- read(best$x * scale)
  cat(id, method, format(-best$value, digits = 14), "decrement", best$decrement, seconds, "s\n")
  stopifnot(best$positive, abs(best$decrement) < 1e-10)
  levels <- problem$levels
  correlated <- !is.null(correlation)
  record <- list(id = id, formula = text, data = file, variance = variance, method = method, logLik = -best$value, newton_decrement = best$decrement,
       estimates = named(end$beta), std_errors = named(setNames((sqrt(diag(solve(best$hessian))) * scale)[seq_along(beta)], names(beta))),
       sigma = end$sigma, variance_parameters = as.list(if (correlated) end$par[1] else end$par),
       random = setNames(lapply(seq_along(levels), function(k) list(effects = I(levels[[k]]$effects), covariance = tcrossprod(end$factors[[k]]))),
                         vapply(levels, function(x) x$group, "")))
  if (correlated) record <- c(record, list(correlation = correlation, correlation_parameters = as.list(end$par[-1])))
  record
}

orange_problem <- function(variance) {
  make_problem(orange, "circumference", logistic, c("Asym", "xmid", "scal"), "age", list(list(group = "Tree", effects = "Asym")), variance)
}
plot_problem <- function(variance, effects = c("a", "b")) {
  make_problem(stands, "h", height, c("a", "b"), "dbh", list(list(group = "plot", effects = effects)), variance)
}
three_problem <- function(variance) {
  make_problem(stands, "h", crowded, c("a", "b", "c"), c("dbh", "crowding"), list(list(group = "plot", effects = c("a", "b", "c"))), variance)
}
nested_problem <- function(variance) {
  make_problem(stands, "h", height, c("a", "b"), "dbh", list(list(group = "stand", effects = "a"), list(group = "plot", effects = c("a", "b"))), variance)
}

orange_exponential <- with_correlation(orange_problem(variance_power), exponential_of_distance("age", "Tree"), 1, 2)
nested_car1 <- with_correlation(nested_problem(variance_power), car1_of("tree", "plot"), 1, 2)

points <- c(1, 3, 5, 7, 9, 11, 15, 25)
pair <- matrix(c(3.4, 0.005, 0, 0.055), 2)
triple <- matrix(c(3.5, 0.014, -0.04, 0, 0.045, 0.02, 0, 0, 0.05), 3)
trees <- c(Asym = 192, xmid = 728, scal = 348)
grids_1 <- list(c(0.05, 40), c(0.03, 60))
grids_2 <- list(c(0.2, 40), c(0.16, 50))

values <- function() list(
  at_parameters("orange_none", logistic_text, "Orange.csv", orange_problem(variance_none), "none", trees, list(matrix(31.6)), 7.8, NULL, points, grids_1),
  at_parameters("orange_power", logistic_text, "Orange.csv", orange_problem(variance_power), "power", trees, list(matrix(31.6)), 0.9, 0.5, points, grids_1),
  at_parameters("orange_wide", logistic_text, "Orange.csv", orange_problem(variance_power), "power", trees, list(matrix(50)), 0.5, 0.9, points, grids_1),
  at_parameters("plot_b_power", height_text, "stands.csv", plot_problem(variance_power, "b"), "power", c(a = 29, b = 0.47), list(matrix(0.12)), 0.4, 0.5, points, grids_1),
  at_parameters("plot_ab_none", height_text, "stands.csv", plot_problem(variance_none), "none", c(a = 29, b = 0.47), list(pair), 1.7, NULL, points, grids_2),
  at_parameters("plot_ab_power", height_text, "stands.csv", plot_problem(variance_power), "power", c(a = 29, b = 0.47), list(pair), 0.4, 0.5, points, grids_2),
  at_parameters("plot_ab_exponential", height_text, "stands.csv", plot_problem(variance_exponential), "exponential", c(a = 29, b = 0.47), list(pair), 0.95, 0.03, points, grids_2),
  at_parameters("plot_ab_constant_plus_power", height_text, "stands.csv", plot_problem(variance_constant_power), "constant-plus-power", c(a = 29, b = 0.47), list(pair), 0.06,
                c(9, 1), points, grids_2),
  at_parameters("plot_abc_power", crowded_text, "stands.csv", three_problem(variance_power), "power", c(a = 29, b = 0.43, c = 0.08), list(triple), 0.35, 0.5, c(1, 3, 5, 7, 9, 15)),
  at_parameters("stand_a_plot_ab_none", height_text, "stands.csv", nested_problem(variance_none), "none", c(a = 29, b = 0.47), list(matrix(2.8), pair / 1.5), 1.7, NULL),
  at_parameters("stand_a_plot_ab_power", height_text, "stands.csv", nested_problem(variance_power), "power", c(a = 29, b = 0.47), list(matrix(2.8), pair / 1.5), 0.4, 0.5),
  at_parameters("orange_power_exponential", logistic_text, "Orange.csv", orange_exponential, "power", trees, list(matrix(31.6)), 0.9, 0.5, points, grids_1,
                "exponential(age)", 300),
  at_parameters("plot_ab_none_car1", height_text, "stands.csv", with_correlation(plot_problem(variance_none), car1_of("tree", "plot"), 0, 1), "none",
                c(a = 29, b = 0.47), list(pair), 1.7, NULL, c(1, 3, 7), NULL, "car1(tree)", 0.4),
  at_parameters("plot_ab_power_nugget", height_text, "stands.csv",
                with_correlation(plot_problem(variance_power), exponential_nugget_of("tree", "plot"), 1, 2:3), "power",
                c(a = 29, b = 0.47), list(pair), 0.4, 0.5, c(1, 3, 7), NULL, "exponential(tree; nugget)", c(3, 0.3)),
  at_parameters("stand_a_plot_ab_power_car1", height_text, "stands.csv", nested_car1, "power", c(a = 29, b = 0.47),
                list(matrix(2.8), pair / 1.5), 0.4, 0.5, c(), NULL, "car1(tree)", 0.4))
if (is_wanted("values")) write_expected("marginal_values.json", c(versions(), list(script = "bench/r/reference_integrals.R", notes = paste(
  "log-likelihoods at the given parameters; random holds levels from the outermost in; agq_K: K points a dimension, nodes v = mode + R^-1 x with",
  "R'R = I + L'KL (R upper triangular, Psi = L L', L lower), full second derivatives; integral: trapezoidal rule, equal on two grids to agreement_of_grids"))), values())

if (is_wanted("correlated")) {
  stems <- read_data("stems.csv")
  stems_text <- "h ~ a*(1 - exp(-k*age))^c"
  problem <- make_problem(stems, "h", mean_of(stems_text, c("a", "k", "c"), "age"), c("a", "k", "c"), "age", list(list(group = "tree", effects = "a")), variance_power)
  problem <- with_correlation(problem, car1_of("age", "tree"), 1, 2)
  write_expected("marginal_correlated.json", c(versions(), list(script = "bench/r/reference_integrals.R", notes = "as in marginal_optima.json, with correlated residuals")),
                 lapply(c("foce", "focei", "laplace"), function(method) {
    optimum("stems_a_power_car1", stems_text, "stems.csv", problem, "power", method, c(a = 29.9, k = 0.063, c = 1.44), list(matrix(2.54)), 0.58, c(-0.04, 0.88), correlation = "car1(age)")
  }))
}
if (!is_wanted("optima")) quit()
optima <- list()
for (method in c("foce", "focei", "laplace")) {
  optima <- c(optima, list(
    optimum("plot_ab_power", height_text, "stands.csv", plot_problem(variance_power), "power", method, c(a = 29, b = 0.47), list(pair), 0.4, 0.5),
    optimum("orange_power", logistic_text, "Orange.csv", orange_problem(variance_power), "power", method, trees, list(matrix(31.6)), 0.9, 0.5)))
}
optima <- c(optima, list(
  optimum("plot_ab_none", height_text, "stands.csv", plot_problem(variance_none), "none", "foce", c(a = 29, b = 0.47), list(pair), 1.7, NULL),
  optimum("plot_ab_none", height_text, "stands.csv", plot_problem(variance_none), "none", "laplace", c(a = 29, b = 0.47), list(pair), 1.7, NULL),
  optimum("plot_ab_exponential", height_text, "stands.csv", plot_problem(variance_exponential), "exponential", "laplace", c(a = 29, b = 0.47), list(pair), 0.95, 0.03),
  optimum("orange_none", logistic_text, "Orange.csv", orange_problem(variance_none), "none", "laplace", trees, list(matrix(31.6)), 7.8, NULL),
  optimum("stand_a_plot_ab_power", height_text, "stands.csv", nested_problem(variance_power), "power", "laplace", c(a = 29, b = 0.47), list(matrix(2.8), pair / 2), 0.4, 0.5),
  optimum("stand_a_plot_ab_power", height_text, "stands.csv", nested_problem(variance_power), "power", "focei", c(a = 29, b = 0.47), list(matrix(2.8), pair / 2), 0.4, 0.5),
  optimum("stand_a_plot_ab_none", height_text, "stands.csv", nested_problem(variance_none), "none", "laplace", c(a = 29, b = 0.47), list(matrix(2.8), pair / 2), 1.7, NULL)))
# Maximum likelihood itself: with 61 points the quadrature is the integral to rounding (see marginal_values.json).
for (variance in c("none", "power")) {
  problem <- orange_problem(if (variance == "none") variance_none else variance_power)
  exact <- function(t) agq_log_likelihood(problem, 61, t$beta, t$factors, t$sigma, t$par)
  optima <- c(optima, list(optimum(paste0("orange_", variance), logistic_text, "Orange.csv", problem, variance, "exact", trees, list(matrix(31.6)),
                                   if (variance == "none") 7.8 else 0.9, if (variance == "none") NULL else 0.5, exact)))
}
pair_problem <- plot_problem(variance_power)
exact <- function(t) agq_log_likelihood(pair_problem, 25, t$beta, t$factors, t$sigma, t$par)
optima <- c(optima, list(optimum("plot_ab_power", height_text, "stands.csv", pair_problem, "power", "agq_25", c(a = 29, b = 0.47), list(pair), 0.4, 0.5, exact)))
write_expected("marginal_optima.json", c(versions(), list(script = "bench/r/reference_integrals.R", notes =
  "maxima of the log-likelihoods of marginal_values.json; std_errors from the Hessian of all parameters by differences (5 digits); newton_decrement: squared distance to the maximum in standard errors")), optima)
