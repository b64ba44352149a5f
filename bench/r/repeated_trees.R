# SPDX-License-Identifier: MIT
# Simulates crown widths of trees that were measured at three times, and fits them with effects of
# plots, of trees and of times within plots by lme4.
# Rscript bench/r/repeated_trees.R tests/cli/sheets/repeated-trees
suppressMessages(library(lme4))
target <- commandArgs(TRUE)[1]
set.seed(5)
trees <- expand.grid(tree = 1:12, plot = 1:8)
years <- c(2010, 2015, 2020)
first <- runif(nrow(trees), 8, 40)
of_tree <- rnorm(nrow(trees), 0, 0.6)
of_plot <- rnorm(8, 0, 0.5)
of_year <- matrix(rnorm(8 * 3, 0, 0.25), 8)
rows <- do.call(rbind, lapply(seq_along(years), function(k) {
  dbh <- round(first + (k - 1) * runif(nrow(trees), 1, 3), 1)
  mean <- 3 + of_plot[trees$plot] + of_year[cbind(trees$plot, k)] + of_tree + 0.14 * dbh
  data.frame(trees[c("plot", "tree")], species = "fir", year = years[k], dbh = dbh, cw = round(mean + rnorm(nrow(trees), 0, 0.3), 2))
}))
write.csv(rows[order(rows$plot, rows$tree, rows$year), ], paste0(target, ".csv"), row.names = FALSE, quote = FALSE)
fit <- lmer(cw ~ dbh + (1 | plot) + (1 | plot:tree) + (1 | plot:year), rows, REML = FALSE, control = lmerControl(optCtrl = list(xtol_abs = 1e-12, ftol_abs = 1e-12)))
without <- lmer(cw ~ dbh + (1 | plot) + (1 | plot:year), rows, REML = FALSE)
number <- function(x) format(x, digits = 12)
cat(sprintf('{"log_likelihood": %s, "slope": %s, "slope_se": %s, "slope_se_without_trees": %s, "sd_tree": %s}\n',
            number(as.numeric(logLik(fit))), number(fixef(fit)[["dbh"]]), number(sqrt(diag(vcov(fit)))[["dbh"]]),
            number(sqrt(diag(vcov(without)))[["dbh"]]), number(attr(VarCorr(fit)[["plot:tree"]], "stddev")[[1]])),
    file = paste0(target, ".json"))
