# SPDX-License-Identifier: MIT
# Fits the recorded models of the study and of public data again, from their recorded estimates, and prints how far the
# figures of tests/reference/expected are from what R finds.
# Usage, in bench/r: Rscript check_study.R [PATTERN]      of the fits whose id has the pattern; "." takes some half hour for
# the mixed models, and without a pattern these are left out
source("json.R")
library(nlme)
pattern <- commandArgs(TRUE)

trees <- read_data("fir_mixed/inventory.csv")
trees <- merge(trees, read_data("fir_mixed/indices.csv")[c("tree", "W", "M", "U", "C", "in_core", "in_core_plot")], by = "tree")

# The rows that a recorded fit used, ordered as there.
rows_of <- function(fit, core) {
  if (!is.null(fit$species)) return(trees[trees$species == fit$species & trees[[core]] == 1, ])
  name <- sub(":.*", "", fit$data)
  data <- read_data(name)
  if (name == "spati.csv") data <- data[data$pl == 1 & data$d > 0 & !is.na(data$h), ]
  if (name == "alsTree.csv") data <- data[!is.na(data$HCB + data$H + data$DBH), ]
  data
}

least_squares <- function(fit, data) {
  again <- nls(as.formula(fit$formula), data, start = as.list(fit$estimates), control = nls.control(tol = 1e-6, warnOnly = TRUE))
  c(likelihood = as.numeric(logLik(again)) - fit$logLik, estimates = largest(coef(again), fit$estimates),
    errors = largest(summary(again)$coefficients[, 2], fit$std_errors))
}

weights_of <- function(fit) switch(fit$varfun, none = NULL, varExp = varExp(unlist(fit$varfun_params)), varPower = varPower(unlist(fit$varfun_params)),
                                   varConstPower = varConstPower(fit$varfun_params$const, fit$varfun_params$power))

mixed <- function(fit, data) {
  data$group <- factor(data[[fit$group]])
  random <- as.formula(paste(paste(fit$random_names, collapse = " + "), "~ 1 | group"))
  again <- nlme(as.formula(fit$formula), data, fixed = as.formula(fit$fixed), random = random, weights = weights_of(fit),
                start = unlist(fit$estimates), control = nlmeControl(maxIter = 200, msMaxIter = 200, returnObject = TRUE))
  c(likelihood = as.numeric(logLik(again)) - fit$logLik, estimates = largest(fixef(again), fit$estimates),
    errors = largest(summary(again)$tTable[, 2], fit$std_errors))
}

# The largest relative difference.
largest <- function(found, recorded) max(abs(found / unlist(recorded)[names(found)] - 1))

check <- function(name, core = "in_core") {
  for (fit in fromJSON(file.path(expected_folder, name), simplifyVector = FALSE)$fits) {
    is_mixed <- !is.null(fit$random_names)
    if (if (length(pattern)) !grepl(pattern, fit$id) else is_mixed) next
    found <- tryCatch((if (is_mixed) mixed else least_squares)(fit, rows_of(fit, core)), error = function(e) conditionMessage(e))
    cat(name, fit$id, if (is.character(found)) found else sprintf("%s %.1e", names(found), found), "\n")
  }
}

check("fir_mixed_base_models.json")
check("fir_mixed_nlme.json")
check("fir_mixed_nlme_plotbuffer.json", "in_core_plot")
check("public_nlme.json")
