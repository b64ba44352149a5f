# SPDX-License-Identifier: MIT
# Formulas have the meaning that they have in R: expected values are those of lm().
source("helpers.R", local = TRUE)
children <- as.data.frame(nlme::Orthodont)
set.seed(7)
children$z <- runif(108, 1, 5)
children$flag <- children$z > 3

# The same likelihood, and with the same columns the same names and coefficients.
same_as_lm <- function(sub, linear) {
  ours <- silvafit(distance ~ a + b * age, children, parameters = sub)
  theirs <- lm(linear, children)
  expect_equal(as.numeric(logLik(ours)), as.numeric(logLik(theirs)), tolerance = 1e-10)
  names <- c(sub("a:\\(Intercept\\)", "a", paste0("a:", setdiff(names(coef(theirs)), "age"))), "b")
  expect_equal(sort(names(fixef(ours))), sort(names))
  at <- match(names(fixef(ours)), c(names[-length(names)], "b"))
  expect_true(relative(fixef(ours), c(coef(theirs)[names(coef(theirs)) != "age"], coef(theirs)["age"])[at]) < 1e-8)
}

# Arguments have names, which may be shortened
same_as_lm(a ~ ifelse(z > 2, no = 1, yes = 0), distance ~ ifelse(z > 2, no = 1, yes = 0) + age)
same_as_lm(a ~ log(base = 2, z), distance ~ log(base = 2, z) + age)
same_as_lm(a ~ log(z, b = 2), distance ~ log(z, b = 2) + age)
same_as_lm(a ~ abs(x = z - 2), distance ~ abs(x = z - 2) + age)
expect_equal(unname(fixef(silvafit(distance ~ a + b * ifelse(age > 10, no = 0, yes = 1), children))), unname(coef(lm(distance ~ I(age > 10), children))), tolerance = 1e-8)
expect_equal(unname(fixef(silvafit(distance ~ a + b * pmax(age, 10, na.rm = FALSE), children))), unname(coef(lm(distance ~ pmax(age, 10), children))), tolerance = 1e-8)
for (wrong in c("log(age, foo = 2)", "exp(foo = -age)", "log10(age, 5)", "log(base = 2)", "ifelse(age > 10, 1)", "pmin(age, 10, na.rm = TRUE)", "pow(x = age, 2)", "SSlogis(age, q = 1, 2, 3)")) {
  expect_equal(class_of_error(silvafit(paste("distance ~ a + b *", wrong), children)), "silvafit_formula_error", info = wrong)
  expect_equal(class_of_error(silvafit(distance ~ a + b * age, children, parameters = paste("a ~ ", wrong))), "silvafit_formula_error", info = wrong)
}
expect_equal(class_of_error(silvafit(distance ~ a, children, parameters = a ~ offset(foo = z))), "silvafit_formula_error")

# Logical expressions are factors
same_as_lm(a ~ 0 + I(z > 2), distance ~ 0 + I(z > 2) + age)
same_as_lm(a ~ z:I(z > 2), distance ~ z:I(z > 2) + age)
same_as_lm(a ~ I(!(z > 2)) * Sex, distance ~ I(!(z > 2)) * Sex + age)
same_as_lm(a ~ 0 + flag, distance ~ 0 + flag + age)
same_as_lm(a ~ flag:z, distance ~ flag:z + age)
same_as_lm(a ~ 0 + I(flag), distance ~ 0 + I(flag) + age)
same_as_lm(a ~ 0 + ifelse(z > 2, flag, TRUE), distance ~ 0 + ifelse(z > 2, flag, TRUE) + age)
children$g <- rep(1:3, 36)
same_as_lm(a ~ factor(g):z, distance ~ factor(g):z + age)
same_as_lm(a ~ as.factor(x = g), distance ~ as.factor(x = g) + age)
refused <- class_of_error(silvafit(distance ~ a, children, parameters = a ~ factor(labels = g)))
expect_equal(refused, "silvafit_formula_error")

# pi is a number unless a column has this name
children$pi <- children$z
same_as_lm(a ~ I(pi^2), distance ~ I(pi^2) + age)
expect_equal(unname(fixef(silvafit(distance ~ a + b * age / pi, children))), unname(coef(lm(distance ~ I(age / pi), children))), tolerance = 1e-8)
file <- tempfile()
fit_json(silvafit(distance ~ a + b * age / pi, children), file)
expect_equal(unname(predict(read_fit(file), children[1:3, ])), unname(predict(lm(distance ~ I(age / pi), children), children[1:3, ])), tolerance = 1e-8)
children$pi <- NULL
same_as_lm(a ~ I(pi * z^2), distance ~ I(pi * z^2) + age)

# Terms are added to formulas with bars.
with_bar <- silvafit(distance ~ a + b * age + (1 | Subject), nlme::Orthodont)
longer <- update(with_bar, . ~ . + d * age^2)
expect_equal(names(fixef(longer)), c("a", "b", "d"))
expect_equal(as.numeric(logLik(longer)), as.numeric(logLik(nlme::lme(distance ~ age + I(age^2), nlme::Orthodont, random = ~ 1 | Subject, method = "ML"))), tolerance = 1e-9)
