# SPDX-License-Identifier: MIT
# Arguments that a function does not have. R drops them in `...` without a word.

# Arguments of nlme(), gnls(), lme() and lme4 that have another name in silvafit().
renamed_arguments <- c(model = "formula", fixed = "parameters", params = "parameters", weights = "variance", REML = "reml", verbose = "trace")
# Those that silvafit() does not have.
absent_arguments <- c(naPattern = "use `subset`", keep.data = "a fit has its data", family = "the residuals are normal; use lme4::glmer()")

# The arguments in `...` of silvafit() as its own, and `method = "REML"` and `control` of nlme.
#
# \param given   list(...)
# \return        call, with its own names, and the values of arguments that differ from what the caller has
own_arguments <- function(given, call, method, reml) {
  no_further(given, c(names(renamed_arguments), "control", "nAGQ"), absent_arguments, formals(silvafit))
  if (is.numeric(unlist(given$fixed)) && !is.null(given$fixed)) stop_usage("`fixed` has formulas, as in nlme; to hold coefficients at values, use hold = c(R0 = -8)")
  values <- list()
  for (name in intersect(names(renamed_arguments), names(given))) {
    own <- renamed_arguments[[name]]
    if (own %in% c(names(call), names(values))) stop_usage("give either `", own, "` or `", name, "`")
    names(call)[names(call) == name] <- own
    values[own] <- given[name]
  }
  set <- list()
  if (is.character(method) && length(method) == 1 && toupper(method) %in% c("ML", "REML")) {
    set <- list(method = NULL, reml = toupper(method) == "REML")
    if ("reml" %in% names(call) && isTRUE(if (is.null(given$REML)) reml else given$REML) != set$reml) stop_usage("`method` is \"", method, "\", but `reml` is ", !set$reml, "; give one of them")
  }
  if (!is.null(given$nAGQ) && !is.null(method)) stop_usage("give either `method` or `nAGQ`")
  if (!is.null(given$nAGQ)) set <- c(set, arguments_of_quadrature(given$nAGQ))
  set <- c(set, arguments_of_control(given$control))
  twice <- setdiff(intersect(names(set), names(call)), c("method", "reml"))
  if (length(twice) > 0) stop_usage("`", twice[1], "` is set by `", if (twice[1] == "agq_points") "nAGQ" else "control", "`, too; give one of them")
  for (name in intersect(c(names(set), "control", "nAGQ"), names(call))) call[[name]] <- NULL
  for (name in names(set)) if (!is.null(set[[name]])) call[[name]] <- set[[name]]
  list(call = call, values = c(values, set))
}

# lme4's number of quadrature points, of which one is Laplace's approximation.
arguments_of_quadrature <- function(points) {
  check_count(points, "nAGQ", 1)
  if (points == 1) list(method = "laplace") else list(method = "agq", agq_points = points)
}

# A control list of nlme: the number of iterations and the trace. A note names what else was changed.
arguments_of_control <- function(control) {
  if (is.null(control)) return(list())
  if (!is.list(control) || inherits(control, "merControl")) stop_usage("`control` has to be a list such as nlmeControl(maxIter = 100)")
  defaults <- list(nlme::nlmeControl(), nlme::gnlsControl(), nlme::lmeControl(), nlme::glsControl(), stats::nls.control())
  known <- unique(unlist(lapply(defaults, names)))
  if (length(control) > 0 && (is.null(names(control)) || any(names(control) == ""))) stop_usage("`control`: an element has no name; write, for example, list(maxIter = 100)")
  unknown <- setdiff(names(control), known)
  if (length(unknown) > 0) stop_unknown(unknown[1], known, "`control`: unknown element")
  for (default in defaults) {
    if (setequal(names(control), names(default))) control <- control[!mapply(identical, control, default[names(control)])]
  }
  if (isTRUE(control$sigma > 0)) stop_usage("`control`: a fixed sigma is another model, which silvafit does not fit")
  iterations <- c(control$maxIter, control$maxiter)
  trace <- control$msVerbose
  others <- setdiff(names(control), c("maxIter", "maxiter", "msVerbose", "returnObject"))
  if (length(others) > 0) {
    tell(paste0("`control`: ", paste(others, collapse = ", "), " not used: a fit iterates until no estimate changes by more than a small fraction of its standard error"))
  }
  c(if (length(iterations) > 0) list(max_iterations = iterations[1]), if (!is.null(trace)) list(trace = trace))
}

# A method that refuses arguments in its `...`.
#
# \param also,instead  as in no_further()
strict <- function(method, also = character(), instead = character()) {
  body(method) <- bquote({
    no_further(list(...), .(also), .(instead))
    .(body(method))
  })
  method
}

# A method for generics of packages that pass arguments of other models to all methods. Values that change nothing are ignored, others are refused.
#
# \param neutral  by name: values that change nothing; NULL: any
for_others <- function(method, neutral = list()) {
  body(method) <- bquote({
    no_further(with_effect(list(...), .(neutral)))
    .(body(method))
  })
  method
}

# Arguments without those that change nothing.
with_effect <- function(given, neutral = list()) {
  neutral <- c(neutral, list(verbose = c(TRUE, FALSE), component = c("all", "conditional"), effects = "fixed", robust = FALSE))
  is_neutral <- function(name, value) name != "" && (is.null(value) || (name %in% names(neutral) && (is.null(neutral[[name]]) || (is.atomic(value) && all(value %in% neutral[[name]])))))
  given[!as.logical(mapply(is_neutral, if (is.null(names(given))) rep("", length(given)) else names(given), given))]
}

one_of <- function(value, choices, name) {
  if (!is.character(value) || length(value) != 1 || !value %in% choices) stop_usage("`", name, "` has to be ", paste0("\"", choices, "\"", collapse = ", "))
  value
}

# Stops if the caller got arguments in its `...`. The suggestion is the nearest name, or the argument that accepts the value.
#
# \param given     list(...) of the caller
# \param also      further names that the caller accepts in its `...`
# \param instead   named texts: what to write instead of arguments of other packages
# \param accepted  arguments of the caller
no_further <- function(given, also = character(), instead = character(), accepted = formals(sys.function(sys.parent()))) {
  if (length(given) == 0) return(invisible())
  names <- if (is.null(names(given))) rep("", length(given)) else names(given)
  bad <- which(!names %in% also)
  if (length(bad) == 0) return(invisible())
  own <- setdiff(names(accepted)[-1], "...")
  available <- c(own, also)
  name <- names[bad[1]]
  if (name == "") stop_usage("an argument without a name is one too many", available_text(own))
  if (name %in% names(instead)) stop_usage("unknown argument '", name, "'; ", instead[[name]])
  stop_unknown(name, available, shown = if (length(also) > 20) own else available, near = argument_with_value(given[[bad[1]]], accepted))
}

# \param near  what may be meant, if no name is like it
stop_unknown <- function(name, available, what = "unknown argument", shown = available, near = character()) {
  near <- c(near_argument(name, available), near)
  stop_usage(what, " '", name, "'", if (length(near) > 0) paste0("; did you mean '", near[1], "'?") else available_text(shown))
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
  # A name that is part of another one, such as data and newdata.
  part <- if (nchar(name) > 2) grep(name, available, fixed = TRUE, value = TRUE)
  if (length(part) > 0) part[1] else Filter(nzchar, .Call(C_nearest_name, name, available))
}

# Names that plots of graphics accept.
graphical_names <- function() {
  c(names(graphics::par(no.readonly = TRUE)), setdiff(names(formals(graphics::plot.default)), c("x", "y", "...")), "bg", "cin", "cra", "csi", "cxy", "din", "page")
}
