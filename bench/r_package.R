# SPDX-License-Identifier: MIT
# Speed of the package for R beside nlme in one session: the whole call, at 1,000, 10,000 and 100,000 trees of 20 a plot.
#   R_LIBS=build/r-library Rscript bench/r_package.R [largest number of trees]
# Prints the CPU time of each call (user and system, of all threads), and the share of the time before and after the fit itself.
library(silvafit)
library(nlme)
largest <- c(as.numeric(commandArgs(TRUE)), 1e5)[1]

inventory <- function(count) {
  set.seed(count)
  plots <- count / 20
  plot <- rep(seq_len(plots), each = 20)
  dbh <- round(runif(count, 5, 50), 1)
  h <- 1.3 + (25 + rnorm(plots, sd = 3)[plot]) * (1 - exp(-(0.06 + rnorm(plots, sd = 0.008)[plot]) * dbh)) + rnorm(count)
  data.frame(plot = factor(plot), dbh = dbh, h = round(h, 1))
}
cpu <- function(expression) sum(system.time(expression)[c("user.self", "sys.self")])
curve <- h ~ 1.3 + a * (1 - exp(-b * dbh))

cat(sprintf("%8s %12s %12s %12s %16s %14s\n", "trees", "silvafit [s]", "in C++ [s]", "nlme [s]", "conversion [%]", "difference"))
for (count in c(1e3, 1e4, 1e5)) {
  if (count > largest) next
  trees <- inventory(count)
  ours <- NULL
  time <- cpu(ours <- silvafit(curve, data = trees, random = a + b ~ 1 | plot))
  # The fit alone, without conversion of data and results.
  seconds <- ours$cpu_seconds
  theirs <- NULL
  other <- cpu(theirs <- tryCatch(nlme(curve, data = trees, fixed = a + b ~ 1, random = a + b ~ 1 | plot, start = c(a = 25, b = 0.06)), error = function(e) NULL))
  difference <- if (is.null(theirs)) NA else max(abs(fixef(ours) / fixef(theirs) - 1))
  cat(sprintf("%8d %12.2f %12.2f %12.2f %16.1f %14.1e\n", count, time, seconds, other, 100 * (time - seconds) / time, difference))
}
