# SPDX-License-Identifier: MIT
# Correlations of residuals of nlme as texts of silvafit.

correlation_classes <- c(corAR1 = "ar1", corCAR1 = "car1", corARMA = "arma", corCompSymm = "compound-symmetry", corSymm = "symmetric", corExp = "exponential",
                         corGaus = "gaussian", corSpher = "spherical", corRatio = "rational-quadratic", corLin = "linear")

# \param correlation  NULL, a text, or an object of class corStruct
# \param groups       columns of the groups of the random effects, which nlme's forms may repeat
correlation_text <- function(correlation, groups) {
  if (is.null(correlation)) return("")
  if (is.character(correlation)) return(correlation)
  class <- class(correlation)[1]
  if (!inherits(correlation, "corStruct") || !class %in% names(correlation_classes)) {
    stop_usage("`correlation` has to be a text such as \"ar1\", or an object of nlme: ", paste(names(correlation_classes), collapse = ", "))
  }
  if (isTRUE(attr(correlation, "fixed"))) stop_usage("`correlation` with fixed = TRUE is not available")
  metric <- attr(correlation, "metric")
  if (!is.null(metric) && metric != "euclidean") stop_usage("`correlation`: distances are euclidean, not ", metric)
  expression <- stats::formula(correlation)[[2]]
  group <- NULL
  if (is.call(expression) && identical(expression[[1]], quote(`|`))) {
    group <- all.vars(expression[[3]])
    expression <- expression[[2]]
  }
  own <- setdiff(group, groups)
  if (length(own) > 1) own <- group[length(group)]
  # nlme's compound symmetry ignores the time.
  columns <- if (class == "corCompSymm") character() else vapply(plain_terms(expression), name_text, "")
  if (class == "corARMA") columns <- c(attr(correlation, "p"), attr(correlation, "q"), columns)
  inside <- paste(columns, collapse = ", ")
  if (length(own) > 0) inside <- paste(if (length(all.vars(expression)) == 0 || class == "corCompSymm") paste(c(columns, "1"), collapse = ", ") else inside, "|", name_text(own))
  if (isTRUE(attr(correlation, "nugget"))) inside <- paste0(inside, "; nugget")
  paste0(correlation_classes[[class]], if (inside != "") paste0("(", inside, ")"))
}

# The columns of ~ 1, ~ time, ~ x + y. Predictions need them, so that they are no expressions.
plain_terms <- function(expression) {
  if (identical(expression, 1)) return(character())
  if (is.name(expression)) return(as.character(expression))
  if (is.call(expression) && identical(expression[[1]], quote(`+`)) && length(expression) == 3) return(c(plain_terms(expression[[2]]), plain_terms(expression[[3]])))
  stop_formula("a correlation over ", deparse1(expression), " is not available; add a column to the data")
}

# The groups of a correlation are within those of the random effects, as nlme requires; it has no crossed ones.
check_nesting <- function(correlation, effects, data) {
  groups <- effects$groups
  if (!inherits(correlation, "corStruct")) return(invisible())
  nested <- setdiff(all.vars(nlme::getGroupsFormula(correlation)), groups)
  if (length(nested) > 1 && all(nested %in% names(data))) {
    levels <- unique(data[nested])
    last <- nested[length(nested)]
    if (anyDuplicated(levels[[last]]) > 0) stop_usage("`correlation`: labels of ", last, " recur in other groups of ", nested[1], "; add a column with labels of their own, such as interaction(", paste(nested, collapse = ", "), ")")
  }
  if (length(groups) == 0 || grepl("\\|[^;]*[+]", effects$text)) return(invisible())
  own <- all.vars(nlme::getGroupsFormula(correlation))
  if (length(own) == 0 || length(intersect(own, groups)) > 0 || !all(own %in% names(data))) return(invisible())
  levels <- unique(data[c(own, groups)])
  if (anyDuplicated(levels[own]) > 0) {
    stop_usage("incompatible formulas for groups: those of `correlation`, ", paste(own, collapse = "/"), ", are not within those of `random`; write ~ ... | ", paste(c(groups, own), collapse = "/"))
  }
}

# Names of columns in a text.
correlation_names <- function(text) {
  if (is.null(text)) return(character())
  inside <- regmatches(text, regexpr("(?<=\\().*(?=\\)$)", text, perl = TRUE))
  gsub("`", "", trimws(unlist(strsplit(inside, "[,|;]"))))
}
