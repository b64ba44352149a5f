# SPDX-License-Identifier: MIT
# Shared by the tests; sourced at their beginning.
library(silvafit)

# The largest relative difference, to the scale of the second values.
relative <- function(a, b) max(abs(a - b)) / max(abs(b))

# The folder tests/reference of the checkout, or "".
reference <- function(...) {
  root <- Sys.getenv("SILVAFIT_CHECKOUT")
  if (root == "") return("")
  path <- file.path(root, "tests", "reference", ...)
  if (file.exists(path)) path else ""
}

# The program, or "".
program <- function() {
  root <- Sys.getenv("SILVAFIT_CHECKOUT")
  path <- file.path(root, "build", "bin", "silvafit")
  if (root != "" && file.exists(path)) path else ""
}

skipped <- function(reason) message("  skipped: ", reason)

class_of_error <- function(expression) tryCatch({ expression; "none" }, error = function(e) class(e)[1])
message_of_error <- function(expression) tryCatch({ expression; "none" }, error = conditionMessage)
