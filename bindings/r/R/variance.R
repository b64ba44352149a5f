# SPDX-License-Identifier: MIT
# Variance functions of nlme as texts of silvafit.

# \param variance  NULL, a text, a formula as in varFixed, or an object of class varFunc
variance_text <- function(variance) {
  if (is.null(variance)) return("")
  if (is.character(variance)) return(paste(variance, collapse = " * "))
  if (inherits(variance, "formula")) return(var_fixed_text(variance))
  if (inherits(variance, "varComb")) {
    return(paste(vapply(variance, variance_text, ""), collapse = " * "))
  }
  if (!inherits(variance, "varFunc")) {
    stop_usage("`variance` has to be a text such as \"power\", or an object of nlme such as varPower(form = ~ dbh)")
  }
  if (inherits(variance, "varFixed")) return(var_fixed_text(stats::formula(variance)))
  if (inherits(variance, "varIdent")) return(var_ident_text(variance))
  name <- c(varPower = "power", varExp = "exponential", varConstPower = "constant-plus-power")[class(variance)[1]]
  if (is.na(name)) {
    stop_usage("the variance function ", class(variance)[1], " is not available; available: ",
               "varPower, varExp, varConstPower, varIdent, varFixed, varComb")
  }
  form <- stats::formula(variance)
  parts <- form_parts(form)
  held <- held_parameters(variance)
  inside <- parts$column
  if (parts$stratum != "") inside <- paste(if (inside == "") "fitted" else inside, "|", parts$stratum)
  inside <- paste(c(if (inside != "") inside, held), collapse = ", ")
  paste0(name, if (inside != "") paste0("(", inside, ")"))
}

# ~ fitted(.) | species, ~ dbh
form_parts <- function(form) {
  expression <- form[[2]]
  stratum <- ""
  if (is.call(expression) && identical(expression[[1]], quote(`|`))) {
    if (!is.name(expression[[3]])) stop_formula("the strata ", deparse1(expression[[3]]), " of a variance function have to be one column")
    stratum <- name_text(as.character(expression[[3]]))
    expression <- expression[[2]]
  }
  column <- ""
  if (is.name(expression)) {
    column <- name_text(as.character(expression))
  } else if (!identical(expression, quote(fitted(.))) && !identical(expression, 1)) {
    stop_formula("a variance function of ", deparse1(expression), " is not available; add a column to the data")
  }
  list(column = column, stratum = stratum)
}

held_parameters <- function(variance) {
  if (inherits(variance, "varConstPower")) {
    # nlme keeps the logarithm of the constant.
    constant <- attr(variance$const, "fixed")
    power <- attr(variance$power, "fixed")
    return(c(if (length(constant) > 0) paste("constant =", number_text(exp(one_value(constant)))),
             if (length(power) > 0) paste("delta =", number_text(one_value(power)))))
  }
  fixed <- attr(variance, "fixed")
  if (length(fixed) > 0) paste("delta =", number_text(one_value(fixed)))
}

one_value <- function(fixed) {
  value <- unlist(fixed)
  if (length(value) != 1 || !is.null(names(value))) {
    stop_usage("a variance function with a fixed value in one stratum only is not available")
  }
  value
}

var_ident_text <- function(variance) {
  parts <- form_parts(stats::formula(variance))
  if (parts$stratum == "") stop_usage("varIdent() needs strata, as in varIdent(form = ~ 1 | species)")
  if (length(attr(variance, "fixed")) > 0) stop_usage("varIdent() with fixed ratios is not available")
  paste0("stratum(", parts$stratum, ")")
}

var_fixed_text <- function(form) {
  if (length(form) != 2 || !is.name(form[[2]])) stop_usage("`variance`: a formula names one column, as in ~ dbh, to which the variance is proportional")
  paste0("power(", name_text(as.character(form[[2]])), ", delta = 0.5)")
}

# Names of columns in a text.
variance_names <- function(text) {
  if (text == "") return(character())
  plain <- gsub("constant-plus-power", "constant_plus_power", text, fixed = TRUE)
  tryCatch(all.vars(str2lang(plain)), error = function(e) character())
}
