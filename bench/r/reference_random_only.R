# SPDX-License-Identifier: MIT
# Random effects without a fixed effect: by lme() and nlme() of nlme.
# Run from this folder: Rscript reference_random_only.R
# Writes tests/reference/expected/random_only.json; the data are those of tests/reference/data-gpl and of lme4's sleepstudy.
source("json.R")
library(nlme)

tight <- lmeControl(opt = "nlminb", msTol = 1e-14, tolerance = 1e-12, maxIter = 500, msMaxIter = 5000)
read <- function(name) read.csv(file.path("../../tests/reference/data-gpl", name))
write <- function(data, name) write.csv(data, file.path("../../tests/reference/data-gpl", name), row.names = FALSE, quote = FALSE)
write(lme4::sleepstudy, "sleepstudy.csv")

figures <- function(id, data, formula, parameters, held, random, diagonal, fit) {
  table <- summary(fit)$tTable
  list(id = id, data = data, formula = formula, parameters = I(parameters), held = I(held), random = random, diagonal = diagonal,
       reml = fit$method == "REML", logLik = as.numeric(logLik(fit)), aic = AIC(fit), sigma = fit$sigma,
       names = I(names(fixef(fit))), fixed = I(unname(fixef(fit))), std_errors = I(unname(table[, "Std.Error"])), df = I(unname(table[, "DF"])),
       covariances = lapply(rev(lapply(fit$modelStruct$reStruct, function(of) unname(as.matrix(of)) * fit$sigma^2)), function(of) I(of)) |> unname(),
       fitted = I(unname(fitted(fit))), population = I(unname(fitted(fit, level = 0))))
}
both <- function(id, data, formula, parameters, held, random, diagonal, fit) {
  lapply(c("ML", "REML"), function(method) {
    figures(paste0(id, "_", tolower(method)), data, formula, parameters, held, random, diagonal, update(fit, method = method, control = tight))
  })
}
orthodont <- groupedData(distance ~ age | Subject, read("Orthodont.csv"))
sleep <- read("sleepstudy.csv")
oats <- read("Oats.csv")
machines <- read("Machines.csv")

# A random slope alone; with a random intercept; and one that the mean has not, beside one that it has.
slope <- lme(distance ~ 1, as.data.frame(orthodont), random = ~ age - 1 | Subject)
sleeping <- lme(Reaction ~ 1, sleep, random = ~ Days | Subject)
sexes <- lme(distance ~ age, as.data.frame(orthodont), random = list(Subject = pdDiag(~ I(age * (Sex == "Male")))))
nested <- lme(yield ~ 1, oats, random = list(Block = ~ nitro - 1, Variety = ~ nitro - 1))
machine <- lme(score ~ 1, machines, random = ~ Machine - 1 | Worker)

# nlme: effects that the mean has not, linear and nonlinear.
exact <- nlmeControl(tolerance = 1e-9, pnlsTol = 1e-5, msTol = 1e-14, maxIter = 500, pnlsMaxIter = 100, msMaxIter = 5000)
loblolly <- transform(read("Loblolly.csv"), Seed = factor(Seed))
orange <- transform(read("Orange.csv"), Tree = factor(Tree))
pines <- nlme(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age) + u * age / 25, loblolly, fixed = Asym + R0 + lrc ~ 1,
              random = list(Seed = pdDiag(u ~ 1)), start = c(Asym = 101.4, R0 = -8.6, lrc = -3.23), control = exact)
oranges <- nlme(circumference ~ A * exp(u) / (1 + exp((B - age) / C)), orange, fixed = A + B + C ~ 1,
                random = list(Tree = pdDiag(u ~ 1)), start = c(A = 192, B = 728, C = 348), control = exact)
fits <- c(
  both("orthodont_slope", "Orthodont.csv", "distance ~ a + u*age", character(), "u", "u | Subject", FALSE, slope),
  both("sleep_slope", "sleepstudy.csv", "Reaction ~ a + u*Days", character(), "u", "a + u | Subject", FALSE, sleeping),
  both("orthodont_sex", "Orthodont.csv", "distance ~ a + b*age", "b ~ Sex", 'b:(Sex == "Male")', 'a + b:(Sex == "Male") | Subject', TRUE, sexes),
  both("oats_nested", "Oats.csv", "yield ~ a + u*nitro", character(), "u", "u | Block/Variety", FALSE, nested),
  both("machines", "Machines.csv", "score ~ a + m", "m ~ 0 + Machine", paste0('m:(Machine == "', c("A", "B", "C"), '")'), 'm:(Machine == "A") + m:(Machine == "B") + m:(Machine == "C") | Worker', FALSE, machine),
  list(figures("loblolly", "Loblolly.csv", "height ~ Asym + (R0 - Asym)*exp(-exp(lrc)*age) + u*age/25", character(), "u", "u | Seed", FALSE, pines),
       figures("orange", "Orange.csv", "circumference ~ A*exp(u)/(1 + exp((B - age)/C))", character(), "u", "u | Tree", FALSE, oranges)))
write_expected("random_only.json", c(versions("nlme"), list(script = "bench/r/reference_random_only.R")), fits)
