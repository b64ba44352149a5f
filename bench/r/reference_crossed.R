# SPDX-License-Identifier: MIT
# Crossed random effects and three nested levels: simulated trees, linear models of lme4, height curves by Laplace's method of TMB.
# Run from this folder: Rscript reference_crossed.R (compiles a template in a temporary folder)
# Writes tests/reference/data/crossed.csv and tests/reference/expected/crossed.json. Debian: r-cran-lme4, r-cran-tmb.
source("json.R")
suppressMessages({library(lme4); library(TMB)})

set.seed(20261128)
regions <- 4; stands <- 3; plots <- 3; years <- 9
data <- expand.grid(number = 1:7, plot = seq_len(plots), stand = seq_len(stands), region = seq_len(regions))
data$plot_id <- as.integer(interaction(data$plot, data$stand, data$region, lex.order = FALSE))
data <- data[runif(nrow(data)) < 0.85, ]
data$year <- 2000 + sample.int(years, nrow(data), replace = TRUE)
data$dbh <- round(runif(nrow(data), 6, 45), 1)
of_region <- rnorm(regions, sd = 2)
of_stand <- matrix(rnorm(regions * stands, sd = 1.5), regions)
of_plot <- rnorm(regions * stands * plots, sd = 1.2)
rate <- rnorm(regions * stands * plots, sd = 0.006)
of_year <- rnorm(years, sd = 1)
limit <- 27 + of_region[data$region] + of_stand[cbind(data$region, data$stand)] + of_plot[data$plot_id] + of_year[data$year - 2000]
data$h <- round(1.3 + limit * (1 - exp(-(0.05 + rate[data$plot_id]) * data$dbh)) + rnorm(nrow(data), sd = 0.8), 2)
data <- data[c("region", "stand", "plot", "plot_id", "year", "dbh", "h")]
write.csv(data, "../../tests/reference/data/crossed.csv", row.names = FALSE, quote = FALSE)
data[c("region", "stand", "plot", "plot_id", "year")] <- lapply(data[c("region", "stand", "plot", "plot_id", "year")], factor)

# Linear models of x = log(dbh).
data$x <- log(data$dbh)
tight <- lmerControl(optimizer = "bobyqa", optCtrl = list(rhoend = 1e-12, maxfun = 1e6), calc.derivs = FALSE)
linear <- function(id, formula, random, reml) {
  fit <- lmer(formula, data, REML = reml, control = tight)
  parts <- as.data.frame(VarCorr(fit))
  list(id = id, formula = "h ~ b0 + b1*log(dbh)", random = random, reml = reml, logLik = as.numeric(logLik(fit)), fixed = as.list(setNames(fixef(fit), c("b0", "b1"))),
       std_errors = as.list(setNames(sqrt(diag(as.matrix(vcov(fit)))), c("b0", "b1"))), sigma = sigma(fit),
       components = lapply(seq_len(nrow(parts)), function(k) list(group = parts$grp[k], first = parts$var1[k], second = parts$var2[k], sdcor = parts$sdcor[k])),
       ranef = lapply(ranef(fit), function(one) list(labels = rownames(one), values = I(one[[1]]))), fitted = I(unname(fitted(fit))))
}
fits <- list()
for (reml in c(FALSE, TRUE)) {
  name <- function(id) paste0(id, if (reml) "_reml" else "_ml")
  fits <- c(fits, list(
    linear(name("plot_year"), h ~ x + (1 | plot_id) + (1 | year), "b0 | plot_id + year", reml),
    linear(name("slopes"), h ~ x + (x | plot_id) + (1 | year), "(b0 + b1 | plot_id) + (b0 | year)", reml),
    linear(name("levels"), h ~ x + (1 | region / stand / plot), "b0 | region/stand/plot", reml),
    linear(name("levels_year"), h ~ x + (1 | region / stand) + (1 | year), "b0 | region/stand + year", reml)))
}

build <- tempfile("tmb"); dir.create(build)
invisible(file.copy("crossed_height.cpp", build))
compile(file.path(build, "crossed_height.cpp"), flags = "-O1 -Wno-ignored-attributes")
dyn.load(dynlib(file.path(build, "crossed_height")))
number <- function(...) as.integer(factor(paste(...), unique(paste(...)))) - 1L
curve <- function(id, random, first, second, third, map, start = list()) {
  parameters <- modifyList(list(beta = c(27, 5), factor = c(1.5, 0, 0), sd = c(1, 0), log_sigma = log(0.8)), start)
  parameters <- c(parameters, list(u = matrix(0, 2, max(first) + 1), v = rep(0, max(second) + 1), w = rep(0, max(third) + 1)))
  object <- MakeADFun(list(H = data$h, D = data$dbh, first = first, second = second, third = third), parameters, random = c("u", "v", "w"), map = map,
                      DLL = "crossed_height", silent = TRUE)
  newtonOption(object, tol = 1e-12, tol10 = 0)
  optimum <- nlminb(object$par, object$fn, object$gr, control = list(rel.tol = 1e-14, x.tol = 1e-12, eval.max = 2000, iter.max = 1000))$par
  for (step in 1:3) optimum <- optimum - solve(optimHess(optimum, object$fn, object$gr), as.vector(object$gr(optimum)))
  errors <- sqrt(diag(solve(optimHess(optimum, object$fn, object$gr))))
  list(id = id, formula = "h ~ 1.3 + a*(1 - exp(-b*dbh))", random = random, method = "laplace", logLik = -as.numeric(object$fn(optimum)),
       parameters = lapply(split(unname(optimum), factor(names(optimum), unique(names(optimum)))), I), fixed = list(a = optimum[[1]], b = optimum[[2]] / 100),
       std_errors = list(a = errors[[1]], b = errors[[2]] / 100), gradient = max(abs(object$gr(optimum))))
}
plot <- number(data$plot_id); year <- number(data$year)
region <- number(data$region); stand <- number(data$region, data$stand)
only_a <- factor(c(1, NA, NA)); one_sd <- factor(c(1, NA))
one <- rep(0L, nrow(data))
fits <- c(fits, list(
  curve("curve_plot_year", "a | plot_id + year", plot, year, one, list(factor = only_a, sd = one_sd)),
  curve("curve_slopes", "(a + b | plot_id) + (a | year)", plot, year, one, list(sd = one_sd), list(factor = c(1.5, 0, 0.5))),
  curve("curve_levels", "a | region/stand/plot", plot, stand, region, list(factor = only_a), list(sd = c(1, 1)))))
write_expected("crossed.json", c(versions("lme4", "TMB"), list(script = "bench/r/reference_crossed.R")), fits)
