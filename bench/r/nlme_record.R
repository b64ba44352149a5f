# SPDX-License-Identifier: MIT
# What is kept of a fit of nlme, gnls or lme.
library(nlme)

# Tight control first; where nlme cannot meet it (its optimizer differentiates numerically), the next.
controls <- list(
  tight = nlmeControl(tolerance = 1e-8, pnlsTol = 1e-6, msTol = 1e-10, maxIter = 300, pnlsMaxIter = 50, msMaxIter = 500, minScale = 1e-8),
  firm = nlmeControl(tolerance = 1e-7, pnlsTol = 1e-5, msTol = 1e-9, maxIter = 300, pnlsMaxIter = 50, msMaxIter = 500, minScale = 1e-8),
  default = nlmeControl())
gnls_controls <- list(
  tight = gnlsControl(tolerance = 1e-8, nlsTol = 1e-6, msTol = 1e-10, maxIter = 300, nlsMaxIter = 50, msMaxIter = 500, minScale = 1e-8),
  firm = gnlsControl(tolerance = 1e-7, nlsTol = 1e-4, msTol = 1e-9, maxIter = 300, nlsMaxIter = 50, msMaxIter = 500, minScale = 1e-8),
  default = gnlsControl())

# `fit` is called with a control until one converges.
first_converged <- function(fit, controls) {
  failures <- character(0)
  for (name in names(controls)) {
    result <- tryCatch(fit(controls[[name]]), error = function(e) e)
    if (!inherits(result, "error")) return(list(fit = result, control = name, failures = failures))
    failures <- c(failures, paste0(name, ": ", conditionMessage(result)))
  }
  list(fit = NULL, control = NULL, failures = failures)
}

# Covariance and effects of each level, outermost first; the order of columns is that of the random formula.
random_record <- function(fit) {
  structures <- rev(fit$modelStruct$reStruct)  # nlme keeps the innermost first
  effects <- ranef(fit)
  if (length(structures) == 1) effects <- setNames(list(effects), names(structures))
  setNames(lapply(names(structures), function(level) {
    psi <- as.matrix(structures[[level]]) * fit$sigma^2
    names <- sub("\\.\\(Intercept\\)$", "", colnames(psi))
    values <- as.matrix(effects[[level]])
    list(names = I(names), structure = class(structures[[level]])[1], covariance = unname(psi), sd = I(unname(sqrt(diag(psi)))),
         correlation = unname(cov2cor(psi)), groups = I(rownames(values)), effects = unname(values))
  }), names(structures))
}

# How a level's factor L (Psi = L L') is written as free numbers: a form is the sizes of its blocks, or "identity".
factor_of <- function(form, q, t) {
  if (identical(form, "identity")) return(diag(t, q))
  L <- matrix(0, q, q)
  at <- 0
  for (size in form) {
    block <- matrix(0, size, size)
    count <- size * (size + 1) / 2
    block[lower.tri(block, diag = TRUE)] <- t[seq_len(count)]
    t <- t[-seq_len(count)]
    L[at + seq_len(size), at + seq_len(size)] <- block
    at <- at + size
  }
  L
}
factor_count <- function(form) if (identical(form, "identity")) 1 else sum(form * (form + 1) / 2)
factor_parameters <- function(form, psi) {
  if (identical(form, "identity")) return(sqrt(psi[1, 1]))
  L <- t(chol(psi))
  at <- 0
  unlist(lapply(form, function(size) {
    block <- L[at + seq_len(size), at + seq_len(size), drop = FALSE]
    at <<- at + size
    block[lower.tri(block, diag = TRUE)]
  }))
}

# The fit carried to the fixed point of its own method by dense matrices: nlme's figures without its tolerances.
# model: see reference_nlme.R; levels: list(list(group, effects, form)), outermost first.
fixed_point_record <- function(fit, model, levels, variance, restricted) {
  problem <- make_problem(model$data, model$response, model$mean, model$coefficients, model$columns, levels, variance$g)
  sigma <- fit$sigma
  psi <- list()
  values <- list()
  if (inherits(fit, "lme")) {
    structures <- rev(fit$modelStruct$reStruct)
    psi <- lapply(structures, function(x) as.matrix(x) * sigma^2)
    values <- ranef(fit)
    if (length(levels) == 1) values <- list(values)
  }
  effects <- lapply(problem$pieces, function(piece) {
    as.numeric(unlist(lapply(seq_along(levels), function(level) {
      inner <- unique(as.character(piece$data[[levels[[level]]$group]]))
      rows <- if (level == 1) inner else paste(piece$label, inner, sep = "/")
      t(as.matrix(values[[level]])[rows, , drop = FALSE])
    })))
  })
  nlme_parameters <- if (is.null(fit$modelStruct$varStruct)) NULL else coef(fit$modelStruct$varStruct, unconstrained = FALSE, allCoef = TRUE)
  theta <- c(unlist(Map(function(level, one) factor_parameters(level$form, one), levels, psi)), log(sigma), variance$from(nlme_parameters))
  read <- function(theta) {
    factors <- list()
    for (level in levels) {
      count <- factor_count(level$form)
      factors <- c(factors, list(factor_of(level$form, length(level$effects), theta[seq_len(count)])))
      theta <- theta[-seq_len(count)]
    }
    list(factors = factors, sigma = exp(theta[1]), par = theta[-1])
  }
  beta <- if (inherits(fit, "lme")) fixef(fit) else coef(fit)
  names(beta) <- model$coefficients
  end <- lindstrom_bates_fixed_point(problem, beta, effects, as.numeric(theta), read, restricted)
  if (!(end$positive && end$step < 1e-10 && end$moved < 1e-6)) stop("none within 40 rounds, or not a maximum: step ", end$step, ", moved ", end$moved)
  list(logLik = end$log_likelihood, estimates = named(end$beta), std_errors_without_factor = named(setNames(end$std_errors, names(beta))),
       sigma = end$read$sigma, variance_parameters = variance$to(end$read$par),
       random_covariance = setNames(lapply(end$read$factors, tcrossprod), vapply(levels, function(x) x$group, "")),
       rounds = end$rounds, last_relative_step = end$step, last_move_in_standard_errors = end$moved)
}

variance_record <- function(fit) {
  structure <- fit$modelStruct$varStruct
  if (is.null(structure)) return(NULL)
  as.list(coef(structure, unconstrained = FALSE, allCoef = TRUE))
}

fit_record <- function(id, data, call, attempt, notes = NULL) {
  fit <- attempt$fit
  if (is.null(fit)) return(list(id = id, data = data, call = call, converged = FALSE, failed_attempts = I(attempt$failures)))
  is_mixed <- inherits(fit, "lme")
  beta <- if (is_mixed) fixef(fit) else coef(fit)
  names(beta) <- sub("\\.\\(Intercept\\)$", "", names(beta))
  errors <- summary(fit)$tTable[, "Std.Error"]
  likelihood <- logLik(fit)
  list(id = id, data = data, call = call, converged = TRUE, control = attempt$control, failed_attempts = I(attempt$failures),
       method = if (is_mixed) fit$method else "ML", n = fit$dims$N,
       logLik = as.numeric(likelihood), df = attr(likelihood, "df"), AIC = AIC(fit), BIC = BIC(fit),
       estimates = named(beta), std_errors = named(setNames(errors, names(beta))),
       sigma = fit$sigma, variance_parameters = variance_record(fit),
       random = if (is_mixed) random_record(fit) else NULL,
       first_fitted = I(as.numeric(fitted(fit))[1:10]), notes = notes)
}
