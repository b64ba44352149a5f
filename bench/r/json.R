# SPDX-License-Identifier: MIT
# How reference figures are written: 15 digits, one file a script, with what made them.
library(jsonlite)

data_folder <- "../../tests/reference/data"
gpl_folder <- "../../tests/reference/data-gpl"
expected_folder <- "../../tests/reference/expected"

read_data <- function(name) {
  own <- file.path(data_folder, name)
  read.csv(if (file.exists(own)) own else file.path(gpl_folder, name), stringsAsFactors = FALSE)
}

versions <- function(...) {
  list(R = R.version.string, packages = setNames(lapply(c(...), function(x) as.character(packageVersion(x))), c(...)))
}

write_expected <- function(name, meta, fits) {
  writeLines(toJSON(list(meta = meta, fits = fits), digits = 15, auto_unbox = TRUE, pretty = 1, null = "null", na = "null"),
             file.path(expected_folder, name))
}

# A vector with names as an object, a matrix as rows.
named <- function(x) as.list(x)
