# SPDX-License-Identifier: MIT
# Limits of the profile of Laplace's likelihood by brute force with TMB, on the shipped data.
# Run from this folder: Rscript reference_profile_tmb.R (compiles a template in a temporary folder; some minutes)
source("json.R")
source("profile_limits.R")
library(TMB)

stands <- read_data("stands.csv")
stands$plot <- factor(stands$plot, levels = unique(stands$plot))
level <- 0.95

# Laplace's method by TMB: parameters beta, L11, L21, L22, log sigma, delta; b is in hundredths.
build <- tempfile("tmb")
dir.create(build)
invisible(file.copy("height.cpp", build))
compile(file.path(build, "height.cpp"), flags = "-O1 -Wno-ignored-attributes")
dyn.load(dynlib(file.path(build, "height")))
plot_index <- as.integer(stands$plot) - 1L
object <- MakeADFun(list(H = stands$h, D = stands$dbh, C = stands$crowding, plot = plot_index),
                    list(beta = c(29, 4.7, 0), plot_factor = c(3, 0, 0.5), log_sigma = log(2), delta = 0.5, effect = matrix(0, 2, nlevels(stands$plot))),
                    random = "effect", map = list(beta = factor(c(1, 2, NA))), DLL = "height", silent = TRUE)
newtonOption(object, tol = 1e-12, tol10 = 0)
optimum <- nlminb(object$par, object$fn, object$gr, control = list(rel.tol = 1e-14, x.tol = 1e-12, eval.max = 2000, iter.max = 1000))$par
for (step in 1:3) optimum <- optimum - solve(optimHess(optimum, object$fn, object$gr), as.vector(object$gr(optimum)))
names(optimum) <- c("a", "b", "l11", "l21", "l22", "ls", "delta")
tmb_value <- function(x) { v <- object$fn(x); if (is.finite(v)) as.numeric(v) else 1e10 }
tmb_slopes <- function(x) as.vector(object$gr(x))
sd_b <- sqrt(optimum[["l21"]]^2 + optimum[["l22"]]^2)
angle <- atan2(optimum[["l21"]], optimum[["l22"]])
sigma_hat <- exp(optimum[["ls"]] - optimum[["delta"]] * log(20))
laplace <- function(...) limits(tmb_value, optimum, ..., slopes = tmb_slopes)
o <- optimum
laplace_limits <- list(
  "a" = laplace(function(z, c) c(c, z), o[-1], o[["a"]], c(26, 33)),
  "b" = laplace(function(z, c) c(z[1], 100 * c, z[-1]), o[-2], o[["b"]] / 100, c(0.042, 0.054)),
  "sd(a)" = laplace(function(z, c) c(z[1:2], c, z[-(1:2)]), o[-3], abs(o[["l11"]]), c(1.5, 7)),
  "sd(b)" = laplace(function(z, c) c(z[1:3], 100 * c * sin(z[4]), 100 * c * cos(z[4]), z[5:6]), c(o[1:3], angle, o[6:7]), sd_b / 100, c(0.0015, 0.012)),
  "cor(a, b)" = laplace(function(z, c) c(z[1:3], z[4] * c, z[4] * sqrt(1 - c^2), z[5:6]), c(o[1:3], sd_b, o[6:7]), sin(angle), c(-0.9, 0.95)),
  "delta" = laplace(function(z, c) c(z, c), o[-7], o[["delta"]], c(0.1, 0.9)),
  "sigma" = laplace(function(z, c) c(z[1:5], log(c) + z[6] * log(20), z[6]), o[-6], sigma_hat, c(0.15, 0.9)))
tmb_record <- list(id = "laplace_power", method = "laplace", formula = "h ~ 1.3 + a*(1 - exp(-b*dbh))", random = "a + b | plot", variance = "power",
                   logLik = -tmb_value(optimum), covariance = unname(solve(optimHess(optimum, object$fn, object$gr))),
                   covariance_of = I(c("a", "100 b", "l11", "100 l21", "100 l22", "log sigma 20^delta", "delta")), limits = lapply(laplace_limits, I))

write_expected("profile_laplace.json", c(versions("TMB"), list(script = "bench/r/reference_profile_tmb.R", level = level)), list(tmb_record))
