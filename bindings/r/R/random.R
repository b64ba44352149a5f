# SPDX-License-Identifier: MIT
# Random effects of R's formulas and nlme's pd classes as a text of silvafit.

# \return  text such as "a | stand; a + b | plot", the form of the covariance of each grouping, and
#          the columns of the groups
random_effects <- function(random, groups, data, contrasts) {
  if (is.null(random)) return(list(text = "", covariance = NULL, groups = character()))
  if (is.character(random)) return(list(text = paste(random, collapse = "; "), covariance = NULL, groups = text_groups(random)))
  terms <- random_terms(random, random_groups(groups))
  parts <- lapply(terms, random_part, data = data, contrasts = contrasts)
  merged <- merged_by_group(parts)
  covariance <- vapply(merged, function(part) part$covariance, "")
  text <- paste(vapply(merged, function(part) paste(part$effects, "|", group_text(part$group)), ""), collapse = "; ")
  list(text = text, covariance = if (all(covariance == "")) NULL else ifelse(covariance == "", "general", covariance),
       groups = unique(unlist(lapply(merged, `[[`, "group"))))
}

# Columns that are nested unless they have a text of their own; see group_names().
group_text <- function(group) if (is.null(attr(group, "text"))) paste(vapply(group, name_text, ""), collapse = "/") else attr(group, "text")

# The columns of groups in a text of silvafit.
text_groups <- function(text) {
  after <- unlist(regmatches(text, gregexpr("\\|[^|;()]*", text)))
  unique(gsub("[|`]", "", trimws(unlist(strsplit(sub("|", "", after, fixed = TRUE), "[/+:]")))))
}

# nlme's `groups = ~ stand/plot`.
random_groups <- function(groups) {
  if (is.null(groups)) return(NULL)
  group_names(as_formula(groups, "groups")[[2]])
}

# stand/plot as c("stand", "plot"), the coarser first. Crossed groups, plot + year, and combinations, recipe:replicate, have the
# attribute `text`.
group_names <- function(expression) {
  expression <- strip_parentheses(expression)
  if (is.name(expression)) return(as.character(expression))
  operator <- if (is.call(expression) && length(expression) == 3) as.character(expression[[1]]) else ""
  if (!operator %in% c("/", "+", ":")) {
    stop_formula("'", deparse1(expression), "' is not a group; write the name of a column, stand/plot, or plot + year for crossed groups")
  }
  parts <- list(group_names(expression[[2]]), group_names(expression[[3]]))
  text <- if (operator != "/" || !all(vapply(parts, function(part) is.null(attr(part, "text")), NA))) {
    paste(vapply(parts, group_text, ""), collapse = if (operator == "+") " + " else operator)
  }
  structure(c(parts[[1]], parts[[2]]), text = text)
}

# One entry for each formula: its formulas, the groups, and the form of the covariance.
random_terms <- function(random, groups) {
  if (inherits(random, "pdMat")) return(list(pd_term(random, groups)))
  if (inherits(random, "formula")) return(list(formula_term(random, groups)))
  if (!is.list(random)) stop_usage("`random` has to be a formula such as a + b ~ 1 | plot, a list of formulas, or a text")
  # list(a ~ 1, b ~ 1) of nlme: the effects of one grouping, which are correlated.
  own <- if (is.null(names(random))) rep("", length(random)) else names(random)
  joint <- own == "" & vapply(random, function(one) inherits(one, "formula") && !names_groups(one), NA)
  result <- if (any(joint)) list(list(formulas = unname(random[joint]), group = groups, covariance = ""))
  random <- random[!joint]
  for (i in seq_along(random)) {
    own <- if (is.null(names(random)) || names(random)[i] == "") groups else names(random)[i]
    element <- random[[i]]
    if (is.list(element) && !inherits(element, c("pdMat", "formula"))) {
      result <- c(result, list(list(formulas = element, group = own, covariance = "")))
    } else {
      result <- c(result, random_terms(element, own))
    }
  }
  result
}

names_groups <- function(formula) {
  right <- formula[[length(formula)]]
  is.call(right) && identical(right[[1]], quote(`|`))
}

formula_term <- function(formula, groups) {
  right <- formula[[length(formula)]]
  own <- groups
  if (names_groups(formula)) {
    own <- group_names(right[[3]])
    formula[[length(formula)]] <- right[[2]]
  }
  list(formulas = list(formula), group = own, covariance = "")
}

pd_term <- function(pd, groups) {
  if (inherits(pd, "pdBlocked")) {
    blocks <- lapply(pd, function(block) pd_term(block, groups))
    return(list(blocks = lapply(blocks, `[[`, "formulas"), group = groups, covariance = "", forms = vapply(blocks, `[[`, "", "covariance")))
  }
  covariance <- if (inherits(pd, "pdDiag")) "diagonal" else if (inherits(pd, "pdIdent")) "identity"
                else if (inherits(pd, "pdCompSymm")) "compound-symmetry"
                else if (inherits(pd, c("pdSymm", "pdLogChol", "pdNatural"))) "general"
                else stop_usage("the covariance class ", class(pd)[1], " is not available; available: pdSymm, pdLogChol, pdNatural, pdDiag, pdIdent, pdCompSymm, pdBlocked")
  formulas <- stats::formula(pd)
  if (is.null(formulas)) stop_usage(class(pd)[1], "() needs a formula, as in ", class(pd)[1], "(a + b ~ 1)")
  if (inherits(formulas, "formula")) formulas <- list(formulas)
  list(formulas = unclass(formulas), group = groups, covariance = covariance)
}

# The coefficients that vary, as text.
random_part <- function(term, data, contrasts) {
  if (is.null(term$group)) {
    stop_usage("`random` does not name the groups; write, for example, random = a ~ 1 | plot, or groups = ~ plot")
  }
  for (group in term$group) if (!group %in% names(data)) stop_no_column(group, data, "`random`")
  refuse_levels(term, data)
  names_of <- function(formulas) {
    unlist(lapply(formulas, function(formula) effects_of(as_formula(formula, "random"), data, contrasts)))
  }
  effects <- if (is.null(term$blocks)) paste(names_of(term$formulas), collapse = " + ")
             else paste0("(", vapply(term$blocks, function(block) paste(names_of(block), collapse = " + "), ""), ")", collapse = " + ")
  list(effects = effects, group = term$group, covariance = term$covariance)
}

# Equal variances of effects for all levels of a factor, as in pdIdent(a ~ sample - 1), are a grouping of its own.
refuse_levels <- function(term, data) {
  blocks <- if (is.null(term$blocks)) list(term$formulas) else term$blocks
  forms <- if (is.null(term$blocks)) term$covariance else term$forms
  factors <- ifelse(forms == "identity", vapply(blocks, level_factor, "", data = data), "")
  at <- which(factors != "")
  if (length(at) == 0) return(invisible())
  has_own <- any(vapply(blocks, function(block) identical(block[[1]][[length(block[[1]])]], 1), NA))
  inner <- paste0(group_text(term$group), if (has_own) "/" else ":", vapply(factors[at], name_text, ""), collapse = " + ")
  stop_formula("`random`: effects for each level of ", factors[at[1]], " with one variance are those of groups within ", group_text(term$group), "; write random = \"",
               deparse1(blocks[[at[1]]][[1]][[2]]), " | ", inner, "\"")
}

# The factor of a ~ sample - 1; empty for other formulas.
level_factor <- function(formulas, data) {
  right <- if (length(formulas) == 1 && inherits(formulas[[1]], "formula")) setdiff(all.vars(formulas[[1]][[length(formulas[[1]])]]), ".")
  if (length(right) != 1 || !right %in% names(data) || !is_text(data[[right]])) return("")
  terms <- stats::terms(formulas[[1]][-2])
  if (attr(terms, "intercept") == 0 && identical(attr(terms, "term.labels"), name_text(right))) right else ""
}

effects_of <- function(formula, data, contrasts) {
  if (length(formula) != 3) stop_formula("`random`: ", deparse1(formula), " does not name coefficients; write, for example, a + b ~ 1 | plot")
  right <- formula[c(1, 3)]
  environment(right) <- environment(formula)
  columns <- sub_model_columns(right, data, contrasts, "`random`")
  unlist(lapply(summands(formula[[2]]), function(coefficient) {
    # A coefficient of a covariate may be named itself, b:C.
    name <- if (is.name(coefficient)) name_text(as.character(coefficient)) else gsub(" ", "", deparse1(coefficient), fixed = TRUE)
    c(if (columns$intercept) name, if (length(columns$texts) > 0) paste0(name, ":", columns$texts))
  }))
}

# Several formulas with the same groups are independent blocks, as in lme4.
merged_by_group <- function(parts) {
  keys <- vapply(parts, function(part) group_text(part$group), "")
  lapply(unique(keys), function(key) {
    same <- parts[keys == key]
    if (length(same) == 1) return(same[[1]])
    same[[1]]$effects <- paste0("(", vapply(same, `[[`, "", "effects"), ")", collapse = " + ")
    same[[1]]$covariance <- ""
    same[[1]]
  })
}
