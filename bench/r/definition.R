# SPDX-License-Identifier: MIT
# The marginal likelihoods of nonlinear mixed models written down from their definitions, with dense matrices and
# without regard to speed: what the fast programs are held to. One grouping, or one nested in another.
#
#   y_i = f(beta + effects; x_i) + e_i,   b ~ N(0, Psi),   e_i ~ N(0, (sigma g_i)^2)
#
# or with correlated residuals within the finest groups, e ~ N(0, sigma^2 G R G).
#
# A `problem` holds a top group's rows as a piece of its own; pieces are independent.

# Variance functions: log g and its first two derivatives by the mean, with nlme's g. `piece$data` has the columns.
of_mean <- function(g) function(mu, par, piece) g(mu, par)
power_of <- function(v, par) list(log = par * log(abs(v)), d1 = par / v, d2 = -par / v^2)
exponential_of <- function(v, par) list(log = par * v, d1 = par + 0 * v, d2 = 0 * v)
constant_power_of <- function(v, par) {  # par: constant, power
  g <- par[1] + abs(v)^par[2]
  g1 <- par[2] * abs(v)^par[2] / v
  g2 <- par[2] * (par[2] - 1) * abs(v)^par[2] / v^2
  list(log = log(g), d1 = g1 / g, d2 = g2 / g - (g1 / g)^2)
}
variance_none <- of_mean(function(mu, par) list(log = 0 * mu, d1 = 0 * mu, d2 = 0 * mu))
variance_power <- of_mean(power_of)
variance_exponential <- of_mean(exponential_of)
variance_constant_power <- of_mean(constant_power_of)
# A function of a column does not move with the mean.
of_column <- function(g, column) function(mu, par, piece) {
  list(log = g(piece$data[[column]], par)$log, d1 = 0 * mu, d2 = 0 * mu)
}
# One parameter a stratum, in the order of `levels`.
by_stratum <- function(g, column, levels) function(mu, par, piece) g(mu, par[match(piece$data[[column]], levels)])
column_by_stratum <- function(g, of, column, levels) function(mu, par, piece) {
  list(log = g(piece$data[[of]], par[match(piece$data[[column]], levels)])$log, d1 = 0 * mu, d2 = 0 * mu)
}
# Ratios of the standard deviation to the first stratum's, par: logarithms of the others'.
stratum_ratio <- function(column, levels) function(mu, par, piece) {
  list(log = c(0, par)[match(piece$data[[column]], levels)], d1 = 0 * mu, d2 = 0 * mu)
}
# A product; `take` says which of the parameters are whose.
product_of <- function(one, take_one, other, take_other) function(mu, par, piece) {
  x <- one(mu, par[take_one], piece)
  y <- other(mu, par[take_other], piece)
  list(log = x$log + y$log, d1 = x$d1 + y$d1, d2 = x$d2 + y$d2)
}

# Correlations: a matrix of a piece's rows from parameters; rows of different finest groups are independent.
within <- function(of, groups) of * outer(groups, groups, "==")
car1_of <- function(column, group) function(par, piece) {
  within(par^abs(outer(piece$data[[column]], piece$data[[column]], "-")), as.character(piece$data[[group]]))
}
exponential_of_distance <- function(column, group) function(par, piece) {
  within(exp(-abs(outer(piece$data[[column]], piece$data[[column]], "-")) / par), as.character(piece$data[[group]]))
}
exponential_nugget_of <- function(column, group) function(par, piece) {  # par: range, nugget
  distance <- abs(outer(piece$data[[column]], piece$data[[column]], "-"))
  R <- (1 - par[2]) * exp(-distance / par[1])
  diag(R) <- 1
  within(R, as.character(piece$data[[group]]))
}
# `take_variance`, `take_correlation`: which of the parameters are whose.
with_correlation <- function(problem, correlation, take_variance, take_correlation) {
  variance <- problem$variance
  problem$variance <- function(mu, par, piece) variance(mu, par[take_variance], piece)
  problem$correlation <- function(par, piece) correlation(par[take_correlation], piece)
  problem
}

# mean: from deriv(..., hessian = TRUE) with function.arg c(coefficients, columns)
# levels: list(list(group = "stand", effects = "a"), list(group = "plot", effects = c("a", "b")))
make_problem <- function(data, response, mean, coefficients, columns, levels = list(), variance = variance_none) {
  top <- if (length(levels) > 0) as.character(data[[levels[[1]]$group]]) else rep("all", nrow(data))
  pieces <- lapply(unique(top), function(label) {
    rows <- which(top == label)
    design <- setNames(lapply(coefficients, function(x) NULL), coefficients)
    blocks <- integer(0)   # level of each block of effects, in order
    columns_of <- list()
    width <- 0
    place <- list()
    for (level in seq_along(levels)) {
      group <- as.character(data[[levels[[level]]$group]])[rows]
      for (one in unique(group)) {
        blocks <- c(blocks, level)
        for (effect in levels[[level]]$effects) {
          width <- width + 1
          place[[length(place) + 1]] <- list(effect = effect, rows = which(group == one), column = width)
        }
      }
    }
    for (name in coefficients) design[[name]] <- matrix(0, length(rows), width)
    for (p in place) design[[p$effect]][p$rows, p$column] <- 1
    list(label = label, rows = rows, y = data[[response]][rows], design = design, blocks = blocks, width = width,
         data = data[rows, ],
         columns = lapply(columns, function(x) data[[x]][rows]))
  })
  list(pieces = pieces, mean = mean, coefficients = coefficients, variance = variance, levels = levels, n = nrow(data))
}

# Block-diagonal factor L of a piece's effects from the level's factors (lower triangular, Psi = L L').
piece_factor <- function(piece, factors) {
  L <- matrix(0, piece$width, piece$width)
  at <- 0
  for (level in piece$blocks) {
    q <- nrow(factors[[level]])
    L[at + seq_len(q), at + seq_len(q)] <- factors[[level]]
    at <- at + q
  }
  L
}

# The mean with its derivatives by the effects: mu (n), Z (n x width), and second derivatives by coefficient pairs.
piece_mean <- function(problem, piece, beta, b) {
  phi <- lapply(problem$coefficients, function(name) beta[[name]] + as.vector(piece$design[[name]] %*% b))
  value <- do.call(problem$mean, c(phi, piece$columns))
  gradient <- attr(value, "gradient")
  Z <- matrix(0, length(piece$y), piece$width)
  for (name in problem$coefficients) Z <- Z + gradient[, name] * piece$design[[name]]
  list(mu = as.vector(value), gradient = gradient, hessian = attr(value, "hessian"), Z = Z)
}

# -log density of a piece's observations given the effects, and its derivatives by their means: the second ones as
# a matrix if they are correlated. Expected ones by Mardia and Marshall (1984).
correlated_terms <- function(problem, piece, mu, sigma, par) {
  g <- problem$variance(mu, par, piece)
  s <- sigma * exp(g$log)
  R <- problem$correlation(par, piece)
  inverse <- solve(R)
  e <- (piece$y - mu) / s
  a <- as.vector(inverse %*% e)
  e1 <- -1 / s - e * g$d1
  e2 <- 2 * g$d1 / s - e * g$d2 + e * g$d1^2
  list(value = sum(log(s)) + sum(log(diag(chol(R)))) + sum(e * a) / 2,
       d1 = g$d1 + a * e1,
       d2 = diag(g$d2 + a * e2, length(s)) + outer(e1, e1) * inverse,
       expected_d2 = outer(1 / s, 1 / s) * inverse + outer(g$d1, g$d1) * (diag(length(s)) + inverse * R))
}

# Derivatives of -log density of one observation by its mean.
residual_terms <- function(problem, piece, mu, sigma, par) {
  if (!is.null(problem$correlation)) return(correlated_terms(problem, piece, mu, sigma, par))
  g <- problem$variance(mu, par, piece)
  r <- piece$y - mu
  tau <- exp(-2 * g$log) / sigma^2
  list(value = log(sigma) + g$log + r^2 * tau / 2,
       d1 = g$d1 - r * tau - g$d1 * r^2 * tau,
       d2 = g$d2 + tau + 4 * g$d1 * r * tau - g$d2 * r^2 * tau + 2 * g$d1^2 * r^2 * tau,
       expected_d2 = tau + 2 * g$d1^2)
}

# A matrix, or the diagonal of one, times a matrix.
times <- function(second, of) if (is.matrix(second)) second %*% of else second * of

curvature <- function(problem, piece, mean, first, second) {
  K <- t(mean$Z) %*% times(second, mean$Z)
  if (is.null(first)) return(K)
  for (s in problem$coefficients) {
    for (t in problem$coefficients) {
      K <- K + t(piece$design[[s]]) %*% ((first * mean$hessian[, s, t]) * piece$design[[t]])
    }
  }
  K
}

# -log of the joint density of a piece's observations and v, without v's constant.
joint <- function(problem, piece, beta, L, sigma, par, v) {
  mean <- piece_mean(problem, piece, beta, as.vector(L %*% v))
  value <- sum(residual_terms(problem, piece, mean$mu, sigma, par)$value) + length(piece$y) / 2 * log(2 * pi) + sum(v^2) / 2
  if (is.finite(value)) value else Inf
}

newton_mode <- function(value, derivatives, v) {
  current <- value(v)
  for (iteration in 1:200) {
    d <- derivatives(v)
    H <- d$H
    shift <- 0
    while (min(eigen(H + shift * diag(nrow(H)), symmetric = TRUE, only.values = TRUE)$values) < 1e-6) {
      shift <- max(2 * shift, 1)
    }
    step <- -solve(H + shift * diag(nrow(H)), d$g)
    if (sum(step * d$g)^2 < 1e-44 || (shift == 0 && -sum(step * d$g) < 1e-24)) return(v)
    length <- 1
    while (value(v + length * step) > current + 1e-13 * abs(current) && length > 1e-10) length <- length / 2
    if (length <= 1e-10) return(v)
    v <- v + length * step
    current <- value(v)
  }
  stop("the mode was not found")
}

# Mode of the joint density; `frozen`: the residual variance is that at b = 0 (FOCE without interaction).
piece_mode <- function(problem, piece, beta, L, sigma, par, frozen = NULL, v = rep(0, piece$width)) {
  if (!is.null(frozen)) {
    value <- function(v) {
      mean <- piece_mean(problem, piece, beta, as.vector(L %*% v))
      r <- piece$y - mean$mu
      sum(r * times(frozen, r)) / 2 + sum(v^2) / 2
    }
    derivatives <- function(v) {
      mean <- piece_mean(problem, piece, beta, as.vector(L %*% v))
      first <- -as.vector(times(frozen, piece$y - mean$mu))
      list(g = as.vector(t(L) %*% (t(mean$Z) %*% first)) + v,
           H = diag(piece$width) + t(L) %*% curvature(problem, piece, mean, first, frozen) %*% L)
    }
  } else {
    value <- function(v) joint(problem, piece, beta, L, sigma, par, v)
    derivatives <- function(v) {
      mean <- piece_mean(problem, piece, beta, as.vector(L %*% v))
      terms <- residual_terms(problem, piece, mean$mu, sigma, par)
      list(g = as.vector(t(L) %*% (t(mean$Z) %*% terms$d1)) + v,
           H = diag(piece$width) + t(L) %*% curvature(problem, piece, mean, terms$d1, terms$d2) %*% L)
    }
  }
  newton_mode(value, derivatives, v)
}

half_log_determinant <- function(H) {
  factor <- tryCatch(chol(H), error = function(e) NULL)
  if (is.null(factor)) NA else sum(log(diag(factor)))
}

# -log likelihood of a piece. method: laplace (full second derivatives), focei (expected second derivatives, the
# variance moves with the effects), foce (the variance stays at b = 0).
piece_objective <- function(problem, piece, method, beta, L, sigma, par) {
  if (method == "foce") {
    at_zero <- piece_mean(problem, piece, beta, rep(0, piece$width))$mu
    log_g <- problem$variance(at_zero, par, piece)$log
    tau <- exp(-2 * log_g) / sigma^2
    half_log_R <- 0
    if (!is.null(problem$correlation)) {
      R <- problem$correlation(par, piece)
      tau <- outer(sqrt(tau), sqrt(tau)) * solve(R)
      half_log_R <- half_log_determinant(R)
    }
    v <- piece_mode(problem, piece, beta, L, sigma, par, frozen = tau)
    mean <- piece_mean(problem, piece, beta, as.vector(L %*% v))
    H <- diag(piece$width) + t(L) %*% curvature(problem, piece, mean, NULL, tau) %*% L
    r <- piece$y - mean$mu
    return(sum(log(sigma) + log_g) + half_log_R + sum(r * times(tau, r)) / 2 + length(r) / 2 * log(2 * pi) + sum(v^2) / 2 +
             half_log_determinant(H))
  }
  v <- piece_mode(problem, piece, beta, L, sigma, par)
  mean <- piece_mean(problem, piece, beta, as.vector(L %*% v))
  terms <- residual_terms(problem, piece, mean$mu, sigma, par)
  K <- if (method == "laplace") curvature(problem, piece, mean, terms$d1, terms$d2)
       else curvature(problem, piece, mean, NULL, terms$expected_d2)
  joint(problem, piece, beta, L, sigma, par, v) + half_log_determinant(diag(piece$width) + t(L) %*% K %*% L)
}

log_likelihood <- function(problem, method, beta, factors, sigma, par = NULL) {
  -sum(vapply(problem$pieces, function(piece) {
    piece_objective(problem, piece, method, as.list(beta), piece_factor(piece, factors), sigma, par)
  }, 0))
}

# Nodes and weights of Gauss-Hermite quadrature for the standard normal density (Golub and Welsch 1969).
gauss_hermite <- function(points) {
  if (points == 1) return(list(x = 0, w = 1))
  J <- matrix(0, points, points)
  for (i in seq_len(points - 1)) J[i, i + 1] <- J[i + 1, i] <- sqrt(i)
  e <- eigen(J, symmetric = TRUE)
  list(x = e$values, w = e$vectors[1, ]^2)
}

# -log joint density at many points v (rows), for a piece of one grouping: n x points at once.
joint_many <- function(problem, piece, beta, L, sigma, par, V) {
  b <- V %*% t(L)
  n <- length(piece$y)
  m <- nrow(V)
  phi <- lapply(problem$coefficients, function(name) {
    as.vector(beta[[name]] + piece$design[[name]] %*% t(b))
  })
  columns <- lapply(piece$columns, rep, times = m)
  mu <- as.vector(do.call(problem$mean, c(phi, columns)))
  if (!is.null(problem$correlation)) {
    values <- apply(matrix(mu, n), 2, function(one) residual_terms(problem, piece, one, sigma, par)$value)
    return(values + n / 2 * log(2 * pi) + rowSums(V^2) / 2)
  }
  long <- list(y = rep(piece$y, m))  # for variance functions of the mean, which read no other column
  terms <- residual_terms(problem, long, mu, sigma, par)$value
  terms[is.na(terms)] <- Inf
  colSums(matrix(terms, n)) + n / 2 * log(2 * pi) + rowSums(V^2) / 2
}

# Adaptive Gauss-Hermite quadrature: nodes v = mode + H^(-1/2)' x, with the full second derivatives of Laplace
# and the Cholesky factor H = C C', v = mode + C'^-1 x.
agq_log_likelihood <- function(problem, points, beta, factors, sigma, par = NULL) {
  rule <- gauss_hermite(points)
  beta <- as.list(beta)
  sum(vapply(problem$pieces, function(piece) {
    L <- piece_factor(piece, factors)
    v <- piece_mode(problem, piece, beta, L, sigma, par)
    mean <- piece_mean(problem, piece, beta, as.vector(L %*% v))
    terms <- residual_terms(problem, piece, mean$mu, sigma, par)
    H <- diag(piece$width) + t(L) %*% curvature(problem, piece, mean, terms$d1, terms$d2) %*% L
    R <- chol(H)
    x <- as.matrix(expand.grid(rep(list(rule$x), piece$width)))
    log_w <- rowSums(log(as.matrix(expand.grid(rep(list(rule$w), piece$width)))))
    V <- sweep(t(backsolve(R, t(x))), 2, v, "+")
    terms <- log_w + rowSums(x^2) / 2 - joint_many(problem, piece, beta, L, sigma, par, V)
    max(terms) + log(sum(exp(terms - max(terms)))) - sum(log(diag(R)))
  }, 0))
}

# The integral itself by the trapezoidal rule on a grid around the mode, in steps of `step` standard deviations of
# FOCEI's normal approximation (in the directions of its Cholesky factor). The box grows to each side until the
# integrand at its edge is exp(-edge) of the largest. The rule converges faster than any power of the step for a smooth
# integrand that vanishes at the ends; callers take two steps and two edges to see that.
integral_log_likelihood <- function(problem, beta, factors, sigma, par = NULL, step = 0.1, edge = 40) {
  beta <- as.list(beta)
  sum(vapply(problem$pieces, function(piece) {
    q <- piece$width
    L <- piece_factor(piece, factors)
    v <- piece_mode(problem, piece, beta, L, sigma, par)
    mean <- piece_mean(problem, piece, beta, as.vector(L %*% v))
    terms <- residual_terms(problem, piece, mean$mu, sigma, par)
    R <- chol(diag(q) + t(L) %*% curvature(problem, piece, mean, NULL, terms$expected_d2) %*% L)
    grid <- function(low, high, step) {
      as.matrix(expand.grid(Map(function(l, h) seq(ceiling(l / step), floor(h / step)) * step, low, high)))
    }
    logs <- function(x) {
      chunks <- split(seq_len(nrow(x)), (seq_len(nrow(x)) - 1) %/% 10000)
      -unlist(lapply(chunks, function(i) {
        joint_many(problem, piece, beta, L, sigma, par, sweep(t(backsolve(R, t(x[i, , drop = FALSE]))), 2, v, "+"))
      }), use.names = FALSE)
    }
    low <- rep(-8, q)
    high <- rep(8, q)
    repeat {
      x <- grid(low, high, 0.5)
      values <- logs(x)
      top <- max(values)
      grew <- FALSE
      for (d in seq_len(q)) {
        if (max(values[x[, d] < low[d] + 0.6]) > top - edge) { low[d] <- low[d] - 4; grew <- TRUE }
        if (max(values[x[, d] > high[d] - 0.6]) > top - edge) { high[d] <- high[d] + 4; grew <- TRUE }
      }
      if (!grew) break
    }
    values <- logs(grid(low, high, step))
    top <- max(values)
    top + log(sum(exp(values - top))) + q * (log(step) - log(2 * pi) / 2) - sum(log(diag(R)))
  }, 0))
}

# The linear mixed model around (beta, b): y - f + Z b + X beta ~ N(X beta, sigma^2 g^2 + Z Psi Z') with mean, weights
# and Z held. This is nlme's objective.
linearize <- function(problem, beta, effects) {
  lapply(seq_along(problem$pieces), function(k) {
    piece <- problem$pieces[[k]]
    mean <- piece_mean(problem, piece, as.list(beta), effects[[k]])
    list(piece = piece, mu = mean$mu, X = mean$gradient, Z = mean$Z, w = as.vector(piece$y - mean$mu + mean$Z %*% effects[[k]]))
  })
}

# Its log-likelihood, ML or restricted (without log|X'X|), the step in beta and the predicted effects.
linear_mixed_model <- function(problem, linear, factors, sigma, par, restricted = FALSE) {
  p <- length(problem$coefficients)
  total <- 0
  information <- matrix(0, p, p)
  score <- numeric(p)
  quadratic <- 0
  for (one in linear) {
    g <- exp(problem$variance(one$mu, par, one$piece)$log)
    V <- diag(sigma^2 * g^2, length(g))
    if (one$piece$width > 0) V <- V + tcrossprod(one$Z %*% piece_factor(one$piece, factors))
    C <- chol(V)
    X <- backsolve(C, one$X, transpose = TRUE)
    e <- backsolve(C, one$w, transpose = TRUE)
    information <- information + crossprod(X)
    score <- score + as.vector(crossprod(X, e))
    quadratic <- quadratic + sum(e^2)
    total <- total - sum(log(diag(C))) - length(g) / 2 * log(2 * pi)
  }
  step <- solve(information, score)
  total <- total - (quadratic - sum(step * score)) / 2
  if (restricted) total <- total + p / 2 * log(2 * pi) - half_log_determinant(information)
  list(log_likelihood = total, step = step, information = information)
}

predicted_effects <- function(problem, linear, factors, sigma, par, step) {
  lapply(linear, function(one) {
    if (one$piece$width == 0) return(numeric(0))
    L <- piece_factor(one$piece, factors)
    tau <- exp(-2 * problem$variance(one$mu, par, one$piece)$log) / sigma^2
    H <- diag(one$piece$width) + t(L) %*% (t(one$Z) %*% (tau * one$Z)) %*% L
    as.vector(L %*% solve(H, t(L) %*% (t(one$Z) %*% (tau * (one$w - one$X %*% step)))))
  })
}

# Gradient and Hessian by central differences of fourth and second order.
difference_gradient <- function(f, x, h = 1e-3 * pmax(abs(x), 0.01)) {
  vapply(seq_along(x), function(i) {
    at <- function(k) { y <- x; y[i] <- y[i] + k * h[i]; f(y) }
    (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * h[i])
  }, 0)
}
difference_hessian <- function(f, x, h = 1e-3 * pmax(abs(x), 0.01)) {
  n <- length(x)
  H <- matrix(0, n, n)
  at <- function(i, a, j, b) { y <- x; y[i] <- y[i] + a * h[i]; y[j] <- y[j] + b * h[j]; f(y) }
  for (i in seq_len(n)) for (j in seq_len(i)) {
    H[i, j] <- H[j, i] <- (at(i, 1, j, 1) - at(i, 1, j, -1) - at(i, -1, j, 1) + at(i, -1, j, -1)) / (4 * h[i] * h[j])
  }
  H
}

# A minimum to nearly all digits: nlminb, then Newton steps with difference derivatives until the decrement is at
# rounding. Returns the decrement (squared distance in standard errors where f is -log likelihood).
minimize <- function(f, x, hessian = NULL) {
  safe <- function(x) { v <- tryCatch(f(x), error = function(e) Inf); if (is.finite(v)) v else 1e10 }
  if (is.null(hessian)) {
    fit <- nlminb(x, safe, gradient = function(x) difference_gradient(safe, x),
                  control = list(rel.tol = 1e-14, x.tol = 1e-12, iter.max = 500, eval.max = 1000))
    x <- fit$par
    hessian <- difference_hessian(safe, x)
  }
  for (iteration in 1:8) {
    g <- difference_gradient(safe, x)
    step <- -solve(hessian, g)
    if (-sum(step * g) < 1e-16) break
    x <- x + step
  }
  list(x = x, value = f(x), decrement = sum(g * solve(hessian, g)), hessian = hessian,
       positive = min(eigen(hessian, symmetric = TRUE, only.values = TRUE)$values) > 0)
}

# The fixed point of Lindstrom and Bates: beta and b minimize the penalised sum of squares given theta, and theta
# maximizes the likelihood of the linear mixed model around them. theta -> list(factors, sigma, par) by `read`.
lindstrom_bates_fixed_point <- function(problem, beta, effects, theta, read, restricted = FALSE, rounds = 40) {
  hessian <- NULL
  for (round in seq_len(rounds)) {
    linear <- linearize(problem, beta, effects)
    minus <- function(theta) {
      t <- read(theta)
      -linear_mixed_model(problem, linear, t$factors, t$sigma, t$par, restricted)$log_likelihood
    }
    best <- minimize(minus, theta, hessian)
    change <- best$x - theta
    theta <- best$x
    hessian <- best$hessian
    t <- read(theta)
    # The Gauss-Newton step of the penalised sum of squares, repeated with these weights until it vanishes; the weights
    # move in the next round.
    step <- linear_mixed_model(problem, linear, t$factors, t$sigma, t$par)$step
    effects <- predicted_effects(problem, linear, t$factors, t$sigma, t$par, step)
    beta <- beta + step
    size <- max(abs(step) / abs(beta))
    moved <- sqrt(sum(change * (hessian %*% change)))  # in standard errors
    if (size < 1e-12 && moved < 1e-7) break
  }
  linear <- linearize(problem, beta, effects)
  end <- linear_mixed_model(problem, linear, t$factors, t$sigma, t$par, restricted)
  list(beta = beta, effects = effects, theta = theta, read = t, log_likelihood = end$log_likelihood,
       std_errors = sqrt(diag(solve(end$information))), rounds = round, step = size, moved = moved, positive = best$positive)
}

# A check of every derivative above by differences, at a point.
check_derivatives <- function(problem, beta, factors, sigma, par = NULL) {
  piece <- problem$pieces[[1]]
  beta <- as.list(beta)
  L <- piece_factor(piece, factors)
  v <- seq(0.1, 0.5, length.out = piece$width)
  h <- 1e-4
  at <- function(v) joint(problem, piece, beta, L, sigma, par, v)
  mean <- piece_mean(problem, piece, beta, as.vector(L %*% v))
  terms <- residual_terms(problem, piece, mean$mu, sigma, par)
  g <- as.vector(t(L) %*% (t(mean$Z) %*% terms$d1)) + v
  H <- diag(piece$width) + t(L) %*% curvature(problem, piece, mean, terms$d1, terms$d2) %*% L
  unit <- diag(piece$width)
  for (i in seq_along(v)) {
    difference <- (8 * (at(v + h * unit[i, ]) - at(v - h * unit[i, ])) - at(v + 2 * h * unit[i, ]) + at(v - 2 * h * unit[i, ])) / (12 * h)
    stopifnot(abs(difference - g[i]) < 1e-6 * (1 + abs(g[i])))
    second <- (at(v + 10 * h * unit[i, ]) - 2 * at(v) + at(v - 10 * h * unit[i, ])) / (10 * h)^2
    stopifnot(abs(second - H[i, i]) < 1e-3 * (1 + abs(H[i, i])))
  }
}
