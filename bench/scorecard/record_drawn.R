# SPDX-License-Identifier: MIT
# Fits the drawn sets of the scorecard with nlme from the coefficients that they were drawn with, default control, and writes
# bench/scorecard/recorded/nlme-drawn.csv. A fit may take 20 s of CPU time.
#   bench/scorecard/scorecard.py --draw && Rscript bench/scorecard/record_drawn.R build/scorecard/data [FAMILY ...]
suppressPackageStartupMessages({ library(nlme); library(jsonlite) })
arguments <- commandArgs(trailingOnly = TRUE)
folder <- arguments[1]
families <- if (length(arguments) > 1) arguments[-1] else c("biexp", "fol", "near-singular", "emax")
target <- "bench/scorecard/recorded/nlme-drawn.csv"
limit_s <- 20

parameters <- function(fit) {
  random <- as.matrix(fit$modelStruct$reStruct[[1]]) * fit$sigma^2
  names <- sub("\\.\\(Intercept\\)$", "", rownames(random))
  sd <- sqrt(diag(random))
  found <- c(as.list(fixef(fit)), setNames(as.list(sd), paste0("sd(", names, ")")), sigma = fit$sigma)
  for (i in seq_along(names)) for (j in seq_len(i - 1))
    found[[paste0("cor(", names[j], ", ", names[i], ")")]] <- random[i, j] / sd[i] / sd[j]
  lapply(found, signif, 7)
}

one <- function(family, case, file, formula, random, start, weights = NULL) {
  data <- read.csv(file)
  begin <- proc.time()
  setTimeLimit(cpu = limit_s, transient = TRUE)
  fit <- tryCatch(suppressWarnings(do.call(nlme, list(formula, data = data, fixed = as.formula(paste(paste(names(start), collapse = " + "), "~ 1")),
                                                      random = random, start = start, weights = weights))),
                  error = function(e) conditionMessage(e))
  setTimeLimit()
  seconds <- sum((proc.time() - begin)[c("user.self", "sys.self")])
  failed <- is.character(fit)
  data.frame(family = family, case = case, method = "nlme", log_likelihood = if (failed) "" else sprintf("%.6f", logLik(fit)),
             converged = if (failed) "no" else "yes", ended = "yes", fit_seconds = sprintf("%.4g", seconds), cpu_seconds = sprintf("%.4g", seconds),
             estimates = if (failed) "{}" else as.character(toJSON(parameters(fit), auto_unbox = TRUE, digits = NA)),
             verdict = if (failed) substr(gsub("\\s+", " ", fit), 1, 80) else "")
}

rows <- list()
add <- function(...) {
  rows[[length(rows) + 1]] <<- one(...)
  if (length(rows) %% 50 == 0) message(length(rows), " fits")
}
both_sources <- function(family, draw) {
  for (i in 1:5) draw(sprintf("%s-given-%02d", family, i), sprintf("bench/scorecard/data/%s%02d.csv", family, i))
  for (i in 1:20) draw(sprintf("%s-%02d", family, i), file.path(folder, sprintf("%s%02d.csv", family, i)))
}
if ("biexp" %in% families)
  both_sources("biexp", function(case, file)
    add("biexp", case, file, y ~ A1 * exp(-exp(l1) * t) + A2 * exp(-exp(l2) * t), A1 ~ 1 | g, c(A1 = 2.8, l1 = 0.8, A2 = 0.5, l2 = -1.4)))
if ("fol" %in% families)
  both_sources("fol", function(case, file)
    add("fol", case, file, y ~ 4 * exp(lke + lka - lcl) * (exp(-exp(lke) * t) - exp(-exp(lka) * t)) / (exp(lka) - exp(lke)),
        lka + lcl ~ 1 | g, c(lka = 0.4, lke = -2.4, lcl = -3.2)))
if ("emax" %in% families)
  for (design in c("S1", "S2", "S3")) for (i in 1:10)
    add("emax", sprintf("emax-%s-%02d", design, i), file.path(folder, sprintf("emax_%s_%02d.csv", design, i)),
        y ~ exp(lE0) + exp(lEm) * D^g / (exp(g * lED) + D^g), list(id = pdBlocked(list(lEm + lED ~ 1, lE0 ~ 1))),
        c(lE0 = log(5), lEm = log(30), lED = log(500), g = c(S1 = 1, S2 = 3, S3 = 2)[[design]]),
        if (design == "S2") varPower(fixed = 1))
near_singular <- list(
  "linear-zero" = list(y ~ a + b * x, a + b ~ 1 | g, c(a = 10, b = 0.5)),
  "linear-one" = list(y ~ a + b * x, a + b ~ 1 | g, c(a = 10, b = 0.5)),
  "exponential-zero" = list(y ~ a * exp(-b * x), a + b ~ 1 | g, c(a = 20, b = 0.3)),
  "logistic-zero" = list(y ~ a / (1 + exp((b - x) / c)), a + b + c ~ 1 | g, c(a = 20, b = 9, c = 2.5)),
  "meyer-one" = list(y ~ 1.3 + a * (1 - exp(-b * x)), a + b ~ 1 | g, c(a = 25, b = 0.06)))
if ("near-singular" %in% families)
  for (design in names(near_singular)) for (i in 1:100)
    do.call(add, c(list("near-singular", sprintf("%s-%03d", design, i), file.path(folder, "near-singular", sprintf("%s-%03d.csv", design, i))),
                   near_singular[[design]]))

old <- if (file.exists(target)) subset(read.csv(target, colClasses = "character"), !family %in% families) else NULL
write.csv(rbind(old, do.call(rbind, rows)), target, row.names = FALSE, quote = 9:10)
