# SPDX-License-Identifier: MIT
# A long fit ends soon after an interrupt, and R goes on.
source("helpers.R", local = TRUE)
if (.Platform$OS.type != "unix") exit_file("skipped: no signals")
script <- tempfile(fileext = ".R")
writeLines(c(
  "library(silvafit)",
  "set.seed(1)",
  "n <- 40000",
  "trees <- data.frame(plot = factor(rep(seq_len(n / 20), each = 20)), dbh = runif(n, 5, 50))",
  "trees$h <- 1.3 + (25 + 3 * rnorm(n / 20)[trees$plot]) * (1 - exp(-(0.06 + 0.01 * rnorm(n / 20)[trees$plot]) * trees$dbh))^(1.3 + 0.1 * rnorm(n / 20)[trees$plot]) + rnorm(n)",
  "cat('started', Sys.getpid(), '\\n'); flush(stdout())",
  "result <- tryCatch(silvafit(h ~ 1.3 + a * (1 - exp(-b * dbh))^c, data = trees, random = a + b + c ~ 1 | plot, method = 'agq', starts = 50),",
  "                   interrupt = function(e) 'interrupted')",
  "cat(if (identical(result, 'interrupted')) 'interrupted' else 'finished', sum(1:3), '\\n')"), script)
output <- tempfile()
libraries <- paste0("R_LIBS=", paste(.libPaths(), collapse = ":"))
system(paste(libraries, shQuote(file.path(R.home("bin"), "Rscript")), shQuote(script), ">", shQuote(output), "2>&1 &"))
lines <- character()
for (i in 1:300) {
  Sys.sleep(0.1)
  if (file.exists(output)) lines <- readLines(output, warn = FALSE)
  if (any(grepl("^started", lines))) break
}
pid <- as.integer(strsplit(grep("^started", lines, value = TRUE), " ")[[1]][2])
Sys.sleep(2)
tools::pskill(pid, tools::SIGINT)
for (i in 1:300) {
  Sys.sleep(0.1)
  lines <- readLines(output, warn = FALSE)
  if (any(grepl("^(interrupted|finished)", lines))) break
}
if (!any(grepl("^interrupted", lines))) tools::pskill(pid)
expect_true(any(grepl("^interrupted 6", lines)))

# A time limit is an error that can be caught.
set.seed(1)
n <- 20000
trees <- data.frame(plot = factor(rep(seq_len(n / 20), each = 20)), dbh = runif(n, 5, 50))
trees$h <- 1.3 + (25 + 3 * rnorm(n / 20)[trees$plot]) * (1 - exp(-(0.06 + 0.01 * rnorm(n / 20)[trees$plot]) * trees$dbh))^(1.3 + 0.1 * rnorm(n / 20)[trees$plot]) + rnorm(n)
limited <- tryCatch({
  setTimeLimit(elapsed = 0.5, transient = TRUE)
  silvafit(h ~ 1.3 + a * (1 - exp(-b * dbh))^c, data = trees, random = a + b + c ~ 1 | plot, method = "agq", starts = 50)
}, error = function(e) "stopped", finally = setTimeLimit())
expect_equal(limited, "stopped")
