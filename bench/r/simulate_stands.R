# SPDX-License-Identifier: MIT
# Draws tests/reference/data/stands.csv: trees of two species on 8 stands of 4 plots each, nothing measured.
# Heights: 1.3 + a (1 - exp(-(b + c crowding) dbh / 10)) with effects of the stand on a and of the plot on
# a, b and c; residual standard deviation 0.4 + 0.045 mu, times 1.4 for BHN.
# Run from this folder: Rscript simulate_stands.R
set.seed(639, kind = "Mersenne-Twister", normal.kind = "Inversion", sample.kind = "Rejection")

fixed <- c(a = 28, b = 0.45, c = 0.08)
stand_sd <- 2
plot_sd <- c(2.5, 0.08, 0.06)
plot_correlation <- matrix(c(1, -0.3, 0, -0.3, 1, 0, 0, 0, 1), 3)
plot_factor <- t(chol(diag(plot_sd) %*% plot_correlation %*% diag(plot_sd)))

plots <- list()
for (stand in 1:8) {
  stand_effect <- rnorm(1, 0, stand_sd)
  for (plot in 1:4) {
    trees <- sample(8:50, 1)
    effects <- as.vector(plot_factor %*% rnorm(3))
    species <- ifelse(runif(trees) < 0.6, "SM", "BHN")
    dbh <- round(5 + rgamma(trees, shape = 2.5, scale = 7), 1)
    crowding <- sample(0:4, trees, replace = TRUE) / 4
    mean <- 1.3 + (fixed["a"] + stand_effect + effects[1]) *
      (1 - exp(-(fixed["b"] + effects[2] + (fixed["c"] + effects[3]) * crowding) * dbh / 10))
    sd <- (0.4 + 0.045 * mean) * ifelse(species == "BHN", 1.4, 1)
    plots[[length(plots) + 1]] <- data.frame(
      stand = paste0("S", stand), plot = paste0("S", stand, "P", plot), number = plot, species = species,
      dbh = dbh, crowding = crowding, h = round(rnorm(trees, mean, sd), 2))
  }
}
stands <- do.call(rbind, plots)
stands <- cbind(tree = seq_len(nrow(stands)), stands)
stopifnot(all(stands$h > 1.3))
write.csv(stands, "../../tests/reference/data/stands.csv", row.names = FALSE, quote = FALSE)
for (name in c("Orange", "Loblolly")) {
  data <- as.data.frame(get(name))
  data[[1 + (name == "Loblolly") * 2]] <- as.character(data[[1 + (name == "Loblolly") * 2]])
  write.csv(data, paste0("../../tests/reference/data-gpl/", name, ".csv"), row.names = FALSE, quote = FALSE)
}
