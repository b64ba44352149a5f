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

# Texts of the C++ libraries name options of the program; here they are arguments.
in_words_of_r <- function(text) {
  words <- c("--starts N" = "`starts`", "--model" = "`models`", "--fix" = "`fixed`", "--bound" = "`lower` and `upper`",
             "--start" = "`start`", "--starts" = "`starts`", "--random" = "`random`", "--variance" = "`variance`",
             "--covariance" = "`covariance`", "--parameter" = "`parameters`", "--formula" = "`formula`",
             "--reml" = "`reml`", "--agq-points" = "`quadrature_points`", "--columns" = "`columns`",
             "--where" = "`subset`", "--edge" = "`edge`", "--per" = "`per`", "--window" = "`window`",
             "--circle" = "`circle`", "--buffer" = "`buffer`", "--plot-area" = "`plot_area`",
             "--stratum" = "`stratum`", "--group" = "`group`", "--trust-units" = "`trust_units = TRUE`",
             "--missing" = "`missing`", "--dead" = "`dead`", "--alive-codes" = "`alive_codes`", "--dead-codes" = "`dead_codes`", "--cut-codes" = "`cut_codes`", "--species" = "`species`",
             "--responses" = "`responses`", "--covariates" = "`covariates`", "--alpha" = "`alpha`",
             "--open-grown" = "`open_grown`", "--further" = "`further`", "--role" = "`role`",
             "--level" = "`level`", "--new-groups" = "`new_groups`", "--seen-groups" = "`seen_groups`",
             "--minimum-trees" = "`minimum_trees`", "--by" = "`by`", "--seed" = "`seed`")
  text <- gsub("`silvafit indices`", "structural_units()", text, fixed = TRUE)
  # Texts of models are texts here, too.
  text <- gsub("--(random|variance) (\"[^\"]*\")", "\\1 = \\2", text)
  text <- gsub("--parameter (\"[^\"]*\")", "parameters = \\1", text)
  text <- gsub("--method ([a-z]+)", "method = \"\\1\"", text)
  for (option in names(words)[order(-nchar(names(words)))]) {
    text <- gsub(paste0("(?<![[:alnum:]-])", option, "(?![[:alnum:]-])"), words[[option]], text, perl = TRUE)
  }
  # All others have the name of their argument, as --class-width.
  options <- gregexpr("(?<![[:alnum:]-])--[a-z]+(-[a-z]+)*", text, perl = TRUE)
  regmatches(text, options) <- lapply(regmatches(text, options), function(names) paste0("`", gsub("-", "_", sub("--", "", names)), "`", recycle0 = TRUE))
  text
}

# The value of a C++ function, or its error as a condition.
engine <- function(value) {
  if (!inherits(value, "silvafit_failure")) return(value)
  stop_classed(value$kind, in_words_of_r(value$message), column = value$column, plot = value$plot,
               tree = value$tree)
}
