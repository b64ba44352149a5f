# SPDX-License-Identifier: MIT
# Correlated residuals: fits of lme, gls, gnls and nlme with their corStruct classes, most of them of the scripts of Pinheiro and Bates (2000).
#   Rscript reference_correlation.R CHECKOUT
# Writes tests/reference/expected/nlme_correlation.json, and the data of nlme into tests/reference/data-gpl. Debian: r-cran-nlme, r-cran-jsonlite.
suppressMessages(library(nlme))
root <- commandArgs(trailingOnly = TRUE)[1]
for (name in c("Ovary", "Dialyzer", "BodyWeight", "Spruce", "Soybean", "Wheat2", "Oats", "Orthodont")) {
  write.csv(as.data.frame(get(name)), file.path(root, "tests/reference/data-gpl", paste0(name, ".csv")), row.names = FALSE, quote = FALSE)
}
stems <- read.csv(file.path(root, "tests/reference/data/stems.csv"))
# Levels in the order of silvafit.
children <- transform(as.data.frame(Orthodont), Sex = factor(as.character(Sex)))
options(contrasts = c("contr.treatment", "contr.poly"))
linear <- lmeControl(msTol = 1e-13, tolerance = 1e-10, msMaxIter = 500, maxIter = 500, msMaxEval = 2000)
general <- glsControl(msTol = 1e-13, tolerance = 1e-10, msMaxIter = 500, maxIter = 500)
curved <- nlmeControl(tolerance = 1e-8, pnlsTol = 1e-6, msTol = 1e-11, maxIter = 500, pnlsMaxIter = 50, msMaxIter = 500, minScale = 1e-8)
loose <- nlmeControl(tolerance = 1e-6, pnlsTol = 1e-4, msTol = 1e-9, maxIter = 500, pnlsMaxIter = 50, msMaxIter = 500, minScale = 1e-8)
curved_gnls <- gnlsControl(tolerance = 1e-9, nlsTol = 1e-7, msTol = 1e-11, maxIter = 500, nlsMaxIter = 50, msMaxIter = 500, minScale = 1e-9)

fits <- list()
record <- function(id, data, formula, correlation, fit, parameters = NULL, random = "", covariance = "", variance = "") {
  fit <- tryCatch(eval(substitute(fit)), error = function(e) conditionMessage(e))
  if (is.character(fit)) {
    message(id, ": ", fit)
    return(invisible())
  }
  is_mixed <- inherits(fit, "lme")
  own <- c(coef(fit$modelStruct$corStruct, unconstrained = FALSE))
  fits[[length(fits) + 1]] <<- list(
    id = id, data = data, formula = formula, parameters = I(as.character(parameters)), random = random, covariance = covariance, variance = variance,
    correlation = correlation, call = paste(deparse(fit$call), collapse = " "), reml = isTRUE(fit$method == "REML"), n = fit$dims$N,
    log_likelihood = as.numeric(logLik(fit)), aic = AIC(fit), estimate = I(unname(if (is_mixed) fixef(fit) else coef(fit))),
    std_errors = I(unname(summary(fit)$tTable[, 2])), sigma = fit$sigma, values = I(unname(own)),
    normalized = I(unname(head(as.vector(resid(fit, type = "normalized")), 12))),
    variance_values = I(as.numeric(coef(fit$modelStruct$varStruct, unconstrained = FALSE))))
  message(id, " ", format(as.numeric(logLik(fit)), digits = 12), " ", paste(format(own, digits = 8), collapse = " "))
}

# Ovary: linear, and the nonlinear model with an estimated frequency
waves <- "follicles ~ a + b*sin(2*pi*Time) + c*cos(2*pi*Time)"
ovary <- function(correlation, method = "REML") {
  lme(follicles ~ sin(2 * pi * Time) + cos(2 * pi * Time), data = as.data.frame(Ovary), random = list(Mare = pdDiag(~ sin(2 * pi * Time))), correlation = correlation,
      control = linear, method = method)
}
mares <- function(id, correlation, fit) record(id, "Ovary", waves, correlation, fit, random = "a + b | Mare", covariance = "diagonal")
mares("ovary_ar1", "ar1", ovary(corAR1()))
mares("ovary_ar1_ml", "ar1", ovary(corAR1(), "ML"))
mares("ovary_ma2", "arma(0, 2)", ovary(corARMA(q = 2)))
mares("ovary_car1", "car1(Time)", ovary(corCAR1(form = ~ Time)))
mares("ovary_arma11", "arma(1, 1)", ovary(corARMA(p = 1, q = 1)))
mares("ovary_ar2", "arma(2, 0)", ovary(corARMA(p = 2, q = 0)))
record("ovary_nlme_ar1", "Ovary", "follicles ~ A + B*sin(2*pi*w*Time) + C*cos(2*pi*w*Time)", "ar1",
       nlme(follicles ~ A + B * sin(2 * pi * w * Time) + C * cos(2 * pi * w * Time), data = as.data.frame(Ovary), fixed = A + B + C + w ~ 1,
            random = list(Mare = pdDiag(A ~ 1)), start = c(12.18, -3.298, -0.862, 1), correlation = corAR1(0.5), control = loose),
       random = "A | Mare")

# BodyWeight: rats over time, power variance
growth <- function(correlation) {
  lme(weight ~ Time * Diet, as.data.frame(BodyWeight), random = ~ Time | Rat, weights = varPower(), correlation = correlation, control = linear)
}
rats <- function(id, correlation, fit) {
  record(id, "BodyWeight", "weight ~ a + b*Time", correlation, fit, parameters = c("a ~ factor(Diet)", "b ~ factor(Diet)"), random = "a + b | Rat", variance = "power")
}
rats("bodyweight_exponential", "exponential(Time)", growth(corExp(form = ~ Time)))
rats("bodyweight_nugget", "exponential(Time; nugget)", growth(corExp(form = ~ Time, nugget = TRUE)))
rats("bodyweight_rational", "rational-quadratic(Time)", growth(corRatio(form = ~ Time)))
rats("bodyweight_spherical", "spherical(Time)", growth(corSpher(form = ~ Time)))
rats("bodyweight_linear", "linear(Time)", growth(corLin(form = ~ Time)))
rats("bodyweight_gaussian", "gaussian(Time)", growth(corGaus(form = ~ Time)))

# Orthodont: general, compound symmetry
ages <- function(correlation, weights = NULL) {
  gls(distance ~ Sex * I(age - 11), children, correlation = correlation, weights = weights, control = general)
}
child_fits <- function(id, correlation, fit, variance = "") {
  record(id, "Orthodont", "distance ~ a + b*(age - 11)", correlation, fit, parameters = c("a ~ Sex", "b ~ Sex"), variance = variance)
}
child_fits("orthodont_symmetric", "symmetric(1 | Subject)", ages(corSymm(form = ~ 1 | Subject), varIdent(form = ~ 1 | age)), "stratum(age)")
child_fits("orthodont_compound", "compound-symmetry(1 | Subject)", ages(corCompSymm(form = ~ 1 | Subject)))
child_fits("orthodont_compound_sex", "compound-symmetry(1 | Subject)", ages(corCompSymm(form = ~ 1 | Subject), varIdent(form = ~ 1 | Sex)), "stratum(Sex)")

# Dialyzer: polynomials, and the nonlinear model
record("dialyzer_gls_ar1", "Dialyzer", "rate ~ a + b*pressure + c*pressure^2 + d*pressure^3 + e*pressure^4", "ar1(1 | Subject)",
       gls(rate ~ (pressure + I(pressure^2) + I(pressure^3) + I(pressure^4)) * factor(QB), as.data.frame(Dialyzer), weights = varPower(form = ~ pressure),
           correlation = corAR1(0.771, form = ~ 1 | Subject), control = general),
       parameters = paste(c("a", "b", "c", "d", "e"), "~ factor(QB)"), variance = "power(pressure)")
dialyzer <- function(control) {
  gnls(rate ~ SSasympOff(pressure, Asym, lrc, c0), data = as.data.frame(Dialyzer), params = list(Asym + lrc ~ factor(QB), c0 ~ 1),
       start = c(53.6, 8.6, 0.51, -0.26, 0.225), weights = varPower(form = ~ pressure), correlation = corAR1(0.716, form = ~ 1 | Subject), control = control)
}
record("dialyzer_gnls_ar1", "Dialyzer", "rate ~ Asym*(1 - exp(-exp(lrc)*(pressure - c0)))", "ar1(1 | Subject)",
       tryCatch(dialyzer(curved_gnls), error = function(e) dialyzer(gnlsControl())),
       parameters = c("Asym ~ factor(QB)", "lrc ~ factor(QB)"), variance = "power(pressure)")

# Wheat2: a field trial
field <- function(correlation) gls(yield ~ variety - 1, as.data.frame(Wheat2), correlation = correlation, control = general)
plots <- function(id, correlation, fit) record(id, "Wheat2", "yield ~ m", correlation, fit, parameters = "m ~ 0 + variety")
plots("wheat2_spherical", "spherical(latitude, longitude; nugget)", field(corSpher(c(37.4, 0.17), form = ~ latitude + longitude, nugget = TRUE)))
plots("wheat2_rational", "rational-quadratic(latitude, longitude; nugget)", field(corRatio(c(12.5, 0.2), form = ~ latitude + longitude, nugget = TRUE)))

# Spruce: trees over time
spruces <- function(correlation) lme(logSize ~ days + I(days^2), as.data.frame(Spruce), random = ~ 1 | Tree, correlation = correlation, control = linear)
record("spruce_exponential", "Spruce", "logSize ~ a + b*days + c*days^2", "exponential(days)", spruces(corExp(form = ~ days)), random = "a | Tree")
record("spruce_nugget", "Spruce", "logSize ~ a + b*days + c*days^2", "exponential(days; nugget)", spruces(corExp(form = ~ days, nugget = TRUE)), random = "a | Tree")

# Soybean: logistic growth
soybean <- function(correlation, control) {
  nlme(weight ~ SSlogis(Time, Asym, xmid, scal), data = as.data.frame(Soybean), fixed = Asym + xmid + scal ~ 1, random = list(Plot = pdDiag(Asym + xmid ~ 1)),
       start = c(19.3, 55, 8.4), weights = varPower(), correlation = correlation, control = control)
}
record("soybean_ar1", "Soybean", "weight ~ Asym/(1 + exp((xmid - Time)/scal))", "ar1",
       tryCatch(soybean(corAR1(0.2, form = ~ 1), curved), error = function(e) soybean(corAR1(0.2, form = ~ 1), loose)),
       random = "Asym + xmid | Plot", covariance = "diagonal", variance = "power")
record("soybean_car1", "Soybean", "weight ~ Asym/(1 + exp((xmid - Time)/scal))", "car1(Time)",
       tryCatch(soybean(corCAR1(0.9, form = ~ Time), curved), error = function(e) soybean(corCAR1(0.9, form = ~ Time), loose)),
       random = "Asym + xmid | Plot", covariance = "diagonal", variance = "power")

# Oats: two nested levels
record("oats_ar1", "Oats", "yield ~ a + b*nitro", "ar1",
       lme(yield ~ nitro, as.data.frame(Oats), random = ~ 1 | Block/Variety, correlation = corAR1(), control = linear), random = "a | Block/Variety")
record("oats_ma1_ml", "Oats", "yield ~ a + b*nitro", "arma(0, 1)",
       lme(yield ~ nitro, as.data.frame(Oats), random = ~ 1 | Block/Variety, correlation = corARMA(q = 1), control = linear, method = "ML"), random = "a | Block/Variety")

# stem analysis
record("stems_car1", "stems", "h ~ a*(1 - exp(-k*age))^c", "car1(age)",
       nlme(h ~ a * (1 - exp(-k * age))^c, data = stems, fixed = a + k + c ~ 1, random = a ~ 1 | tree, start = c(30, 0.03, 1.3),
            correlation = corCAR1(0.9, form = ~ age | tree), control = loose), random = "a | tree")

meta <- list(R = R.version.string, nlme = as.character(packageVersion("nlme")), script = "bench/r/reference_correlation.R")
jsonlite::write_json(list(meta = meta, fits = fits), file.path(root, "tests/reference/expected/nlme_correlation.json"), digits = 15, auto_unbox = TRUE, pretty = TRUE)
