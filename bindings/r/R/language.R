# SPDX-License-Identifier: MIT
# Expressions of R as texts of silvafit's formula language.

known_functions <- c("exp", "log", "log10", "log2", "log1p", "expm1", "sqrt", "abs", "sign", "sin", "cos", "tan",
                     "asin", "acos", "atan", "sinh", "cosh", "tanh", "pow", "min", "max", "ifelse", "I")

# Precedence as R and silvafit have it; a name or a call binds tighter than all of them.
operator_precedence <- c("||" = 1, "|" = 1, "&&" = 2, "&" = 2, "!" = 3, "<" = 4, "<=" = 4, ">" = 4, ">=" = 4, "==" = 4, "!=" = 4,
                         "+" = 5, "-" = 5, "*" = 6, "/" = 6, "unary" = 7, "^" = 8)

# The self-starting models of stats, which C++ knows by the places of their arguments.
self_start_models <- c("SSasymp", "SSasympOff", "SSasympOrig", "SSbiexp", "SSfpl", "SSgompertz", "SSlogis", "SSmicmen", "SSweibull", "SSfol")

# A call with its arguments by position, as R matches them. Other functions than those of base and stats have no names.
with_arguments_in_order <- function(call, name, what) {
  refuse <- function(...) stop_formula(name, "() in ", what, ": ", ...)
  if (name %in% c("min", "max", "pmin", "pmax")) {
    named <- names(call) %in% "na.rm"
    if (any(named) && !isFALSE(eval(call$na.rm, baseenv()))) refuse("na.rm has to be FALSE; replace missing values in the data")
    return(if (any(named)) call[!named] else call)
  }
  definition <- args(get0(name, asNamespace("stats"), mode = "function"))
  if (is.null(definition)) {
    if (any(nzchar(names(call)))) refuse("arguments have no names")
    return(call)
  }
  matched <- tryCatch(as.list(match.call(definition, call))[-1], error = function(e) refuse(conditionMessage(e)))
  is_needed <- vapply(formals(definition), function(default) identical(default, quote(expr = )), NA)
  if (!all(names(which(is_needed)) %in% names(matched))) refuse("the arguments are ", paste(names(formals(definition)), collapse = ", "))
  as.call(c(call[[1]], unname(matched[intersect(names(formals(definition)), names(matched))])))
}

number_text <- function(value) {
  if (!is.finite(value)) stop_formula("a formula cannot contain ", value)
  text <- deparse(value, control = "digits17")
  sub("L$", "", text)
}

string_text <- function(text) {
  if (!grepl("\"", text, fixed = TRUE)) return(paste0("\"", text, "\""))
  if (grepl("'", text, fixed = TRUE)) stop_formula("a text with both kinds of quotes cannot be used: ", text)
  paste0("'", text, "'")
}

name_text <- function(name) {
  if (grepl("^[[:alpha:]_][[:alnum:]_.]*$", name)) return(name)
  if (grepl("`", name, fixed = TRUE)) stop_formula("the name ", name, " contains a backquote; rename the column")
  paste0("`", name, "`")
}

# Texts in which pi, which is a name in backquotes, is the number unless a column has the name.
with_pi <- function(texts, columns) if ("pi" %in% columns) texts else gsub("`pi`", "pi", texts, fixed = TRUE)

# The text of an expression. `what` says where it stands, for messages.
expression_text <- function(expression, what = "the formula") {
  text_and_precedence(expression, what)$text
}

# The text of the right side of a formula, in which a summand may be a random effect of lme4, (1 | plot): it stays as it is, for C++ to read.
right_side_text <- function(expression) {
  if (is_bar(expression)) return(bar_text(expression))
  inside <- strip_parentheses(expression)
  if (is.call(expression) && identical(expression[[1]], quote(`(`)) && is_bar(inside)) return(paste0("(", bar_text(inside), ")"))
  if (is.call(expression) && identical(expression[[1]], quote(`+`)) && length(expression) == 3) {
    if (has_bar_summand(expression)) return(paste(right_side_text(expression[[2]]), "+", right_side_text(expression[[3]])))
  }
  expression_text(expression)
}

has_bar_summand <- function(expression) any(vapply(summands_as_written(expression), function(one) is_bar(strip_parentheses(one)), logical(1)))

# The parts of a + b + c; parentheses stay.
summands_as_written <- function(expression) {
  if (is.call(expression) && identical(expression[[1]], quote(`+`)) && length(expression) == 3) {
    return(c(summands_as_written(expression[[2]]), summands_as_written(expression[[3]])))
  }
  list(expression)
}

# Whether a | b or a || b is a random effect: neither side is a condition.
is_bar <- function(expression) {
  is.call(expression) && as.character(expression[[1]])[1] %in% c("|", "||") && length(expression) == 3 &&
    !is_comparison(expression[[2]]) && !is_comparison(expression[[3]])
}

bar_text <- function(expression) {
  part <- function(one) gsub("\n", " ", deparse1(one), fixed = TRUE)
  paste(part(expression[[2]]), as.character(expression[[1]]), part(expression[[3]]))
}

# A formula without such terms.
without_bars <- function(formula) {
  if (is.null(formula) || length(formula) != 3) return(formula)
  kept <- Filter(function(one) !is_bar(strip_parentheses(one)), summands_as_written(formula[[3]]))
  if (length(kept) > 0) formula[[3]] <- Reduce(function(a, b) call("+", a, b), kept)
  formula
}

text_and_precedence <- function(expression, what) {
  atom <- function(text) list(text = text, precedence = 9)
  if (is.name(expression)) return(atom(if (identical(expression, quote(pi))) "`pi`" else name_text(as.character(expression))))
  if (is.logical(expression) && !is.na(expression)) return(atom(if (expression) "1" else "0"))
  if (is.numeric(expression)) {
    if (expression < 0) return(list(text = number_text(expression), precedence = operator_precedence[["unary"]]))
    return(atom(number_text(expression)))
  }
  if (is.character(expression)) return(atom(string_text(expression)))
  if (!is.call(expression) || !is.name(expression[[1]])) {
    stop_formula("'", deparse1(expression), "' cannot be used in ", what)
  }
  call_text(expression, as.character(expression[[1]]), what)
}

call_text <- function(call, name, what) {
  atom <- function(text) list(text = text, precedence = 9)
  if (name == "(") return(atom(paste0("(", expression_text(call[[2]], what), ")")))
  if (name %in% names(operator_precedence)) return(operator_text(call, name, what))
  if (name == "%in%") return(atom(membership_text(call, what)))
  if (!name %in% c(known_functions, self_start_models, "pmin", "pmax", "offset")) {
    stop_formula("unknown function '", name, "()' in ", what, "; available: ", paste(known_functions, collapse = ", "))
  }
  call <- with_arguments_in_order(call, name, what)
  if (name %in% c("pmin", "pmax")) name <- substr(name, 2, 4)
  if (name == "offset") return(atom(paste0("(", expression_text(call[[2]], what), ")")))
  if (name == "log" && length(call) == 3) {
    return(atom(paste0("I(log(", expression_text(call[[2]], what), ")/log(", expression_text(call[[3]], what), "))")))
  }
  arguments <- vapply(as.list(call)[-1], expression_text, "", what = what)
  atom(paste0(name, "(", paste(arguments, collapse = ", "), ")"))
}

operator_text <- function(call, name, what) {
  # (1 | plot) elsewhere than in a sum would be a logical or.
  if (is_bar(call) && (is.numeric(call[[2]]) || is.numeric(call[[3]]))) {
    stop_formula("'", deparse1(call), "' in ", what, " is not a condition; random effects are an argument, such as random = a ~ 1 | plot")
  }
  written <- switch(name, "&" = "&&", "|" = "||", name)
  if (length(call) == 2) {
    operand <- text_and_precedence(call[[2]], what)
    # In R, !x > 2 is !(x > 2); here the parentheses say so.
    if (name == "!") return(list(text = paste0("!(", operand$text, ")"), precedence = operator_precedence[["unary"]]))
    own <- operator_precedence[["unary"]]
    return(list(text = paste0(written, in_parentheses(operand, operand$precedence < own)), precedence = own))
  }
  own <- operator_precedence[[name]]
  left <- text_and_precedence(call[[2]], what)
  right <- text_and_precedence(call[[3]], what)
  # From left to right, but for the power.
  is_right <- name == "^"
  left_text <- in_parentheses(left, if (is_right) left$precedence <= own else left$precedence < own)
  right_text <- in_parentheses(right, if (is_right) right$precedence < own && right$precedence != operator_precedence[["unary"]]
                                      else right$precedence <= own)
  separator <- if (name %in% c("^", "*", "/")) "" else " "
  list(text = paste0(left_text, separator, written, separator, right_text), precedence = own)
}

in_parentheses <- function(part, is_needed) if (is_needed) paste0("(", part$text, ")") else part$text

membership_text <- function(call, what) {
  values <- tryCatch(eval(call[[3]], baseenv()), error = function(e) NULL)
  if (!is.character(values) || length(values) == 0) {
    stop_formula("'", deparse1(call), "' cannot be used in ", what, "; write the texts, as in species %in% c(\"A\", \"B\")")
  }
  column <- expression_text(call[[2]], what)
  paste0("(", paste0(column, " == ", vapply(values, string_text, ""), collapse = " || "), ")")
}
