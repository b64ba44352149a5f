# SPDX-License-Identifier: MIT
# nlme's fits to plots so unlike that one curve through all of them runs away; it is given good starts, silvafit none.
# Run from this folder: Rscript reference_unlike_plots.R
suppressMessages(library(nlme))
source("json.R")
plots <- read_data("unlike_plots.csv")

fit_set <- function(set, formula, effects, start) {
  data <- plots[plots$set == set, ]
  data$plot <- factor(data$plot, levels = unique(data$plot))
  # The tightest tolerance of the penalized step at which nlme does not halve its steps for ever.
  for (tolerance in c(1e-8, 1e-6)) {
    control <- nlmeControl(tolerance = 1e-9, pnlsTol = tolerance, maxIter = 500, msTol = 1e-12)
    model <- try(nlme(as.formula(formula), data = data, fixed = a + b + c ~ 1, random = as.formula(paste(effects, "~ 1")),
                      groups = ~plot, start = start, method = "ML", control = control), silent = TRUE)
    if (!inherits(model, "try-error")) break
  }
  sd <- as.numeric(VarCorr(model)[, "StdDev"])
  list(set = set, formula = formula, random = paste(effects, "| plot"), log_likelihood = as.numeric(logLik(model)),
       fixed = named(fixef(model)), sd = head(sd, -1), sigma = model$sigma)
}

write_expected("nlme_unlike_plots.json", versions("nlme"), list(
  fit_set("logistic", "y ~ a/(1 + c*exp(-b*x))", "a", c(a = 19, b = 0.056, c = 5)),
  fit_set("hossfeld", "y ~ a/(1 + 1/(b*x^c))", "a", c(a = 20.9, b = 0.0104, c = 1.58)),
  fit_set("chapman-richards", "y ~ a*(1 - exp(-b*x))^c", "a", c(a = 20, b = 0.06, c = 1.8)),
  fit_set("two-effects", "y ~ a*(1 - exp(-b*x))^c", "a + b", c(a = 28.6, b = 0.076, c = 1.37))))
