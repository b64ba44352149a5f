# SPDX-License-Identifier: MIT
# Writes the data sets of R's nlme and MASS that the scorecard's family "books" reads, and the sample trees of lmfor's
# spati, into bench/scorecard/data-gpl. They are under the GPL; the folder's README names their sources.
# Usage: Rscript bench/scorecard/write_data.R SPATI.csv   (write.csv(lmfor::spati, "spati.csv"))
suppressPackageStartupMessages({ library(nlme); library(MASS) })
folder <- "bench/scorecard/data-gpl"

write <- function(data, name) {
  data <- as.data.frame(data)
  for (column in names(data)) if (is.factor(data[[column]])) data[[column]] <- as.character(data[[column]])
  write.csv(data, file.path(folder, paste0(name, ".csv")), row.names = FALSE, quote = FALSE)
}

for (name in c("Indometh", "Soybean", "Orange", "Theoph", "CO2", "Ovary", "Dialyzer", "Loblolly", "ChickWeight", "Rabbit", "Sitka",
               "PBG", "Cefamandole", "Spruce", "Nitrendipene", "Orthodont", "Oxide", "BodyWeight", "RatPupWeight", "IGF", "Milk"))
  write(get(name), name)
write(transform(as.data.frame(Wafer), v2 = voltage^2), "Wafer")
write(transform(as.data.frame(Pixel), day2 = day^2), "Pixel")
write(transform(as.data.frame(Dialyzer), p2 = pressure^2, p3 = pressure^3, p4 = pressure^4), "Dialyzer")

# lmfor's second variance covariate: mean and standard deviation of the plot's sample trees.
spati <- read.csv(commandArgs(trailingOnly = TRUE)[1])
spati <- spati[!is.na(spati$h) & !is.na(spati$d), c("plot", "d", "h")]
of_plot <- function(f) ave(spati$d, spati$plot, FUN = f)
spati$w2 <- pmax(1, (spati$d - of_plot(mean)) / of_plot(sd) + 3)
write(spati, "spati")
