# SPDX-License-Identifier: MIT
# The fit.

#' Fit a nonlinear model, with random effects or without
#'
#' Fits heights, crown widths or any other response to a formula whose parameters may have linear sub-models
#' and random effects. Start values and derivatives are not needed.
#'
#' The names in `formula` that are columns of `data` are data; all others are parameters. A name that is near that of a column, or whose effect
#' cannot be separated from that of another parameter, is named in the message of the fit. Besides the
#' operators, the functions `exp`, `log`, `log10`, `log2`, `log1p`, `expm1`, `sqrt`, `abs`, `sign`, `sin`,
#' `cos`, `tan`, `asin`, `acos`, `atan`, `sinh`, `cosh`, `tanh`, `pow`, `min`, `max`, `ifelse` and `I` can be
#' used, and the self-starting models of \pkg{stats} (`SSlogis`, `SSasymp`, ...). The left side is a column or
#' an expression such as `log(h)`.
#'
#' **Sub-models.** `parameters = list(a ~ species, b ~ 1 + C)` replaces the parameter `a` by one coefficient for
#' each column of the model matrix: `a` is the intercept, `a:speciesSM` the coefficient of a level, `b:C` that of
#' a covariate. Factors have the contrasts of R. Parameters without a sub-model are one coefficient.
#'
#' **Random effects.** `random = a + b ~ 1 | plot` gives the parameters `a` and `b` an effect for each plot;
#' `a ~ 1 | stand/plot` nests plots in stands; `list(stand = a ~ 1, plot = a + b ~ 1)` gives both groupings
#' their own effects; labels of plots that recur in several stands are an error unless nesting is written,
#' `list(a ~ 1 | stand, a + b ~ 1 | stand/plot)`. Crossed groupings: `a ~ 1 | plot + year`, or the text
#' `"(a + b | plot) + (a | year)"` with effects of their own. Several formulas with the same groups, `list(a ~ 1 | plot, b ~ 1 | plot)`, are independent;
#' a list without groups, `list(a ~ 1, b ~ 1)`, is one correlated term, as in nlme. Its groups are `groups`, or those of a groupedData.
#' A term of \pkg{lme4} in the formula, as in `h ~ a + b * dbh + (1 | plot)`, is read if each of its effects is that of one parameter.
#' The classes `pdDiag`, `pdIdent`, `pdCompSymm`, `pdSymm` and `pdBlocked` of \pkg{nlme} can be used, or `covariance`.
#'
#' **Methods.** `"lb"`, the method of Lindstrom and Bates, is that of [nlme::nlme()] and the default with random
#' effects. `"laplace"`, `"focei"`, `"foce"` and `"agq"` (adaptive Gauss-Hermite quadrature) maximize the marginal
#' likelihood, which is better for few observations in a group. `"gnls"` (the default with a variance function) and
#' `"ols"` are least squares.
#'
#' **Calls of nlme and lme4.** These arguments can be used, too: `model` for `formula`; `fixed` or `params` for `parameters`; `weights` for `variance`; `verbose` for `trace`; `REML` for
#' `reml`; `method = "ML"` or `"REML"`; `nAGQ`, the number of quadrature points, of which one is `"laplace"`; `control`, of which `maxIter` and `msVerbose` are used and a
#' message names other values that are not the default. With `fixed` and without `random` its coefficients have random effects, as in `nlme()`.
#'
#' A fit that has not converged gives a warning with the reason; [convergence()] has the evidence. A fit can be
#' interrupted.
#'
#' @param formula model, such as `h ~ 1.3 + a * (1 - exp(-b * dbh))`, or the id of a model of the catalogue, such as `"M4"`
#' @param data data frame, tibble, or points of class `sf`
#' @param parameters formula or list of formulas with the linear sub-models of parameters
#' @param random formula, list of formulas, `pdMat` object of nlme, or text; see Details
#' @param groups one-sided formula with the groups if `random` does not name them, as in [nlme::nlme()]
#' @param covariance form of the covariance of the random effects: `"general"`, `"diagonal"`, `"identity"` or `"compound-symmetry"`; one
#'   for all groupings, or one for each
#' @param variance variance function of the residuals: an object of nlme such as `varPower(form = ~ dbh)`, or a text:
#'   `"power"`, `"exponential"`, `"constant-plus-power"`, `"power(dbh)"`, `"power(fitted | species)"`,
#'   `"stratum(species)"`, products with `*`
#' @param correlation correlation of the residuals within groups: an object of nlme such as `corAR1(form = ~ year | plot)`, or a text: `"ar1(year | plot)"`, `"car1(age)"`,
#'   `"arma(1, 1)"`, `"compound-symmetry"`, `"symmetric"`, `"exponential(x, y; nugget)"`, `"gaussian"`, `"spherical"`, `"rational-quadratic"`, `"linear"`
#' @param method `"lb"`, `"laplace"`, `"focei"`, `"foce"`, `"agq"`, `"gnls"` or `"ols"`; or `"ML"` or `"REML"` of nlme
#' @param reml restricted maximum likelihood, for `"lb"` and `"gnls"`
#' @param start named vector of start values, never needed; they are tried in addition to those that are found. Without names they have the order of
#'   `parameters`
#' @param hold named vector of coefficients that are held at a value
#' @param lower,upper named vectors of bounds of coefficients
#' @param subset condition on the rows, evaluated in `data`
#' @param derive functions of the coefficients, with standard errors and intervals: a named vector of texts, such as
#'   `c(h30 = "1.3 + a * (1 - exp(-b * 30))")`, with the names of `coef()`; those that are no words stand between backquotes
#' @param means factors of the sub-models: the estimated marginal mean of each parameter at each of their levels, as \pkg{emmeans} has them, beside
#'   the functions of `derive`
#' @param na.action `na.omit`, `na.exclude` (residuals and fitted values have NA for omitted rows) or `na.fail`
#' @param contrasts list of contrasts by factor, as in [stats::model.matrix()]
#' @param starts number of further random starts of a mixed fit
#' @param agq_points points per random effect, for `"agq"`
#' @param max_iterations limit of the iterations of `"lb"` and `"gnls"`
#' @param threads number of threads; 0 means all cores. Results do not depend on it
#' @param trace show the iterations
#' @param ... arguments of nlme and lme4, see Details; other names stop
#' @return An object of class `silvafit`. Methods exist for the generics of stats (`coef`, `vcov`, `logLik`,
#'   `AIC`, `residuals`, `fitted`, `predict`, `simulate`, `confint`, `anova`, `update`, ...) and nlme (`fixef`,
#'   `ranef`, `VarCorr`, `intervals`).
#' @seealso [predict.silvafit()], [convergence()], `vignette("from-nlme", package = "silvafit")`
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' summary(fit)
#' predict(fit, data.frame(age = c(5, 15)), level = "population", interval = "confidence")
silvafit <- function(formula, data, parameters = NULL, random = NULL, groups = NULL, covariance = NULL,
                     variance = NULL, correlation = NULL, method = NULL, reml = FALSE, start = NULL, hold = NULL, lower = NULL,
                     upper = NULL, subset = NULL, na.action = stats::na.omit, contrasts = NULL, derive = NULL, means = NULL, starts = 0,
                     agq_points = 7, max_iterations = 200, threads = 1, trace = FALSE, ...) {
  call <- match.call()
  # Expressions of a caller's `...`, which match.call() names ..1.
  for (name in intersect(names(call), names(formals(silvafit)))) call[[name]] <- eval(base::call("substitute", as.name(name)))
  dots <- as.list(substitute(list(...)))[-1]
  for (name in setdiff(names(dots), "")) call[[name]] <- dots[[name]]
  own <- own_arguments(list(...), call, method, reml)
  call <- own$call
  for (name in names(own$values)) assign(name, own$values[[name]])
  if (missing(formula)) stop_usage("`formula` is missing: the model with its parameters, such as h ~ 1.3 + a * (1 - exp(-b * dbh)), or h ~ b0 + b1 * dbh")
  # update() has to find the formulas, not the names of variables that had them.
  id <- if (is.character(formula) && length(formula) == 1 && !grepl("~", formula, fixed = TRUE)) trimws(formula)
  if (!is.null(id)) formula <- engine(.Call(C_formula_of_model, id, data_folder()))
  formula <- as_formula(formula, "formula")
  call$formula <- formula
  if (length(formula) != 3) stop_formula("the formula needs a response: h ~ ...")
  if (is.call(formula[[2]]) && identical(formula[[2]][[1]], quote(`~`))) {
    stop_formula("a formula has one ~; random effects are an argument, such as random = \"", deparse1(formula[[3]]), "\"")
  }
  if (missing(data)) stop_usage("`data` is missing: the data frame with the columns of the model")
  given <- data
  # do.call() puts the values into the call.
  if (!is.language(call$data)) call$data <- quote(data)
  own_groups <- groups
  if (is.null(groups) && inherits(data, "groupedData")) groups <- nlme::getGroupsFormula(data)
  if ("fixed" %in% names(list(...)) && missing(random) && !isTRUE(method %in% c("gnls", "ols")) && !has_bar_summand(formula[[3]])) {
    if (is.null(groups)) stop_usage("`fixed` without `random`: nlme() has random effects of all coefficients then; give `random`, which is NULL for none, or `groups`")
    call$random <- random <- parameters
    tell("as in nlme() without `random`, all coefficients of `fixed` have random effects")
  }
  data <- check_data(data)
  rows <- subset_rows(substitute(subset), data, parent.frame())
  if (!is.null(call$subset)) call$subset <- with_values(substitute(subset), data, parent.frame())
  model <- model_texts(formula, rows_of(data, rows), parameters, random, groups, covariance, variance, correlation, contrasts)
  check_groups(own_groups, model$texts$random)
  if (inherits(means, "formula")) means <- all.vars(means)
  check_means(means, parameters, data)
  options <- list(method = method, reml = reml, start = engine_names(start, model, "start"), hold = engine_names(hold, model, "hold"),
                  bounds = bounds_of(engine_names(lower, model, "lower"), engine_names(upper, model, "upper")), starts = starts,
                  agq_points = agq_points, maximum_iterations = max_iterations, threads = threads, trace = trace)
  frame <- model$frame
  omit <- check_missing(frame, na.action)
  # The domain of a model of the catalogue may have a condition on these.
  columns <- c(frame, if (!is.null(id)) rows_of(data, rows)[setdiff(intersect(c("dbh", "h"), names(data)), names(frame))])
  # Units are compared between plots and species.
  others <- if (all(c("dbh", "h") %in% names(columns))) Filter(is.atomic, rows_of(data, rows)[setdiff(intersect(c("plot", "species"), names(data)), names(columns))])
  columns <- c(columns, lapply(others, as.character))
  result <- analysis("fit", plain_columns(columns, names(columns)), c(model$texts, list(model = id, derive = derived_texts(derive, model), means = means, knows_units = has_other_units(given)), options), folder = if (is.null(id)) "" else data_folder())
  tell_notes(result$notes)
  object <- new_fit(result, model, call, options, na.action = omit)
  # What update() and getData() need: the values of the call, and the data with all columns.
  object$arguments <- mget(setdiff(intersect(names(call), names(formals(silvafit))), c("data", "subset")))
  object$data <- given
  object$units <- units_of(given)
  object$rows <- if (is.null(rows)) result$rows else rows[result$rows]
  varying <- if (has_random(object)) unlist(lapply(random_terms_of(object), `[[`, "effects"))
  said <- c(names(start), names(hold), names(lower), names(upper), sub(":.*", "", varying))
  tell_unused_numbers(setdiff(sub(":.*", "", names(fixef(object))), said), parent.frame())
  report_convergence(object, method)
  object
}

# Numbers of the caller that have the name of a coefficient: nls() would take them for data.
tell_unused_numbers <- function(names, frame) {
  repeat {
    for (name in names) {
      value <- get0(name, frame, mode = "numeric", inherits = FALSE)
      if (length(value) == 1) tell(paste0(name, " is a coefficient that was estimated; your object ", name, " (", format(value), ") is not used. Write its value, or use hold = c(", name, " = ", format(value), ")"))
      if (length(value) == 1) names <- setdiff(names, name)
    }
    if (identical(frame, globalenv()) || identical(frame, emptyenv())) return(invisible())
    frame <- parent.env(frame)
  }
}

check_flag <- function(value, name) if (!isTRUE(value) && !isFALSE(value)) stop_usage("`", name, "` has to be TRUE or FALSE")

check_count <- function(value, name, least = 0) {
  if (!is.numeric(value) || length(value) != 1 || !is.finite(value) || value != floor(value) || value < least || value > .Machine$integer.max) {
    stop_usage("`", name, "` has to be a whole number from ", least, " to ", .Machine$integer.max)
  }
}

# A condition in which names that are no columns are replaced by their values, so that it means the same elsewhere.
with_values <- function(condition, data, frame) {
  names <- setdiff(all.vars(condition), names(data))
  found <- names[vapply(names, function(name) !is.null(get0(name, frame, mode = "numeric")) || !is.null(get0(name, frame, mode = "character")) ||
                                              !is.null(get0(name, frame, mode = "logical")), logical(1))]
  do.call(substitute, list(condition, mget(found, envir = frame, inherits = TRUE)))
}

# All rows if NULL, without a copy.
rows_of <- function(data, rows) if (is.null(rows)) data else data[rows, , drop = FALSE]

# \param condition  the unevaluated argument `subset`
# \return           numbers of rows, or NULL for all
subset_rows <- function(condition, data, frame) {
  if (is.null(condition)) return(NULL)
  value <- tryCatch(eval(condition, data, frame), error = function(e) stop_usage("`subset`: ", conditionMessage(e)))
  if (is.null(value)) return(NULL)
  if (is.logical(value)) {
    if (length(value) != nrow(data) && length(value) != 1) stop_usage("`subset` has ", length(value), " values for ", nrow(data), " rows")
    value <- which(rep_len(value, nrow(data)))
  }
  if (!is.numeric(value)) stop_usage("`subset` has to be a condition such as species == \"SM\"")
  rows <- seq_len(nrow(data))[value]
  if (length(rows) == 0) stop_input("`subset`: the condition holds for no row")
  rows
}

# The model as the C++ libraries read it, and the columns that it needs.
model_texts <- function(formula, data, parameters, random, groups, covariance, variance, correlation, contrasts) {
  response <- response_of(formula, data)
  if (!response$name %in% names(data)) data[[response$name]] <- response$values
  right <- formula[[3]]
  if ("." %in% all.names(right)) stop_formula("'.' cannot be used in the formula; name the columns")
  formulas <- sub_model_formulas(parameters)
  columns <- intersect(names(formulas), names(data))
  if (length(columns) > 0) stop_formula("`parameters`: ", columns[1], " is a column of the data, so that it is no parameter of the formula; rename one of them")
  check_contrasts(contrasts)
  needed <- c(all.vars(right), unlist(lapply(formulas, all.vars)))
  complete <- stats::complete.cases(check_columns(data[intersect(c(needed, response$name), names(data))]))
  used <- if (all(complete)) data else data[complete, , drop = FALSE]
  if (nrow(used) == 0) stop_input("no row has all values that the model needs")
  subs <- sub_models(formulas, used, contrasts)
  effects <- random_effects(random, groups, used, contrasts)
  if (!is.null(covariance) && !is.null(effects$covariance) && !all(covariance == effects$covariance)) {
    stop_usage("`covariance` is ", paste(covariance, collapse = ", "), ", but the class of `random` is ", paste(effects$covariance, collapse = ", "), "; give one of them")
  }
  if (any(covariance != "diagonal") && grepl("\\) \\+ \\([^|()]*\\) \\|", effects$text)) {
    stop_usage("`covariance` is ", paste(covariance, collapse = ", "), ", but formulas or blocks of `random` with the same groups are independent; write one formula, such as a + b ~ 1 | plot")
  }
  check_coded(contrasts, union(subs$factors, names(subs$codings)), effects$text)
  variance <- variance_text(variance)
  check_nesting(correlation, effects, used)
  correlation <- correlation_text(correlation, effects$groups)
  right <- with_offsets(right, subs$offsets)
  columns <- unique(c(response$name, intersect(c(needed, effects$groups, variance_names(variance), correlation_names(correlation)), names(data))))
  with_number <- function(texts) with_pi(texts, names(data))
  labels <- stats::setNames(subs$labels, with_number(names(subs$labels)))
  list(formula = formula, frame = data[columns], labels = labels, coefficients = with_number(subs$coefficients), codings = subs$codings, response = formula[[2]],
       texts = list(formula = with_number(paste(name_text(response$name), "~", right_side_text(right))), parameters = with_number(subs$texts),
                    factors = subs$factors, columns = names(data), random = with_number(effects$text), covariance = if (is.null(covariance)) effects$covariance else covariance,
                    variance = variance, correlation = correlation))
}

check_contrasts <- function(contrasts) {
  if (is.null(contrasts)) return(invisible())
  if (!is.list(contrasts) || is.null(names(contrasts)) || any(names(contrasts) == "")) {
    stop_usage("`contrasts` has to be a named list, such as list(species = \"contr.sum\")")
  }
}

# Contrasts of other columns would have no effect.
check_coded <- function(contrasts, factors, random) {
  for (name in setdiff(names(contrasts), factors)) {
    if (!grepl(paste0(name_text(name), " =="), random, fixed = TRUE)) stop_usage("`contrasts`: ", name, " is no factor of the sub-models", if (length(factors) > 0) paste0(", which are ", paste(factors, collapse = ", ")))
  }
}

# `groups` has effect for random effects that name no groups.
check_groups <- function(groups, random) {
  if (is.null(groups)) return(invisible())
  groups <- as_formula(groups, "groups")
  if (length(groups) != 2) stop_formula("`groups` has one side, such as ~ plot, not ", deparse1(groups))
  if (!all(all.vars(groups) %in% text_groups(random))) {
    stop_usage("`groups` is ", deparse1(groups), ", but ", if (random == "") "no `random` takes it" else paste0("`random` names its groups, ", random), "; omit `groups`")
  }
}

# The left side is a column, or an expression of columns whose values become one.
response_of <- function(formula, data) {
  left <- formula[[2]]
  name <- deparse1(left)
  if (is.name(left)) {
    name <- as.character(left)
    if (!name %in% names(data)) stop_no_column(name, data, "the left side of the formula")
    return(list(name = name))
  }
  absent <- setdiff(all.vars(left), names(data))
  if (length(absent) > 0) stop_no_column(absent[1], data, "the left side of the formula")
  values <- eval(left, data, environment(formula))
  if (is.matrix(values) && ncol(values) > 1) {
    stop_formula("the left side ", name, " has ", ncol(values), " columns; binomial responses need another model, such as glm() or lme4::glmer()")
  }
  if (!is.numeric(values) || length(values) != nrow(data)) stop_formula("the left side ", name, " is not a number for each row")
  list(name = name, values = values)
}

# A parameter with offset(x) in its sub-model is the parameter plus x.
with_offsets <- function(expression, offsets) {
  for (parameter in names(offsets)) {
    for (offset in offsets[[parameter]]) {
      replacement <- stats::setNames(list(call("(", call("+", as.name(parameter), call("(", offset)))), parameter)
      expression <- do.call(substitute, list(expression, replacement))
    }
  }
  expression
}

check_missing <- function(frame, na.action) {
  action <- name_of_action(na.action, c("na.omit", "na.exclude", "na.fail"))
  if (action == "na.fail" && anyNA(frame)) {
    column <- names(frame)[vapply(frame, anyNA, logical(1))][1]
    stop_input("column '", column, "' has missing values; use na.action = na.omit, or remove the rows", column = column)
  }
  sub("na.", "", action, fixed = TRUE)
}

# The name of one of some functions of stats, which may be given as text; the first for NULL.
name_of_action <- function(na.action, names) {
  is_it <- vapply(names, function(name) identical(na.action, name) || identical(na.action, get(name, asNamespace("stats"))), NA)
  if (is.null(na.action)) is_it[1] <- TRUE
  if (!any(is_it)) stop_usage("`na.action` has to be ", paste(names, collapse = ", "))
  names[is_it][1]
}

# Both ends of each bound; NULL is an open one.
bounds_of <- function(lower, upper) {
  names <- union(names(lower), names(upper))
  if (length(names) == 0) return(NULL)
  end <- function(values, name) if (name %in% names(values)) values[[name]]
  stats::setNames(lapply(names, function(name) list(end(lower, name), end(upper, name))), names)
}

# The C++ libraries do not see offsets of sub-models, and have TRUE as 1.
check_means <- function(means, parameters, data) {
  if (is.null(means)) return(invisible())
  for (formula in sub_model_formulas(parameters)) {
    if (!is.null(attr(stats::terms(formula), "offset"))) stop_usage("`means` is not available with offsets in sub-models; use emmeans()")
    logical <- Filter(function(name) is.logical(data[[name]]), all.vars(formula))
    if (length(logical) > 0) stop_usage("`means`: the column ", logical[1], " is logical; make it a factor, or use emmeans()")
  }
}

# Functions of the coefficients as the C++ libraries read them.
derived_texts <- function(derive, model) {
  if (is.null(derive)) return(NULL)
  if (!is.character(derive) || anyNA(derive)) stop_usage("`derive` has to be a named vector of texts, such as c(ratio = \"a/b\")")
  unname(mapply(function(text, name) {
    expression <- tryCatch(str2lang(text), error = function(e) stop_formula("`derive`: ", text, " is no expression"))
    known <- all.vars(expression)
    engine <- if (length(known) > 0) names(engine_names(stats::setNames(numeric(length(known)), known), model, "derive"))
    renamed <- do.call(substitute, list(expression, stats::setNames(lapply(engine, as.name), known)))
    paste0(if (nzchar(name)) paste(name, "= "), deparse1(renamed, backtick = TRUE))
  }, derive, if (is.null(names(derive))) "" else names(derive)))
}

# Names of coefficients as the C++ libraries have them.
engine_names <- function(values, model, argument) {
  if (is.null(values)) return(NULL)
  if (is.list(values)) values <- unlist(if (is.null(values$fixed)) values else values$fixed)
  if (is.null(names(values)) && argument == "start" && length(values) == length(model$coefficients)) names(values) <- model$coefficients
  if (is.null(names(values)) && argument == "start") {
    stop_usage("`start` needs names, such as c(a = 20, b = 0.05); without names it has a value for each coefficient of `parameters` (`fixed` of nlme) in their order")
  }
  if (!is.numeric(values) || is.null(names(values)) || any(names(values) == "")) {
    stop_usage("`", argument, "` has to be a named vector, such as c(a = 20, b = 0.05)")
  }
  # nlme names an intercept a.(Intercept) and other coefficients a.speciesSM.
  for (parameter in unique(sub(":.*", "", names(model$labels)))) {
    names(values) <- sub(paste0("^", parameter, "\\.\\(Intercept\\)$"), parameter, names(values))
  }
  names(values) <- vapply(names(values), function(name) {
    found <- names(model$labels)[model$labels == name | sub(":", ".", model$labels, fixed = TRUE) == name]
    if (length(found) > 0) found[1] else name
  }, "")
  values
}
