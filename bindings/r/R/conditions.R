# SPDX-License-Identifier: MIT
# Errors, warnings and messages with classes.

#' Conditions of silvafit
#'
#' Errors, warnings and messages of the package have classes, so that programs can handle them with
#' [tryCatch()] or [withCallingHandlers()] without reading their text.
#'
#' Errors have the class `silvafit_error` and one of these:
#'
#' * `silvafit_usage_error`: an argument is wrong; `silvafit_formula_error`: a formula cannot be read;
#' * `silvafit_input_error`: a column is missing or its values cannot be used;
#'   `silvafit_domain_error`: a value is outside the domain of a model;
#' * `silvafit_numerical_error`, `silvafit_geometry_error`, `silvafit_io_error`,
#'   `silvafit_memory_error`, `silvafit_other_error`.
#'
#' The elements `column`, `plot` and `tree` of an error say where it is, if this is known.
#'
#' A fit that has not converged gives a warning of class `silvafit_convergence_warning`; its element
#' `status` is that of [convergence()]. A boundary (singular) fit gives a message of class
#' `silvafit_boundary_message`. Notes, for example on how an inventory was read, are messages of class
#' `silvafit_note`.
#'
#' @name silvafit-conditions
#' @examples
#' tryCatch(
#'   silvafit(height ~ a * gamma(b * age), data = Loblolly),
#'   silvafit_formula_error = function(e) conditionMessage(e)
#' )
NULL

new_condition <- function(message, class, call = NULL, ...) {
  structure(class = c(class, "condition"), list(message = message, call = call, ...))
}

stop_classed <- function(kind, message, ...) {
  stop(new_condition(message, c(paste0("silvafit_", kind, "_error"), "silvafit_error", "error"), ...))
}

stop_usage <- function(...) stop_classed("usage", paste0(...))
stop_input <- function(..., column = "") stop_classed("input", paste0(...), column = column)
stop_formula <- function(...) stop_classed("formula", paste0(...))

tell <- function(text, class = "silvafit_note") {
  message(new_condition(paste0(text, "\n"), c(class, "silvafit_message", "message")))
}

tell_notes <- function(notes) for (note in notes) tell(in_words_of_r(note))

warn <- function(text, class, ...) {
  warning(new_condition(text, c(class, "silvafit_warning", "warning"), ...))
}

# Messages of the libraries, with arguments in place of settings.
in_words_of_r <- function(text) {
  text <- as.character(text)
  text[!is.na(text)] <- .Call(C_words_of_messages, text[!is.na(text)])
  text
}

# An analysis of the C++ libraries by its name (study/analyses.hpp).
#
# \param table    path, columns or NULL
# \param objects  handles of fits, or that of a library
# \param folder   with the catalogue and the pages, where they are needed
# \return         list of tables (columns), rows, json, fits and notes
analysis <- function(name, table = NULL, arguments = list(), objects = NULL, plots = NULL, progress = FALSE, folder = "") {
  engine(.Call(C_analysis, name, table, plots, objects, arguments, folder, isTRUE(progress)))
}

# An analysis of a fit, by default with its own rows.
analysis_of_fit <- function(name, object, arguments = list(), data = object$frame, progress = FALSE) {
  folder <- if (is.null(object$fit$model)) "" else data_folder()
  result <- analysis(name, if (!is.null(data)) plain_columns(data, names(data)), arguments, list(object$handle), progress = progress, folder = folder)
  tell_notes(result$notes)
  result
}

# The value of a C++ function, or its error as a condition.
engine <- function(value) {
  if (!inherits(value, "silvafit_failure")) return(value)
  stop_classed(value$kind, value$message, column = value$column, plot = value$plot,
               tree = value$tree)
}
