# SPDX-License-Identifier: MIT
# Figures of nlme for REML, nested groups, variance functions and forms of the covariance, on the shipped data.
# Run from this folder: Rscript reference_nlme.R [name of one file]
source("json.R")
source("definition.R")
source("nlme_record.R")
wanted <- commandArgs(trailingOnly = TRUE)

in_order <- function(x) factor(x, levels = unique(x))
stands <- read_data("stands.csv")
stands$stand <- in_order(stands$stand)
stands$plot <- in_order(stands$plot)
stands$species <- factor(stands$species, levels = c("SM", "BHN"))  # SM is the first stratum
loblolly <- read_data("Loblolly.csv")
loblolly$Seed <- in_order(loblolly$Seed)
orange <- read_data("Orange.csv")
orange$Tree <- in_order(orange$Tree)

# A mean function with analytic derivatives, its data and its start.
make_model <- function(text, coefficients, columns, start, data, file) {
  formula <- as.formula(text)
  names(start) <- coefficients
  list(text = text, coefficients = coefficients, columns = columns, start = start, data = data, file = file, response = as.character(formula[[2]]),
       mean = deriv(formula[[3]], coefficients, c(coefficients, columns), hessian = TRUE),
       fixed = as.formula(paste(paste(coefficients, collapse = " + "), "~ 1")))
}
height <- make_model("h ~ 1.3 + a*(1 - exp(-b*dbh/10))", c("a", "b"), "dbh", c(28, 0.5), stands, "stands.csv")
crowded <- make_model("h ~ 1.3 + a*(1 - exp(-(b + c*crowding)*dbh/10))", c("a", "b", "c"), c("dbh", "crowding"), c(28, 0.45, 0.08), stands, "stands.csv")
logarithmic <- make_model("h ~ 1.3 + exp(la)*(1 - exp(-exp(lb)*dbh/10))", c("la", "lb"), "dbh", c(3.33, -0.7), stands, "stands.csv")
growth <- make_model("height ~ Asym + (R0 - Asym)*exp(-exp(lrc)*age)", c("Asym", "R0", "lrc"), "age", c(103, -8.5, -3.3), loblolly, "Loblolly.csv")
logistic <- make_model("circumference ~ Asym/(1 + exp(-(age - xmid)/scal))", c("Asym", "xmid", "scal"), "age", c(190, 700, 350), orange, "Orange.csv")

# Variance functions: nlme's, ours of definition.R, and the way from nlme's parameters to ours and back.
same <- function(x) as.numeric(x)
nameless <- function(names) function(par) as.list(setNames(par, names))
species <- c("SM", "BHN")
# The constant is free on its logarithmic scale.
with_log_constant <- function(g) function(mu, par, piece) g(mu, c(exp(par[1]), par[2]), piece)
log_constant <- function(x) c(log(x[[1]]), x[[2]])
natural_constant <- function(par) list(const = exp(par[[1]]), power = par[[2]])
none <- list(weights = NULL, g = variance_none, from = function(x) NULL, to = function(x) NULL)
power <- list(weights = quote(varPower()), g = variance_power, from = same, to = nameless("power"))
variances <- list(
  power = power,
  power_by_species = list(weights = quote(varPower(form = ~ fitted(.) | species)), g = function(mu, par, piece) by_stratum(power_of, "species", species)(mu, par, piece),
                          from = same, to = nameless(species)),
  species = list(weights = quote(varIdent(form = ~ 1 | species)), g = stratum_ratio("species", species), from = function(x) log(x[-1]),
                 to = function(par) list(SM = 1, BHN = exp(par[[1]]))),
  species_times_power = list(weights = quote(varComb(varIdent(form = ~ 1 | species), varPower())),
                             g = product_of(stratum_ratio("species", species), 1, variance_power, 2), from = function(x) c(log(x[2]), x[3]),
                             to = function(par) list(A.SM = 1, A.BHN = exp(par[[1]]), B.power = par[[2]])),
  exponential = list(weights = quote(varExp()), g = variance_exponential, from = same, to = nameless("expon")),
  exponential_of_dbh = list(weights = quote(varExp(form = ~ dbh)), g = of_column(exponential_of, "dbh"), from = same, to = nameless("expon")),
  exponential_by_species = list(weights = quote(varExp(form = ~ fitted(.) | species)), g = by_stratum(exponential_of, "species", species), from = same,
                                to = nameless(species)),
  power_of_dbh = list(weights = quote(varPower(form = ~ dbh)), g = of_column(power_of, "dbh"), from = same, to = nameless("power")),
  power_of_dbh_by_species = list(weights = quote(varPower(form = ~ dbh | species)), g = column_by_stratum(power_of, "dbh", "species", species), from = same,
                                 to = nameless(species)),
  constant_plus_power = list(weights = quote(varConstPower(const = 1, power = 0.6)), g = with_log_constant(variance_constant_power),
                             from = log_constant, to = natural_constant),
  constant_plus_power_of_dbh = list(weights = quote(varConstPower(const = 1, power = 0.6, form = ~ dbh)), g = with_log_constant(of_column(constant_power_of, "dbh")),
                                    from = log_constant, to = natural_constant),
  power_fixed_half = list(weights = quote(varPower(fixed = 0.5)), g = of_mean(function(mu, par) power_of(mu, 0.5)), from = function(x) NULL,
                          to = function(par) list(power = 0.5)),
  power_fixed_in_one_species = list(weights = quote(varPower(form = ~ fitted(.) | species, fixed = list(SM = 0.5))),
                                    g = function(mu, par, piece) by_stratum(power_of, "species", species)(mu, c(0.5, par), piece),
                                    from = function(x) as.numeric(x["BHN"]), to = function(par) list(SM = 0.5, BHN = par[[1]])))

one_line <- function(x) if (is.null(x)) "NULL" else gsub(" +", " ", paste(deparse(x), collapse = " "))
level <- function(group, effects, form = length(effects)) list(group = group, effects = effects, form = form)

add_fixed_point <- function(record, fit, model, levels, variance, restricted) {
  if (is.null(fit)) return(record)
  point <- tryCatch(fixed_point_record(fit, model, levels, variance, restricted), error = function(e) conditionMessage(e))
  if (is.character(point)) {
    record$no_fixed_point <- point
    cat("  no fixed point:", point, "\n")
  } else {
    record$fixed_point <- point
    cat("  fixed point", format(point$logLik, digits = 14), "less nlme", format(point$logLik - record$logLik, digits = 3), "\n")
  }
  record
}

# One nlme fit; `random` and the weights are unevaluated arguments so that the record can show them.
mixed <- function(id, model, random, levels, variance = none, method = "ML") {
  assign("mean_function", model$mean, globalenv())  # formulas of nlme find functions by name
  cat(id, "")
  call <- substitute(nlme(FORMULA, data = model$data, fixed = FIXED, random = RANDOM, weights = WEIGHTS, start = model$start, method = METHOD),
                     list(FORMULA = as.formula(paste(model$response, "~ mean_function(", paste(c(model$coefficients, model$columns), collapse = ", "), ")")),
                          FIXED = model$fixed, RANDOM = random, WEIGHTS = variance$weights, METHOD = method))
  attempt <- first_converged(function(control) {
    call$control <- control
    eval(call, list(model = model), globalenv())
  }, controls)
  cat(attempt$control, if (!is.null(attempt$fit)) format(as.numeric(logLik(attempt$fit)), digits = 14), "\n")
  record <- fit_record(id, model$file, paste0("nlme(", model$text, ", fixed = ", one_line(model$fixed), ", random = ", one_line(random), ", weights = ",
                                              one_line(variance$weights), ", method = \"", method, "\")"), attempt)
  record$formula <- model$text
  add_fixed_point(record, attempt$fit, model, levels, variance, method == "REML")
}

generalized <- function(id, model, variance) {
  assign("mean_function", model$mean, globalenv())  # formulas of nlme find functions by name
  cat(id, "")
  call <- substitute(gnls(FORMULA, data = model$data, params = FIXED, weights = WEIGHTS, start = model$start),
                     list(FORMULA = as.formula(paste(model$response, "~ mean_function(", paste(c(model$coefficients, model$columns), collapse = ", "), ")")),
                          FIXED = model$fixed, WEIGHTS = variance$weights))
  attempt <- first_converged(function(control) {
    call$control <- control
    eval(call, list(model = model), globalenv())
  }, gnls_controls)
  cat(attempt$control, if (!is.null(attempt$fit)) format(as.numeric(logLik(attempt$fit)), digits = 14), "\n")
  record <- fit_record(id, model$file, paste0("gnls(", model$text, ", params = ", one_line(model$fixed), ", weights = ", one_line(variance$weights), ")"), attempt)
  record$formula <- model$text
  add_fixed_point(record, attempt$fit, model, list(), variance, FALSE)
}

# A linear model, for which the linearization is exact and REML what the textbook has.
linear <- function(id, kind, method) {
  cat(id, "")
  variance <- if (kind == "power") variances$power_of_dbh else none
  control <- lmeControl(msTol = 1e-12, tolerance = 1e-10, maxIter = 500, msMaxIter = 500, niterEM = 50)
  fit <- eval(substitute(lme(h ~ dbh, random = ~ dbh | plot, data = stands, method = method, weights = WEIGHTS, control = control), list(WEIGHTS = variance$weights)))
  cat(format(as.numeric(logLik(fit)), digits = 14), "\n")
  record <- fit_record(id, "stands.csv", paste0("lme(h ~ dbh, random = ~ dbh | plot, weights = ", one_line(variance$weights), ", method = \"", method, "\")"),
                       list(fit = fit, control = "lmeControl(msTol = 1e-12, tolerance = 1e-10)", failures = character(0)),
                       notes = "a is (Intercept), b is dbh; the power is of the column dbh")
  record$formula <- "h ~ a + b*dbh"
  names(record$estimates) <- names(record$std_errors) <- c("a", "b")
  record$random$plot$names <- I(c("a", "b"))
  straight <- make_model("h ~ a + b*dbh", c("a", "b"), "dbh", c(5, 0.5), stands, "stands.csv")
  add_fixed_point(record, fit, straight, list(level("plot", c("a", "b"))), variance, method == "REML")
}

write <- function(name, fits, notes = NULL) {
  if (length(wanted) > 0 && !(name %in% wanted)) return(invisible())
  write_expected(name, c(versions("nlme"), list(script = "bench/r/reference_nlme.R", notes = notes)), fits())
}
on_plot <- list(level("plot", c("a", "b")))
ab_on_plot <- quote(a + b ~ 1 | plot)

write("nlme_reml.json", function() list(
  mixed("height_none", height, ab_on_plot, on_plot, none, "REML"),
  mixed("height_power", height, ab_on_plot, on_plot, power, "REML"),
  mixed("crowded_none", crowded, ab_on_plot, on_plot, none, "REML"),
  mixed("growth_none", growth, quote(Asym ~ 1 | Seed), list(level("Seed", "Asym")), none, "REML"),
  mixed("logistic_none", logistic, quote(Asym ~ 1 | Tree), list(level("Tree", "Asym")), none, "REML"),
  linear("linear_none", "none", "REML"),
  linear("linear_power", "power", "REML"),
  linear("linear_none_ml", "none", "ML"),
  linear("linear_power_ml", "power", "ML")),
  notes = "nlme() with method = REML takes the covariance ratios of ML and only sigma from REML, so that its logLik lies below the restricted maximum; fixed_point is the maximum itself. lme (linear_*) does maximize it. logLik of REML has no term of log|X'X|: -(N - p)/2 log(2 pi) - 1/2 sum log|V_j| - 1/2 log|X'V^-1 X| - 1/2 e'V^-1 e")

write("nlme_nested.json", function() {
  own <- quote(list(stand = a ~ 1, plot = a + b ~ 1))
  own_levels <- list(level("stand", "a"), level("plot", c("a", "b")))
  both <- quote(a ~ 1 | stand/plot)
  both_levels <- list(level("stand", "a"), level("plot", "a"))
  fits <- list()
  for (method in c("ML", "REML")) {
    for (variance in c("none", "power")) {
      of <- if (variance == "power") power else none
      suffix <- paste0(variance, "_", tolower(method))
      fits <- c(fits, list(mixed(paste0("stand_a_plot_ab_", suffix), height, own, own_levels, of, method),
                           mixed(paste0("a_in_both_", suffix), height, both, both_levels, of, method)))
    }
  }
  c(fits, list(mixed("crowded_stand_a_plot_ab_power_ml", crowded, own, own_levels, power),
               mixed("stand_ab_plot_ab_none_ml", height, quote(list(stand = a + b ~ 1, plot = a + b ~ 1)),
                     list(level("stand", c("a", "b")), level("plot", c("a", "b"))))))
}, notes = "random holds the levels from the outermost in; the inner groups are labeled outer/inner")

write("nlme_variance.json", function() {
  unlist(lapply(names(variances), function(name) list(
    mixed(paste0("nlme_", name), height, ab_on_plot, on_plot, variances[[name]]),
    generalized(paste0("gnls_", name), height, variances[[name]]))), recursive = FALSE)
}, notes = "variance_parameters as nlme's coef(varStruct, unconstrained = FALSE, allCoef = TRUE); varIdent's are ratios of standard deviations to SM's; sigma of gnls has n - p in its denominator, sigma of its fixed_point has n")

write("nlme_covariance.json", function() {
  log_pair <- c("la", "lb")
  triple <- c("a", "b", "c")
  list(
    mixed("general", logarithmic, quote(la + lb ~ 1 | plot), list(level("plot", log_pair))),
    mixed("diagonal", logarithmic, quote(list(plot = pdDiag(la + lb ~ 1))), list(level("plot", log_pair, c(1, 1)))),
    mixed("identity", logarithmic, quote(list(plot = pdIdent(la + lb ~ 1))), list(level("plot", log_pair, "identity"))),
    mixed("diagonal_power", logarithmic, quote(list(plot = pdDiag(la + lb ~ 1))), list(level("plot", log_pair, c(1, 1))), power),
    mixed("identity_power", logarithmic, quote(list(plot = pdIdent(la + lb ~ 1))), list(level("plot", log_pair, "identity")), power),
    mixed("stand_identity_plot_general", logarithmic, quote(list(stand = pdIdent(la + lb ~ 1), plot = pdSymm(la + lb ~ 1))),
          list(level("stand", log_pair, "identity"), level("plot", log_pair))),
    mixed("three_diagonal", crowded, quote(list(plot = pdDiag(a + b + c ~ 1))), list(level("plot", triple, c(1, 1, 1)))),
    mixed("three_general", crowded, quote(a + b + c ~ 1 | plot), list(level("plot", triple))),
    mixed("blocks_ab_c", crowded, quote(list(plot = pdBlocked(list(a + b ~ 1, c ~ 1)))), list(level("plot", triple, c(2, 1)))),
    mixed("blocks_ab_c_power", crowded, quote(list(plot = pdBlocked(list(a + b ~ 1, c ~ 1)))), list(level("plot", triple, c(2, 1))), power))
})
