# SPDX-License-Identifier: MIT
# Laplace maximum likelihood with TMB for two nested groupings, on the shipped data.
# Run from this folder: Rscript reference_tmb.R (compiles in a temporary folder, about a minute)
source("json.R")
library(TMB)

stands <- read_data("stands.csv")
build <- tempfile("tmb")
dir.create(build)
invisible(file.copy("nested_height.cpp", build))
compile(file.path(build, "nested_height.cpp"), flags = "-O1 -Wno-ignored-attributes")
dyn.load(dynlib(file.path(build, "nested_height")))

index <- function(x) match(x, unique(x)) - 1
data <- list(h = stands$h, dbh = stands$dbh, stand = index(stands$stand), plot = index(stands$plot))
start <- list(beta = c(29, 0.47), log_sd_stand = log(2), plot_factor = c(2, 0, 0.05), log_sigma = log(0.4), delta = 0.5,
              stand_effect = rep(0, max(data$stand) + 1), plot_effect = matrix(0, max(data$plot) + 1, 2))

fit <- function(id, map, start) {
  object <- MakeADFun(data, start, random = c("stand_effect", "plot_effect"), map = map, DLL = "nested_height", silent = TRUE)
  # The inner mode to rounding, so that outer differences mean something.
  newtonOption(object, tol = 1e-12, tol10 = 0)
  seconds <- system.time(best <- nlminb(object$par, object$fn, object$gr, control = list(rel.tol = 1e-14, x.tol = 1e-12, eval.max = 2000, iter.max = 1000)))
  # Newton steps with differences of TMB's gradient.
  x <- best$par
  for (step in 1:3) {
    g <- as.vector(object$gr(x))
    H <- optimHess(x, object$fn, object$gr)
    x <- x - solve(H, g)
  }
  g <- as.vector(object$gr(x))
  value <- -object$fn(x)
  factor <- unname(x[names(x) == "plot_factor"])
  L <- matrix(c(factor[1], factor[2], 0, factor[3]), 2)
  errors <- sqrt(diag(solve(H)))[names(x) == "beta"]
  cat(id, format(value, digits = 14), "gradient", max(abs(g)), best$message, "\n")
  list(id = id, data = "stands.csv", formula = "h ~ 1.3 + a*(1 - exp(-b*dbh/10))", random_text = "a | stand; a + b | plot",
       method = "Laplace ML (TMB)", logLik = value, max_abs_gradient = max(abs(g)), newton_decrement = sum(g * solve(H, g)), message = best$message,
       estimates = list(a = x[[1]], b = x[[2]]), std_errors = list(a = errors[[1]], b = errors[[2]]), sigma = exp(x[["log_sigma"]]),
       variance = if ("delta" %in% names(x)) "power" else "none", variance_parameters = if ("delta" %in% names(x)) list(power = x[["delta"]]) else NULL,
       random = list(stand = list(effects = I("a"), covariance = matrix(exp(2 * x[["log_sd_stand"]]))), plot = list(effects = I(c("a", "b")), covariance = tcrossprod(L))))
}

constant <- start
constant$log_sigma <- log(1.7)
constant$delta <- 0
fits <- list(fit("nested_power", list(), start), fit("nested_none", list(delta = factor(NA)), constant))
write_expected("laplace_nested_tmb.json", c(versions("TMB"), list(script = "bench/r/reference_tmb.R")), fits)
