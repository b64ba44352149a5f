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
  columns <- if (class == "corCompSymm") character() else vapply(all.vars(expression), name_text, "")
  if (class == "corARMA") columns <- c(attr(correlation, "p"), attr(correlation, "q"), columns)
  inside <- paste(columns, collapse = ", ")
  if (length(own) > 0) inside <- paste(if (length(all.vars(expression)) == 0 || class == "corCompSymm") paste(c(columns, "1"), collapse = ", ") else inside, "|", name_text(own))
  if (isTRUE(attr(correlation, "nugget"))) inside <- paste0(inside, "; nugget")
  paste0(correlation_classes[[class]], if (inside != "") paste0("(", inside, ")"))
}

# The groups of a correlation are within those of the random effects, as nlme requires; it has no crossed ones.
check_nesting <- function(correlation, effects, data) {
  groups <- effects$groups
  if (!inherits(correlation, "corStruct") || length(groups) == 0 || grepl("\\|[^;]*[+]", effects$text)) return(invisible())
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
  trimws(unlist(strsplit(inside, "[,|;]")))
}
