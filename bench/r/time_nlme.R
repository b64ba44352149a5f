# SPDX-License-Identifier: MIT
# Times R's nlme on the files of silvafit_bench_inference: CPU seconds of the call alone, with analytic gradients and the
# pooled least-squares fit as start. Usage: Rscript time_nlme.R FOLDER [repeats] [large]
library(nlme)
library(jsonlite)
arguments <- commandArgs(trailingOnly = TRUE)
folder <- arguments[1]
repeats <- if (length(arguments) > 1) as.integer(arguments[2]) else 3
files <- list.files(folder, "^heights_.*\\.csv$", full.names = TRUE)
if (!("large" %in% arguments)) files <- files[!grepl("heights_100000_", files)]

height <- deriv(~ 1.3 + a * (1 - exp(-(b + c * C) * D)), c("a", "b", "c"), c("a", "b", "c", "C", "D"))
cpu <- function(expression) { t <- system.time(expression); t[["user.self"]] + t[["sys.self"]] }

results <- lapply(files, function(file) {
  trees <- read.csv(file)
  trees$plot <- factor(trees$plot, levels = unique(trees$plot))
  start <- coef(nls(H ~ height(a, b, c, C, D), trees, start = c(a = 30, b = 0.03, c = 0)))
  weights <- if (grepl("power", file)) varPower() else NULL
  fit <- NULL
  message <- "converged"
  seconds <- vapply(seq_len(repeats), function(i) cpu(
    fit <<- tryCatch(nlme(H ~ height(a, b, c, C, D), data = trees, fixed = a + b + c ~ 1, random = a + b ~ 1 | plot, start = start, weights = weights,
                          method = "ML"), error = function(e) { message <<- conditionMessage(e); NULL })), 0)
  name <- sub("\\.csv$", "", basename(file))
  cat(name, median(seconds), message, "\n", file = stderr())
  list(name = name, program = "nlme", seconds = median(seconds), repeats = repeats, message = message,
       log_likelihood = if (is.null(fit)) NA else as.numeric(logLik(fit)))
})
writeLines(toJSON(list(R = R.version.string, nlme = as.character(packageVersion("nlme")), results = results), auto_unbox = TRUE, digits = 12, na = "null"),
           file.path(folder, "nlme.json"))
