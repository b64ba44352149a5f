# SPDX-License-Identifier: MIT
# Arguments that a function does not have. R drops them in `...` without a word.

# Stops if the caller got arguments in its `...`. The suggestion is the argument that accepts the value, or the nearest name.
#
# \param given     list(...) of the caller
# \param also      further names that the caller accepts in its `...`
# \param instead   named texts: what to write instead of arguments of other packages
# \param of        the caller
no_further <- function(given, also = character(), instead = character(), of = sys.function(sys.parent())) {
  if (length(given) == 0) return(invisible())
  names <- if (is.null(names(given))) rep("", length(given)) else names(given)
  bad <- which(!names %in% also)
  if (length(bad) == 0) return(invisible())
  accepted <- formals(of)
  own <- setdiff(names(accepted)[-1], "...")
  available <- c(own, also)
  name <- names[bad[1]]
  if (name == "") stop_usage("an argument without a name is one too many", available_text(own))
  if (name %in% names(instead)) stop_usage("unknown argument '", name, "'; ", instead[[name]])
  by_value <- argument_with_value(given[[bad[1]]], accepted)
  near <- if (length(by_value) > 0) by_value[1] else near_argument(name, available)
  stop_usage("unknown argument '", name, "'", if (length(near) > 0) paste0("; did you mean '", near, "'?") else available_text(if (length(also) > 20) own else available))
}

available_text <- function(names) if (length(names) > 0) paste0("; available: ", paste(names, collapse = ", ")) else "; the function has no further arguments"

# The argument whose choices include a text, such as method = c("wald", "profile") for "profile".
argument_with_value <- function(value, accepted) {
  if (!is.character(value) || length(value) != 1) return(character())
  has_value <- vapply(accepted, function(default) {
    is.call(default) && identical(default[[1]], quote(c)) && value %in% unlist(Filter(is.character, as.list(default)[-1]))
  }, logical(1))
  names(accepted)[has_value]
}

near_argument <- function(name, available) {
  if (length(available) == 0) return(character())
  slips <- drop(utils::adist(name, available, ignore.case = TRUE))
  # A name that is part of another one, such as data and newdata.
  is_part <- vapply(available, function(one) nchar(name) > 2 && grepl(name, one, fixed = TRUE), logical(1))
  slips[is_part] <- 0
  # Letters in another order are one slip, as levle for level.
  letters_of <- function(one) paste(sort(strsplit(tolower(one), "")[[1]]), collapse = "")
  slips[vapply(available, letters_of, "") == letters_of(name)] <- 1
  if (min(slips) <= max(1, nchar(name) %/% 3)) available[which.min(slips)] else character()
}

# Names that plots of graphics accept.
graphical_names <- function() {
  c(names(graphics::par(no.readonly = TRUE)), setdiff(names(formals(graphics::plot.default)), c("x", "y", "...")), "bg", "cin", "cra", "csi", "cxy", "din", "page")
}
