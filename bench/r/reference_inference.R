# SPDX-License-Identifier: MIT
# Degrees of freedom and intervals of nlme, and profile limits by brute force, on the shipped data.
# Run from this folder: Rscript reference_inference.R (compiles a TMB template in a temporary folder; some minutes)
source("json.R")
source("definition.R")
library(nlme)
library(TMB)

stands <- read_data("stands.csv")
in_order <- function(x) factor(x, levels = unique(x))
stands$stand <- in_order(stands$stand)
stands$plot <- in_order(stands$plot)
stands$species <- factor(stands$species, levels = c("SM", "BHN"))
# Covariates of whole plots and whole stands: the thickest tree.
stands$plot_top <- ave(stands$dbh, stands$plot, FUN = max)
stands$stand_top <- ave(stands$dbh, stands$stand, FUN = max)
tight <- nlmeControl(tolerance = 1e-8, pnlsTol = 1e-6, msTol = 1e-10, maxIter = 300, pnlsMaxIter = 50, msMaxIter = 500, minScale = 1e-8)
level <- 0.95

# ---- degrees of freedom ----

table_of <- function(fit) {
  t <- summary(fit)$tTable
  list(coefficients = I(rownames(t)), df = I(unname(t[, "DF"])), t = I(unname(t[, "t-value"])), p = I(unname(t[, "p-value"])))
}
freedom <- function(id, formula, sub_models, random, fit) {
  c(list(id = id, formula = formula, sub_models = I(sub_models), random = random), table_of(fit))
}
line <- h ~ a + b * dbh
curve <- h ~ 1.3 + a * (1 - exp(-b * dbh / 10))
line_text <- "h ~ a + b*dbh"
curve_text <- "h ~ 1.3 + a*(1 - exp(-b*dbh/10))"
nested <- list(stand = a ~ 1, plot = a ~ 1)
degrees <- list(
  freedom("line", line_text, character(0), "a | plot",
          nlme(line, stands, fixed = a + b ~ 1, random = a ~ 1 | plot, start = c(8, 0.5), control = tight)),
  freedom("line_plot_covariate", line_text, "a ~ 1 + plot_top", "a | plot",
          nlme(line, stands, fixed = list(a ~ plot_top, b ~ 1), random = a ~ 1 | plot, start = c(8, 0, 0.5), control = tight)),
  freedom("line_two_covariates", line_text, c("a ~ 1 + plot_top + crowding"), "a | plot",
          nlme(line, stands, fixed = list(a ~ plot_top + crowding, b ~ 1), random = a ~ 1 | plot, start = c(8, 0, 0, 0.5), control = tight)),
  freedom("curve", curve_text, character(0), "a | plot",
          nlme(curve, stands, fixed = a + b ~ 1, random = a ~ 1 | plot, start = c(28, 0.5), control = tight)),
  freedom("curve_plot_covariate", curve_text, "a ~ 1 + plot_top", "a | plot",
          nlme(curve, stands, fixed = list(a ~ plot_top, b ~ 1), random = a ~ 1 | plot, start = c(28, 0, 0.5), control = tight)),
  freedom("nested_line", line_text, c("a ~ 1 + stand_top + plot_top"), "a | stand; a | plot",
          nlme(line, stands, fixed = list(a ~ stand_top + plot_top, b ~ 1), random = nested, start = c(8, 0, 0, 0.5), control = tight)),
  freedom("nested_line_one", line_text, c("a ~ 1 + plot_top"), "a | stand; a | plot",
          nlme(line, stands, fixed = list(a ~ plot_top, b ~ 1), random = nested, start = c(8, 0, 0.5), control = tight)),
  freedom("nested_line_without_intercept", line_text, c("a ~ 0 + stand_top + plot_top"), "a:plot_top | stand; a:plot_top | plot",
          nlme(h ~ c * stand_top + a * plot_top + b * dbh, stands, fixed = c + a + b ~ 1, random = nested, start = c(0.1, 0.1, 0.5), control = tight)),
  freedom("nested_curve", curve_text, character(0), "a | stand; a | plot",
          nlme(curve, stands, fixed = a + b ~ 1, random = nested, start = c(28, 0.5), control = tight)))

# ---- nlme's intervals ----

rows_of <- function(x) lapply(setNames(seq_len(nrow(x)), rownames(x)), function(i) I(unname(unlist(x[i, 1:3]))))
interval_record <- function(id, formula, sub_models, random, covariance, variance, reml, fit) {
  all <- intervals(fit, level = level)
  structures <- if (inherits(all$reStruct, "list")) lapply(all$reStruct, rows_of) else NULL
  list(id = id, formula = formula, sub_models = I(sub_models), random = random, covariance = covariance, variance = variance, reml = reml,
       logLik = as.numeric(logLik(fit)), n = nobs(fit), p = length(fixef0(fit)),
       fixed = rows_of(if (is.null(all$fixed)) all$coef else all$fixed), random_intervals = structures,
       variance_intervals = if (is.null(all$varStruct)) NULL else rows_of(all$varStruct), sigma = I(unname(as.vector(all$sigma))))
}
fixef0 <- function(fit) if (inherits(fit, "nlme")) fixef(fit) else coef(fit)
mixed <- function(...) nlme(..., control = tight)
from_lme <- lme(h ~ dbh, stands, random = ~ dbh | plot, method = "REML", control = lmeControl(msTol = 1e-12, tolerance = 1e-10))
nlme_intervals <- list(
  interval_record("none", curve_text, character(0), "a + b | plot", "general", "none", FALSE,
                  mixed(curve, stands, fixed = a + b ~ 1, random = a + b ~ 1 | plot, start = c(28, 0.5))),
  interval_record("power", curve_text, character(0), "a + b | plot", "general", "power", FALSE,
                  mixed(curve, stands, fixed = a + b ~ 1, random = a + b ~ 1 | plot, weights = varPower(), start = c(28, 0.5))),
  interval_record("diagonal_exponential", curve_text, character(0), "a + b | plot", "diagonal", "exponential", FALSE,
                  mixed(curve, stands, fixed = a + b ~ 1, random = pdDiag(a + b ~ 1), groups = ~ plot, weights = varExp(), start = c(28, 0.5))),
  interval_record("covariate_species", curve_text, "b ~ 1 + crowding", "a | plot", "general", "stratum(species)", FALSE,
                  mixed(curve, stands, fixed = list(a ~ 1, b ~ crowding), random = a ~ 1 | plot, weights = varIdent(form = ~ 1 | species), start = c(28, 0.5, 0))),
  interval_record("nested", curve_text, character(0), "a | stand; a + b | plot", "general", "none", FALSE,
                  mixed(curve, stands, fixed = a + b ~ 1, random = list(stand = a ~ 1, plot = a + b ~ 1), start = c(28, 0.5))),
  interval_record("gnls_power_of_dbh", curve_text, "b ~ 1 + crowding", "", "", "power(dbh)", FALSE,
                  gnls(curve, stands, params = list(a ~ 1, b ~ crowding), weights = varPower(form = ~ dbh), start = c(28, 0.5, 0))))
linear_reml <- intervals(from_lme, level = level)
nlme_intervals[[length(nlme_intervals) + 1]] <- list(
  id = "linear_reml", formula = line_text, sub_models = I(character(0)), random = "a + b | plot", covariance = "general", variance = "none", reml = TRUE,
  logLik = as.numeric(logLik(from_lme)), n = nrow(stands), p = 2, fixed = NULL, random_intervals = lapply(linear_reml$reStruct, rows_of),
  variance_intervals = NULL, sigma = I(unname(as.vector(linear_reml$sigma))))

# ---- profile limits by their definition ----

# Where twice the fall of the log-likelihood is the quantile. `objective` (-log L) takes all parameters; `held(z, c)` makes them from the free
# ones and the value that is held; `slopes`, if there is a gradient, is that of the objective.
limits <- function(objective, optimum, held, free, estimate, spans, cut = qchisq(level, 1), slopes = NULL) {
  best <- objective(optimum)
  deviance <- function(c) {
    current <- free
    value <- Inf
    for (round in 1:3) {
      found <- nlminb(current, function(z) objective(held(z, c)), gradient = if (is.null(slopes)) NULL else function(z) {
        # The map from the free ones is simple; its differences are exact to ten digits.
        x <- held(z, c)
        J <- vapply(seq_along(z), function(k) {
          step <- 1e-5 * max(abs(z[k]), 0.01)
          up <- z; up[k] <- up[k] + step
          down <- z; down[k] <- down[k] - step
          (held(up, c) - held(down, c)) / (2 * step)
        }, x)
        as.vector(t(J) %*% slopes(x))
      }, control = list(rel.tol = 1e-15, x.tol = 1e-10, eval.max = 4000, iter.max = 2000))
      if (found$objective > value - 1e-10) break
      value <- found$objective
      current <- found$par
    }
    2 * (min(value, found$objective) - best)
  }
  unname(vapply(spans, function(far) {
    if (deviance(far) < cut) return(NA_real_)
    uniroot(function(c) deviance(c) - cut, sort(c(estimate, far)), tol = abs(estimate - far) * 1e-7)$root
  }, 0))
}

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

# lb: the linear mixed model that touches at nlme's estimates.
touching <- mixed(curve, stands, fixed = a + b ~ 1, random = a + b ~ 1 | plot, weights = varPower(), start = c(28, 0.5))
mean_of <- deriv(~ 1.3 + a * (1 - exp(-b * dbh / 10)), c("a", "b"), c("a", "b", "dbh"))
b_hat <- as.matrix(ranef(touching))[as.character(stands$plot), ]
beta_hat <- fixef(touching)
at <- mean_of(beta_hat[[1]] + b_hat[, 1], beta_hat[[2]] + b_hat[, 2], stands$dbh)
X <- attr(at, "gradient")
mu <- as.vector(at)
w <- stands$h - mu + rowSums(X * b_hat)   # beta is the step from the estimate
rows <- split(seq_along(mu), stands$plot)
linear_value <- function(x) {  # step of a, of b, l11, l21, l22, log sigma, delta
  L <- matrix(c(x[3], x[4], 0, x[5]), 2)
  Psi <- tcrossprod(L)
  residual <- w - X %*% x[1:2]
  total <- 0
  for (r in rows) {
    Z <- X[r, , drop = FALSE]
    R <- tryCatch(chol(Z %*% Psi %*% t(Z) + diag(exp(2 * x[6]) * mu[r]^(2 * x[7]), length(r))), error = function(e) NULL)
    if (is.null(R)) return(1e10)
    total <- total + sum(log(diag(R))) + sum(backsolve(R, residual[r], transpose = TRUE)^2) / 2
  }
  total + length(mu) / 2 * log(2 * pi)
}
Psi <- as.matrix(touching$modelStruct$reStruct[[1]]) * touching$sigma^2
l <- t(chol(Psi))
start <- c(0, 0, l[1, 1], l[2, 1], l[2, 2], log(touching$sigma), as.numeric(coef(touching$modelStruct$varStruct)))
polished <- nlminb(start, linear_value, control = list(rel.tol = 1e-15, x.tol = 1e-10, eval.max = 5000, iter.max = 3000))$par
o <- polished
cat("moved by", max(abs(polished - start)), "\n")
sd_b <- sqrt(o[4]^2 + o[5]^2)
angle <- atan2(o[4], o[5])
linear <- function(...) limits(linear_value, polished, ...)
linear_limits <- list(
  "a" = beta_hat[[1]] + linear(function(z, c) c(c, z), o[-1], o[1], c(-3.5, 3.5)),
  "b" = beta_hat[[2]] / 10 + linear(function(z, c) c(z[1], 10 * c, z[-1]), o[-2], o[2] / 10, c(-0.006, 0.006)),
  "sd(a)" = linear(function(z, c) c(z[1:2], c, z[-(1:2)]), o[-3], abs(o[3]), c(1.5, 7)),
  "sd(b)" = linear(function(z, c) c(z[1:3], 10 * c * sin(z[4]), 10 * c * cos(z[4]), z[5:6]), c(o[1:3], angle, o[6:7]), sd_b / 10, c(0.0015, 0.012)),
  "cor(a, b)" = linear(function(z, c) c(z[1:3], z[4] * c, z[4] * sqrt(1 - c^2), z[5:6]), c(o[1:3], sd_b, o[6:7]), sin(angle), c(-0.9, 0.95)),
  "delta" = linear(function(z, c) c(z, c), o[-7], o[7], c(0.1, 0.9)),
  "sigma" = linear(function(z, c) c(z[1:5], log(c), z[6]), o[-6], exp(o[6]), c(0.15, 0.9)))
linear_record <- list(id = "lb_power", method = "lb", formula = "h ~ 1.3 + a*(1 - exp(-b*dbh))", random = "a + b | plot", variance = "power",
                      logLik = -linear_value(polished), limits = lapply(linear_limits, I))


# ols: where the sum of squares has grown by the F quantile.
squares <- function(x) sum((stands$h - 1.3 - x[1] * (1 - exp(-x[2] * stands$dbh)))^2)
pooled <- nls(h ~ 1.3 + a * (1 - exp(-b * dbh)), stands, start = list(a = 28, b = 0.05), control = nls.control(tol = 1e-10))
n <- nrow(stands)
s2 <- deviance(pooled) / (n - 2)
least <- function(c, which) {
  if (which == "a") return(optimize(function(b) squares(c(c, b)), c(0.01, 0.2), tol = 1e-12)$objective)
  basis <- 1 - exp(-c * stands$dbh)
  sum(lm.fit(cbind(basis), stands$h - 1.3)$residuals^2)
}
ols_limits <- lapply(c(a = "a", b = "b"), function(which) {
  estimate <- coef(pooled)[[which]]
  error <- sqrt(vcov(pooled)[which, which])
  excess <- function(c) (least(c, which) - deviance(pooled)) / s2 - qt(1 - (1 - level) / 2, n - 2)^2
  I(c(uniroot(excess, c(estimate - 5 * error, estimate), tol = 1e-12)$root, uniroot(excess, c(estimate, estimate + 5 * error), tol = 1e-12)$root))
})
f <- deriv(~ 1.3 + a * (1 - exp(-b * dbh)), c("a", "b"), c("a", "b", "dbh"), hessian = TRUE)(coef(pooled)[["a"]], coef(pooled)[["b"]], stands$dbh)
half_hessian <- crossprod(attr(f, "gradient")) - apply(attr(f, "hessian") * as.vector(stands$h - f), 2:3, sum)
ols_record <- list(id = "ols", method = "ols", formula = "h ~ 1.3 + a*(1 - exp(-b*dbh))", logLik = as.numeric(logLik(pooled)), sigma = sqrt(s2),
                   covariance = unname(s2 * solve(half_hessian)), gauss_newton = unname(vcov(pooled)), limits = ols_limits)

# gnls with weights of a column: the exact likelihood.
gnls_value <- function(x) {
  mean <- 1.3 + x[1] * (1 - exp(-x[2] * stands$dbh / 10))
  -sum(dnorm(stands$h, mean, exp(x[3] + x[4] * log(stands$dbh / 20)), log = TRUE))
}
o <- nlminb(c(28, 0.5, 0, 0.5), gnls_value, control = list(rel.tol = 1e-15, x.tol = 1e-12))$par
for (round in 1:3) o <- nlminb(o, gnls_value, control = list(rel.tol = 1e-15, x.tol = 1e-12))$par
gnls_limits <- function(...) limits(gnls_value, o, ...)
gnls_record <- list(id = "gnls_power_of_dbh", method = "gnls", formula = "h ~ 1.3 + a*(1 - exp(-b*dbh))", variance = "power(dbh)", logLik = -gnls_value(o),
                    limits = lapply(list(
                      "a" = gnls_limits(function(z, c) c(c, z), o[-1], o[1], c(25, 33)),
                      "b" = gnls_limits(function(z, c) c(z[1], 10 * c, z[2:3]), o[-2], o[2] / 10, c(0.035, 0.06)),
                      "delta" = gnls_limits(function(z, c) c(z, c), o[-4], o[4], c(-0.3, 1.2)),
                      "sigma" = gnls_limits(function(z, c) c(z[1:2], log(c) + z[3] * log(20), z[3]), o[-3], exp(o[3] - o[4] * log(20)), c(0.1, 6))), I))

# A variance of nothing: a straight line whose plots do not differ, with residuals that balance out in each plot.
flat <- data.frame(plot = rep(1:6, each = 5), x = rep(1:5, 6))
flat$y <- 2 + 3 * flat$x + rep(c(1, -2, 2, -2, 1), 6) * rep(c(1, 1.2, 0.8, 1.1, 0.9, 1), each = 5) * rep(c(1, -1), 15)[order(rep(1:6, each = 5))]
flat$y <- flat$y - ave(flat$y - 3 * flat$x, flat$plot) + 2 + 0.05 * rep(c(-1, 1, 0, 1, -1, 0), each = 5)
flat_value <- function(x) {  # a, b, sd of a, log sigma
  total <- 0
  for (p in 1:6) {
    r <- flat$y[flat$plot == p] - x[1] - x[2] * flat$x[flat$plot == p]
    V <- exp(2 * x[4]) * diag(5) + x[3]^2
    total <- total + 0.5 * (as.numeric(determinant(V)$modulus) + sum(r * solve(V, r)) + 5 * log(2 * pi))
  }
  total
}
o <- c(coef(lm(y ~ x, flat)), 0, log(sqrt(mean(resid(lm(y ~ x, flat))^2))))
flat_limits <- function(cut) limits(flat_value, o, function(z, c) c(z[1:2], c, z[3]), o[-3], 0, 3, cut = cut)
flat_record <- list(id = "flat", data = flat, formula = "y ~ a + b*x", random = "a | plot", logLik = -flat_value(o),
                    upper_one_sided = flat_limits(qchisq(2 * level - 1, 1)), upper_chi_squared = flat_limits(qchisq(level, 1)))

write_expected("inference.json", c(versions("nlme", "TMB"), list(script = "bench/r/reference_inference.R", level = level)),
               list(degrees_of_freedom = degrees, nlme_intervals = nlme_intervals,
                    profiles = list(tmb_record, linear_record, ols_record, gnls_record), edge = flat_record))
