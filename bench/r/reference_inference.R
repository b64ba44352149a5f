# SPDX-License-Identifier: MIT
# Degrees of freedom and intervals of nlme, and profile limits by brute force, on the shipped data.
# Run from this folder: Rscript reference_inference.R 
source("json.R")
source("definition.R")
source("nlme_record.R")
source("profile_limits.R")

stands <- read_data("stands.csv")
in_order <- function(x) factor(x, levels = unique(x))
stands$stand <- in_order(stands$stand)
stands$plot <- in_order(stands$plot)
stands$species <- factor(stands$species, levels = c("SM", "BHN"))
# Covariates of whole plots and whole stands: the thickest tree.
stands$plot_top <- ave(stands$dbh, stands$plot, FUN = max)
stands$stand_top <- ave(stands$dbh, stands$stand, FUN = max)
# The tightest control with which nlme ends.
mixed <- function(...) {
  found <- first_converged(function(control) nlme(..., control = control), controls)
  cat(found$control, "\n")
  found$fit
}
level <- 0.95

# ---- degrees of freedom ----

table_of <- function(fit) {
  t <- summary(fit)$tTable
  list(coefficients = I(rownames(t)), df = I(unname(t[, "DF"])), t = I(unname(t[, "t-value"])), p = I(unname(t[, "p-value"])))
}
freedom <- function(id, formula, sub_models, random, fit) {
  c(list(id = id, formula = formula, sub_models = I(sub_models), random = random), table_of(fit))
}
# Straight lines by lme, whose rule is the same; the names are ours, in lme's order.
line <- function(id, sub_models, random_text, names, fixed, random) {
  record <- freedom(id, "h ~ a + b*dbh", sub_models, random_text,
                    lme(fixed, stands, random = random, method = "ML", control = lmeControl(msTol = 1e-12, tolerance = 1e-10)))
  record$coefficients <- I(names)
  record
}
curve <- h ~ 1.3 + a * (1 - exp(-b * dbh / 10))
curve_text <- "h ~ 1.3 + a*(1 - exp(-b*dbh/10))"
nested <- list(stand = a ~ 1, plot = a ~ 1)
of_both <- list(stand = ~ 1, plot = ~ 1)
degrees <- list(
  line("line", character(0), "a | plot", c("a", "b"), h ~ dbh, ~ 1 | plot),
  line("line_plot_covariate", "a ~ 1 + plot_top", "a | plot", c("a", "a:plot_top", "b"), h ~ plot_top + dbh, ~ 1 | plot),
  line("line_two_covariates", "a ~ 1 + plot_top + crowding", "a | plot", c("a", "a:plot_top", "a:crowding", "b"), h ~ plot_top + crowding + dbh, ~ 1 | plot),
  line("line_without_intercept", "a ~ 0 + plot_top", "a:plot_top | plot", c("a:plot_top", "b"), h ~ 0 + plot_top + dbh, ~ 0 + plot_top | plot),
  line("nested_line", "a ~ 1 + stand_top + plot_top", "a | stand; a | plot", c("a", "a:stand_top", "a:plot_top", "b"), h ~ stand_top + plot_top + dbh, of_both),
  line("nested_line_one", "a ~ 1 + plot_top", "a | stand; a | plot", c("a", "a:plot_top", "b"), h ~ plot_top + dbh, of_both),
  line("nested_line_without_intercept", "a ~ 0 + stand_top + plot_top", "a:plot_top | stand; a:plot_top | plot", c("a:stand_top", "a:plot_top", "b"),
       h ~ 0 + stand_top + plot_top + dbh, list(stand = ~ 0 + plot_top, plot = ~ 0 + plot_top)),
  freedom("curve", curve_text, character(0), "a | plot", mixed(curve, stands, fixed = a + b ~ 1, random = a ~ 1 | plot, start = c(28, 0.5))),
  freedom("curve_plot_covariate", curve_text, "a ~ 1 + plot_top", "a | plot",
          mixed(curve, stands, fixed = list(a ~ plot_top, b ~ 1), random = a ~ 1 | plot, start = c(28, 0, 0.5))),
  freedom("nested_curve", curve_text, character(0), "a | stand; a | plot",
          mixed(curve, stands, fixed = a + b ~ 1, random = nested, start = c(28, 0.5))))

# ---- nlme's intervals ----

rows_of <- function(x) lapply(setNames(seq_len(nrow(x)), rownames(x)), function(i) I(unname(unlist(x[i, 1:3]))))
interval_record <- function(id, formula, sub_models, random, covariance, variance, reml, fit) {
  all <- tryCatch(intervals(fit, level = level), error = function(e) e)
  if (inherits(all, "error")) {
    cat(id, ": ", conditionMessage(all), "\n")
    return(NULL)
  }
  structures <- if (inherits(all$reStruct, "list")) lapply(all$reStruct, rows_of) else NULL
  list(id = id, formula = formula, sub_models = I(sub_models), random = random, covariance = covariance, variance = variance, reml = reml,
       logLik = as.numeric(logLik(fit)), n = nobs(fit), p = length(fixef0(fit)),
       fixed = rows_of(if (is.null(all$fixed)) all$coef else all$fixed), random_intervals = structures,
       variance_intervals = if (is.null(all$varStruct)) NULL else rows_of(all$varStruct), sigma = I(unname(as.vector(all$sigma))))
}
fixef0 <- function(fit) if (inherits(fit, "nlme")) fixef(fit) else coef(fit)
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
  id = "linear_reml", formula = "h ~ a + b*dbh", sub_models = I(character(0)), random = "a + b | plot", covariance = "general", variance = "none", reml = TRUE,
  logLik = as.numeric(logLik(from_lme)), n = nrow(stands), p = 2, fixed = NULL, random_intervals = lapply(linear_reml$reStruct, rows_of),
  variance_intervals = NULL, sigma = I(unname(as.vector(linear_reml$sigma))))

nlme_intervals <- Filter(Negate(is.null), nlme_intervals)

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
dense_value <- function(x) {  # step of a, of b, l11, l21, l22, log sigma, delta
  L <- matrix(c(x[3], x[4], 0, x[5]), 2)
  residual <- w - X %*% x[1:2]
  total <- 0
  for (r in rows) {
    Z <- X[r, , drop = FALSE]
    R <- chol(Z %*% tcrossprod(L) %*% t(Z) + diag(exp(2 * x[6]) * mu[r]^(2 * x[7]), length(r)))
    total <- total + sum(log(diag(R))) + sum(backsolve(R, residual[r], transpose = TRUE)^2) / 2
  }
  total + length(mu) / 2 * log(2 * pi)
}
# The same by V^-1 = W - W Z L (I + L'Z'W Z L)^-1 L'Z'W, which is much quicker: two effects a plot.
linear_value <- function(x) {
  weight <- exp(-2 * x[6]) * mu^(-2 * x[7])
  residual <- as.vector(w - X %*% x[1:2])
  z1 <- x[3] * X[, 1] + x[4] * X[, 2]
  z2 <- x[5] * X[, 2]
  sums <- rowsum(weight * cbind(z1 * z1, z1 * z2, z2 * z2, z1 * residual, z2 * residual), stands$plot)
  a11 <- 1 + sums[, 1]
  a22 <- 1 + sums[, 3]
  determinant <- a11 * a22 - sums[, 2]^2
  squares <- sum(weight * residual^2) - sum((a22 * sums[, 4]^2 - 2 * sums[, 2] * sums[, 4] * sums[, 5] + a11 * sums[, 5]^2) / determinant)
  value <- (squares + sum(log(determinant)) - sum(log(weight)) + length(mu) * log(2 * pi)) / 2
  if (is.finite(value)) value else 1e10
}
Psi <- as.matrix(touching$modelStruct$reStruct[[1]]) * touching$sigma^2
l <- t(chol(Psi))
start <- c(0, 0, l[1, 1], l[2, 1], l[2, 2], log(touching$sigma), as.numeric(coef(touching$modelStruct$varStruct)))
stopifnot(abs(dense_value(start) - linear_value(start)) < 1e-8)
polished <- nlminb(start, linear_value, central(linear_value), control = list(rel.tol = 1e-15, x.tol = 1e-10, eval.max = 5000, iter.max = 3000))$par
o <- polished
cat("moved by", max(abs(polished - start)), "from", -linear_value(start), "to", -linear_value(polished), "nlme", as.numeric(logLik(touching)), "\n")
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
pooled <- nls(h ~ 1.3 + a * (1 - exp(-b * dbh)), stands, start = list(a = 28, b = 0.05), control = nls.control(tol = 1e-6))
# nls stops by the size of a step; Newton on the sum of squares adds the last digits.
least_at <- nlminb(coef(pooled), function(x) squares(x), central(squares), control = list(rel.tol = 1e-15, x.tol = 1e-12))$par
pooled <- nls(h ~ 1.3 + a * (1 - exp(-b * dbh)), stands, start = as.list(least_at), control = nls.control(tol = 1e-4))
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
o <- nlminb(c(28, 0.5, 0, 0.5), gnls_value, central(gnls_value), control = list(rel.tol = 1e-15, x.tol = 1e-12))$par
for (round in 1:3) o <- nlminb(o, gnls_value, central(gnls_value), control = list(rel.tol = 1e-15, x.tol = 1e-12))$par
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

write_expected("inference.json", c(versions("nlme"), list(script = "bench/r/reference_inference.R", level = level)),
               list(degrees_of_freedom = degrees, nlme_intervals = nlme_intervals,
                    profiles = list(linear_record, ols_record, gnls_record), edge = flat_record))
