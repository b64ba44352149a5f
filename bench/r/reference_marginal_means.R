# SPDX-License-Identifier: MIT
# Estimated marginal means of a linear model for libfit/src/model/marginal_means_test.cpp:
#   Rscript bench/r/reference_marginal_means.R
trees <- data.frame(
  species = c("A", "A", "A", "A", "A", "A", "B", "B", "B", "B", "B", "B", "C", "C", "C", "C", "C", "C"),
  site = c("u", "u", "u", "u", "v", "v", "u", "v", "v", "v", "v", "u", "u", "u", "v", "u", "v", "v"),
  z = c(1.2, 0.4, 2.2, 1.9, 0.3, 1.1, 0.7, 1.6, 2.4, 0.9, 1.3, 0.2, 1.8, 2.1, 0.6, 1.4, 0.5, 1.0),
  x = c(12, 25, 18, 31, 9, 22, 14, 27, 35, 19, 11, 24, 16, 29, 21, 33, 13, 26),
  y = c(10.1, 16.9, 14.8, 22.6, 7.7, 15.2, 9.9, 19.4, 26.1, 14.0, 10.2, 13.7, 13.9, 22.2, 13.1, 22.9, 8.8, 16.6))
# The mean of the intercept is that of the response at x = 0.
fit <- lm(y ~ species * z + site + x + x:species, trees)
grid <- list(x = 0)
for (means in list(emmeans::emmeans(fit, ~species, at = grid), emmeans::emmeans(fit, ~site, at = grid), emmeans::emtrends(fit, ~species, var = "x"))) {
  table <- as.data.frame(means)
  cat(paste(table[[1]], format(table[[2]], digits = 12), format(table$SE, digits = 12), table$df), sep = "\n")
}
