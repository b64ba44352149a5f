# SPDX-License-Identifier: MIT
# Limits of profile likelihoods by their definition.
# Where twice the fall of the log-likelihood is the quantile. `objective` (-log L) takes all parameters; `held(z, c)` makes them from the free
# ones and the value that is held; `slopes`, if there is a gradient, is that of the objective.
central <- function(objective) function(x) {
  vapply(seq_along(x), function(k) {
    step <- 1e-5 * max(abs(x[k]), 0.1)
    up <- x; up[k] <- up[k] + step
    down <- x; down[k] <- down[k] - step
    (objective(up) - objective(down)) / (2 * step)
  }, 0)
}

limits <- function(objective, optimum, held, free, estimate, spans, cut = qchisq(0.95, 1), slopes = central(objective)) {
  best <- objective(optimum)
  deviance <- function(c) {
    current <- free
    value <- Inf
    for (round in 1:3) {
      found <- nlminb(current, function(z) objective(held(z, c)), gradient = function(z) {
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

