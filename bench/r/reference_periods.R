# SPDX-License-Identifier: MIT
# Repeated measurements: a simulated inventory, and a height curve of nlme with random effects of the plots and of the years within them.
#   Rscript reference_periods.R CHECKOUT
# Writes tests/reference/data/repeated.csv and tests/reference/expected/nlme_periods.json. Debian: r-cran-nlme.
suppressMessages(library(nlme))
root <- commandArgs(trailingOnly = TRUE)[1]
set.seed(20260411)
plots <- 10
trees <- 14
years <- c(2005, 2012, 2019)
true <- list(a = 26, b = 0.05, sd_plot = 2.5, sd_year = 1.2, sigma = 0.6)
of_plot <- rnorm(plots, sd = true$sd_plot)
of_year <- matrix(rnorm(plots * length(years), sd = true$sd_year), plots)
data <- expand.grid(tree = seq_len(trees), year = years, plot = seq_len(plots))[c("plot", "tree", "year")]
start <- matrix(runif(plots * trees, 6, 34), plots)
growth <- matrix(runif(plots * trees, 0.2, 0.6), plots)
at <- cbind(data$plot, data$tree)
data$dbh <- round(start[at] + growth[at] * (data$year - years[1]), 1)
limit <- true$a + of_plot[data$plot] + of_year[cbind(data$plot, match(data$year, years))]
data$h <- round(1.3 + limit * (1 - exp(-true$b * data$dbh)) + rnorm(nrow(data), sd = true$sigma), 2)
write.csv(data, file.path(root, "tests/reference/data/repeated.csv"), row.names = FALSE, quote = FALSE)

fit_of <- function(random) {
  nlme(h ~ 1.3 + a * (1 - exp(-b * dbh)), data = data, fixed = a + b ~ 1, random = random, start = c(a = true$a, b = true$b), method = "ML",
       control = nlmeControl(tolerance = 1e-7, pnlsTol = 1e-4, msTol = 1e-10, maxIter = 200))
}
plot <- fit_of(list(plot = a ~ 1))
both <- fit_of(list(plot = a ~ 1, year = a ~ 1))
# VarCorr() rounds; the factors of the covariances do not.
sds <- sapply(rev(as.matrix(both$modelStruct$reStruct)), function(psi) sqrt(psi[1, 1])) * both$sigma
texts <- c(
  sprintf('"R": "%s"', R.version.string), sprintf('"nlme": "%s"', packageVersion("nlme")), '"script": "bench/r/reference_periods.R"',
  sprintf('"n": %d', nrow(data)), sprintf('"log_likelihood_plot": %.15g', as.numeric(logLik(plot))),
  sprintf('"log_likelihood": %.15g', as.numeric(logLik(both))), sprintf('"AIC": %.15g', AIC(both)), sprintf('"BIC": %.15g', BIC(both)),
  sprintf('"a": %.15g', fixef(both)["a"]), sprintf('"b": %.15g', fixef(both)["b"]),
  sprintf('"sd_plot": %.15g', sds[["plot"]]), sprintf('"sd_year": %.15g', sds[["year"]]), sprintf('"sigma": %.15g', both$sigma),
  sprintf('"effects_of_plots": [%s]', paste(sprintf("%.12g", ranef(both)$plot[as.character(1:plots), "a"]), collapse = ", ")),
  sprintf('"effects_of_plot_1": [%s]', paste(sprintf("%.12g", ranef(both)$year[paste0("1/", years), "a"]), collapse = ", ")))
writeLines(c("{", paste0("  ", texts, c(rep(",", length(texts) - 1), "")), "}"), file.path(root, "tests/reference/expected/nlme_periods.json"))
