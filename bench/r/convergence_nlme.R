# SPDX-License-Identifier: MIT
# nlme on the inventories of silvafit_bench_convergence: how many converge, with default control and with more
# iterations. Analytic gradients; the start is the pooled least-squares fit.
# A fit may take a minute of CPU time. Usage: Rscript convergence_nlme.R FOLDER default|raised [inventories]
suppressPackageStartupMessages({ library(nlme); library(jsonlite) })
arguments <- commandArgs(trailingOnly = TRUE)
folder <- arguments[1]
all <- read.csv(file.path(folder, "inventories.csv"))
wanted <- arguments[2]
count <- if (length(arguments) > 2) as.integer(arguments[3]) else max(all$inventory)

height <- deriv(~ 1.3 + a * (1 - exp(-(b + c * C) * D)), c("a", "b", "c"), c("a", "b", "c", "C", "D"))
controls <- list(default = nlmeControl(), raised = nlmeControl(maxIter = 200, pnlsMaxIter = 50, msMaxIter = 500))
limit_s <- 60

one <- function(number, control) {
  trees <- all[all$inventory == number, ]
  trees$plot <- factor(trees$plot)
  start <- coef(nls(H ~ height(a, b, c, C, D), trees, start = c(a = 30, b = 0.03, c = 0), control = nls.control(warnOnly = TRUE)))
  begin <- proc.time()
  setTimeLimit(elapsed = 4 * limit_s, cpu = limit_s, transient = TRUE)
  fit <- tryCatch(nlme(H ~ height(a, b, c, C, D), data = trees, fixed = a + b + c ~ 1, random = a + b + c ~ 1 | plot, start = start, method = "ML",
                       control = control), error = function(e) conditionMessage(e))
  setTimeLimit()
  seconds <- sum((proc.time() - begin)[c("user.self", "sys.self")])
  failed <- is.character(fit)
  list(inventory = number, converged = !failed, seconds = seconds, log_likelihood = if (failed) NA else as.numeric(logLik(fit)),
       message = if (failed) sub("reciprocal condition number = .*", "", fit) else "converged")
}
results <- lapply(controls[wanted], function(control) suppressWarnings(lapply(seq_len(count), one, control = control)))
for (name in names(results)) {
  messages <- vapply(results[[name]], `[[`, "", "message")
  seconds <- vapply(results[[name]], `[[`, 0, "seconds")
  cat("nlme,", name, "control:", sum(messages == "converged"), "of", count, "converged; median", 1000 * median(seconds), "ms, longest", max(seconds), "s\n")
  print(sort(table(messages[messages != "converged"]), decreasing = TRUE))
}
writeLines(toJSON(results, auto_unbox = TRUE, digits = 12, na = "null"), file.path(folder, paste0("convergence_nlme_", wanted, ".json")))
