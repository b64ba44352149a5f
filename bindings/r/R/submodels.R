# SPDX-License-Identifier: MIT
# Sub-models of parameters: the columns of R's model.matrix() as terms of silvafit.
#
# A factor becomes comparisons of its column with its levels, so that a stored fit needs nothing of R.

# \param parameters  formula or list of formulas: a ~ species, a + b ~ 1 + C
# \return            named list of one-sided formulas by parameter
sub_model_formulas <- function(parameters) {
  if (is.null(parameters)) return(list())
  if (inherits(parameters, "formula") || is.character(parameters)) parameters <- as.list(c(parameters))
  if (!is.list(parameters)) stop_usage("`parameters` has to be a formula such as b ~ 1 + C, or a list of formulas")
  result <- list()
  for (i in seq_along(parameters)) {
    formula <- as_formula(parameters[[i]], "parameters")
    if (length(formula) != 3) {
      name <- names(parameters)[i]
      if (is.null(name) || name == "") stop_usage("`parameters`: the name of the parameter is missing in ", deparse1(formula))
      formula <- stats::as.formula(call("~", as.name(name), formula[[2]]), environment(formula))
    }
    for (name in summands(formula[[2]])) {
      if (!is.name(name)) stop_formula("'", deparse1(name), "' is not a parameter; write, for example, b ~ 1 + C")
      if (as.character(name) %in% names(result)) stop_usage("`parameters` has two sub-models of ", as.character(name))
      one <- formula[c(1, 3)]
      environment(one) <- environment(formula)
      result[[as.character(name)]] <- one
    }
  }
  result
}

as_formula <- function(value, argument) {
  if (is.character(value) && length(value) == 1) {
    value <- tryCatch(stats::as.formula(value, env = globalenv()),
                      error = function(e) stop_formula("`", argument, "`: '", value, "' cannot be read as a formula"))
  }
  if (!inherits(value, "formula")) {
    stop_usage("`", argument, "`: ", if (is.language(value) || length(value) == 1) deparse1(value) else paste("an object of class", class(value)[1]), " is not a formula")
  }
  value
}

# The parts of a + b + c.
summands <- function(expression) {
  if (is.call(expression) && identical(expression[[1]], quote(`+`)) && length(expression) == 3) {
    return(c(summands(expression[[2]]), summands(expression[[3]])))
  }
  if (is.call(expression) && identical(expression[[1]], quote(`(`))) return(summands(expression[[2]]))
  list(expression)
}

# The terms of a one-sided formula.
# \return  list of intercept (logical), text and label of each column, the columns that are factors,
#          and offsets as expressions
sub_model_columns <- function(formula, data, contrasts = NULL, what = "a sub-model") {
  if ("." %in% all.names(formula)) stop_formula("'.' cannot be used in ", what, "; name the columns")
  terms <- tryCatch(stats::terms(formula, keep.order = FALSE),
                    error = function(e) stop_formula("'", deparse1(formula[[2]]), "' cannot be used in ", what, ": ", conditionMessage(e)))
  variables <- as.list(attr(terms, "variables"))[-1]
  for (variable in variables) {
    if (is_bar(strip_parentheses(variable)) && !all(vapply(data[intersect(all.vars(variable), names(data))], is.logical, logical(1)))) {
      stop_formula("'", deparse1(variable), "' cannot be used in ", what, "; random effects are an argument, such as random = a ~ 1 | plot")
    }
  }
  matrix <- attr(terms, "factors")
  offsets <- attr(terms, "offset")
  if (attr(terms, "intercept") == 0 && length(matrix) > 0) matrix <- with_first_factor_whole(matrix, variables, data, environment(formula))
  texts <- character()
  labels <- character()
  factors <- character()
  coded <- list()
  codings <- list()
  for (term in seq_along(attr(terms, "term.labels"))) {
    codes <- matrix[, term]
    columns <- list(list(text = "", label = ""))
    for (i in which(codes > 0)) {
      key <- paste(i, codes[i])
      if (is.null(coded[[key]])) coded[[key]] <- variable_columns(variables[[i]], codes[i] == 2, data, environment(formula), contrasts, what)
      columns <- crossed(columns, coded[[key]])
      factors <- c(factors, coded[[key]]$factor)
      codings <- utils::modifyList(codings, as.list(coded[[key]]$coding))
    }
    texts <- c(texts, vapply(columns, `[[`, "", "text"))
    labels <- c(labels, vapply(columns, `[[`, "", "label"))
  }
  list(intercept = attr(terms, "intercept") == 1, texts = texts, labels = labels, factors = unique(factors), codings = codings,
       offsets = lapply(variables[offsets], function(one) with_arguments_in_order(one, "offset", what)[[2]]))
}

# Without an intercept the first factor has a column for each level, as in model.matrix().
with_first_factor_whole <- function(matrix, variables, data, environment) {
  has_levels <- vapply(variables, function(variable) {
    column <- factor_column_of(variable)
    if (is.null(column)) return(is_truth(variable, data, environment))
    !is.name(variable) || !is.numeric(data[[column]])
  }, logical(1))
  for (term in seq_len(NCOL(matrix))) {
    found <- which(has_levels & matrix[, term] > 0)
    if (length(found) > 0) {
      matrix[found[1], term] <- 2
      break
    }
  }
  matrix
}

crossed <- function(columns, further) {
  result <- list()
  for (i in seq_along(further$texts)) {
    for (one in columns) {
      joined <- function(a, b) if (a == "") b else paste0(a, ":", b)
      result <- c(result, list(list(text = joined(one$text, further$texts[i]), label = joined(one$label, further$labels[i]))))
    }
  }
  result
}

# The columns of one variable of a term: itself, or those of a factor.
variable_columns <- function(variable, has_all_levels, data, environment, contrasts, what) {
  name <- deparse1(variable)
  factor_name <- factor_column_of(variable)
  if (!is.null(factor_name)) {
    if (!factor_name %in% names(data)) stop_no_column(factor_name, data, what)
    if (is.name(variable) && is.logical(data[[factor_name]])) {
      return(truth_columns(expression_text(as.name(factor_name)), name, has_all_levels, contrasts[[factor_name]], factor_name))
    }
    if (!is.name(variable) || is.factor(data[[factor_name]]) || is.character(data[[factor_name]])) {
      return(factor_columns(factor_name, name, has_all_levels, data, contrasts))
    }
    return(list(texts = expression_text(as.name(factor_name)), labels = name))
  }
  text <- expression_text(variable, what)
  missing <- setdiff(all.vars(variable), c(names(data), "pi"))
  if (length(missing) > 0) stop_no_column(missing[1], data, what)
  if (is_truth(variable, data, environment)) {
    inner <- without_marks(variable)
    text <- expression_text(inner, what)
    return(truth_columns(if (is_comparison(inner)) paste0("(", text, ")") else text, name, has_all_levels))
  }
  list(texts = text, labels = name)
}

# The column of `species`, factor(year) and as.factor(year); NULL for other expressions.
factor_column_of <- function(variable) {
  if (is.name(variable)) return(as.character(variable))
  if (is.call(variable) && as.character(variable[[1]])[1] %in% c("factor", "as.factor") && length(variable) == 2 &&
      is.name(variable[[2]]) && (is.null(names(variable)) || names(variable)[2] %in% c("", "x"))) {
    return(as.character(variable[[2]]))
  }
  NULL
}

strip_parentheses <- function(expression) {
  while (is.call(expression) && identical(expression[[1]], quote(`(`))) expression <- expression[[2]]
  expression
}

# An expression without I() and parentheses around it.
without_marks <- function(expression) {
  while (is.call(expression) && as.character(expression[[1]])[1] %in% c("(", "I")) expression <- expression[[2]]
  expression
}

is_comparison <- function(variable) {
  variable <- strip_parentheses(variable)
  is.call(variable) && as.character(variable[[1]])[1] %in% c("==", "!=", "<", "<=", ">", ">=", "&", "|", "&&", "||", "!", "%in%")
}

# Whether the values are TRUE or FALSE, which R takes for a factor, as in I(dbh > 20).
is_truth <- function(variable, data, environment) is.logical(tryCatch(eval(variable, data, environment), error = function(e) NULL))

# \param chosen  contrasts of the user; NULL: those of the options
truth_columns <- function(text, name, has_all_levels, chosen = NULL, column = NULL) {
  parts <- c(paste0("(1 - ", text, ")"), text)
  coded <- coded_columns(c(FALSE, TRUE), has_all_levels, chosen)
  texts <- vapply(seq_len(ncol(coded)), function(j) if (all(coded[, j] == c(0, 1))) text else weighted_text(parts, coded[, j]), "")
  list(texts = texts, labels = paste0(name, colnames(coded)), coding = coding_of(coded, has_all_levels, column))
}

factor_columns <- function(column, name, has_all_levels, data, contrasts) {
  values <- data[[column]]
  values <- if (is.factor(values) && nlevels(values) == length(unique(values[!is.na(values)]))) values else factor(values)
  if (nlevels(values) < 2) stop_input("the factor '", column, "' has one level only; a sub-model needs two", column = column)
  coded <- coded_columns(values, has_all_levels, contrasts[[column]])
  comparisons <- paste0("(", expression_text(as.name(column)), " == ", vapply(levels(values), string_text, ""), ")")
  texts <- vapply(seq_len(ncol(coded)), function(j) weighted_text(comparisons, coded[, j]), "")
  list(texts = texts, labels = paste0(name, colnames(coded)), factor = column, coding = coding_of(coded, has_all_levels, column))
}

# The columns of model.matrix() for the levels of a factor.
coded_columns <- function(values, has_all_levels, chosen) {
  if (!is.factor(values)) values <- factor(values)
  if (!is.null(chosen)) values <- stats::`contrasts<-`(values, value = chosen)
  coded <- if (has_all_levels) diag(nlevels(values)) else stats::contrasts(values)
  if (has_all_levels) colnames(coded) <- levels(values)
  if (is.null(colnames(coded))) colnames(coded) <- seq_len(ncol(coded))
  coded
}

coding_of <- function(coded, has_all_levels, column) if (!has_all_levels && !is.null(column)) stats::setNames(list(coded), column)

# A column of a contrast matrix as a sum of parts, one for each level.
weighted_text <- function(parts, weights) {
  used <- which(weights != 0)
  if (length(used) == 1 && weights[used] == 1) return(if (grepl("^\\(1 - ", parts[used])) paste0("I", parts[used]) else parts[used])
  terms <- ifelse(weights[used] == 1, parts[used], paste0(vapply(weights[used], number_text, ""), "*", parts[used]))
  paste0("I(", gsub("+ -", "- ", paste(terms, collapse = " + "), fixed = TRUE), ")")
}

stop_no_column <- function(name, data, what) {
  stop_input("unknown column '", name, "' in ", what, "; available: ", paste(names(data), collapse = ", "), column = name)
}

# Everything about the sub-models that the C++ libraries and the names of coefficients need.
# \return  texts "b ~ 1 + C", factors, labels (names: coefficients of C++, values: those of R),
#          offsets by parameter, and the coefficients of C++ in the order of the formulas
sub_models <- function(formulas, data, contrasts) {
  texts <- character()
  factors <- character()
  labels <- character()
  offsets <- list()
  codings <- list()
  coefficients <- character()
  for (parameter in names(formulas)) {
    columns <- sub_model_columns(formulas[[parameter]], data, contrasts, paste("the sub-model of", parameter))
    parts <- c(if (columns$intercept) "1" else "0", columns$texts)
    if (length(columns$texts) > 0 || columns$intercept) {
      texts <- c(texts, paste(name_text(parameter), "~", paste(parts, collapse = " + ")))
    } else {
      stop_formula("the sub-model of ", parameter, " has no term; to hold the parameter at 0, use hold = c(", parameter, " = 0)")
    }
    coefficients <- c(coefficients, if (columns$intercept) parameter, if (length(columns$texts) > 0) paste0(parameter, ":", columns$texts))
    factors <- c(factors, columns$factors)
    codings <- utils::modifyList(codings, columns$codings)
    offsets[[parameter]] <- columns$offsets
    is_renamed <- columns$texts != columns$labels
    labels <- c(labels, stats::setNames(paste0(parameter, ":", columns$labels), paste0(parameter, ":", columns$texts))[is_renamed])
  }
  list(texts = texts, factors = unique(factors), labels = labels, offsets = offsets, coefficients = coefficients, codings = codings)
}
