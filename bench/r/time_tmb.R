# SPDX-License-Identifier: MIT
# Times TMB's Laplace fits on the files of silvafit_bench_inference: CPU seconds of the optimization alone, without
# MakeADFun and sdreport. Usage: Rscript time_tmb.R FOLDER [repeats] [large]
library(TMB)
library(jsonlite)
arguments <- commandArgs(trailingOnly = TRUE)
folder <- arguments[1]
repeats <- if (length(arguments) > 1) as.integer(arguments[2]) else 3
files <- list.files(folder, "^heights_.*\\.csv$", full.names = TRUE)
if (!("large" %in% arguments)) files <- files[!grepl("heights_100000_", files)]

source_folder <- dirname(sub("--file=", "", grep("--file=", commandArgs(), value = TRUE)))
stopifnot(file.copy(file.path(source_folder, "height.cpp"), folder, overwrite = TRUE))
compile(file.path(folder, "height.cpp"), flags = "-O2 -Wno-ignored-attributes")
dyn.load(dynlib(file.path(folder, "height")))
cpu <- function(expression) { t <- system.time(expression); t[["user.self"]] + t[["sys.self"]] }

results <- lapply(files, function(file) {
  trees <- read.csv(file)
  plot <- match(trees$plot, unique(trees$plot)) - 1
  has_power <- grepl("power", file)
  pooled <- nls(H ~ 1.3 + a * (1 - exp(-(b + c * C) * D)), trees, start = c(a = 30, b = 0.03, c = 0))
  start <- list(beta = unname(coef(pooled)) * c(1, 100, 100), plot_factor = c(1, 0, 0.2), log_sigma = log(summary(pooled)$sigma), delta = 0,
                effect = matrix(0, 2, max(plot) + 1))
  best <- NULL
  seconds <- vapply(seq_len(repeats), function(i) {
    # Made anew each time, so that the inner modes do not start where the last run ended.
    object <- MakeADFun(list(H = trees$H, D = trees$D, C = trees$C, plot = plot), start, random = "effect",
                        map = if (has_power) list() else list(delta = factor(NA)), DLL = "height", silent = TRUE)
    cpu(best <<- nlminb(object$par, object$fn, object$gr, control = list(eval.max = 1000, iter.max = 500)))
  }, 0)
  name <- sub("\\.csv$", "", basename(file))
  cat(name, median(seconds), best$message, "\n", file = stderr())
  list(name = name, program = "TMB", seconds = median(seconds), repeats = repeats, message = best$message, log_likelihood = -best$objective)
})
writeLines(toJSON(list(R = R.version.string, TMB = as.character(packageVersion("TMB")), results = results), auto_unbox = TRUE, digits = 12, na = "null"),
           file.path(folder, "tmb.json"))
