# SPDX-License-Identifier: MIT
# The examples of Pinheiro and Bates (2000) with blocks, identities and interactions of random effects, by lme() of nlme.
# Run from this folder: Rscript reference_effects.R
# Writes Assay.csv, Wafer.csv and Machines.csv into tests/reference/data-gpl, and tests/reference/expected/nlme_effects.json.
source("json.R")
library(nlme)

write <- function(data, name) write.csv(data, file.path("../../tests/reference/data-gpl", name), row.names = FALSE, quote = FALSE)
# pdIdent(~ sample - 1) is a random intercept of each sample of a block.
assay <- transform(as.data.frame(Assay), dilut = paste0("d", dilut))
write(assay, "Assay.csv")
write(as.data.frame(Wafer), "Wafer.csv")
write(as.data.frame(Machines), "Machines.csv")

tight <- lmeControl(opt = "optim", msTol = 1e-14, tolerance = 1e-12, maxIter = 500, msMaxIter = 5000, optimMethod = "BFGS", reltol = 1e-16)
figures <- function(id, data, formula, parameter, random, diagonal, fit) {
  lapply(c("ML", "REML"), function(method) {
    one <- update(fit, method = method, control = tight)
    list(id = paste0(id, "_", tolower(method)), data = data, formula = formula, parameter = parameter, random = random, diagonal = diagonal,
         reml = method == "REML", logLik = as.numeric(logLik(one)), sigma = one$sigma, fixed = I(unname(fixef(one))),
         std_errors = I(unname(sqrt(diag(vcov(one))))), fitted = I(unname(fitted(one))))
  })
}
assay_fit <- lme(logDens ~ sample * dilut, Assay,
                 random = list(Block = pdBlocked(list(pdIdent(~ 1), pdIdent(~ sample - 1), pdIdent(~ dilut - 1)))))
wafer_fit <- lme(current ~ voltage + I(voltage^2), Wafer, random = list(Wafer = pdDiag(~ voltage + I(voltage^2)), Site = pdDiag(~ voltage + I(voltage^2))))
machines_fit <- lme(score ~ Machine - 1, Machines, random = ~ Machine - 1 | Worker)
interaction_fit <- lme(score ~ Machine, Machines, random = ~ 1 | Worker / Machine)
fits <- c(
  figures("assay", "Assay.csv", "logDens ~ m", "m ~ sample * dilut", "m | Block/sample + Block/dilut", FALSE, assay_fit),
  figures("wafer", "Wafer.csv", "current ~ a + b*voltage + c*voltage^2", "", "a + b + c | Wafer/Site", TRUE, wafer_fit),
  figures("machines", "Machines.csv", "score ~ m", "m ~ 0 + Machine",
          'm:(Machine == "A") + m:(Machine == "B") + m:(Machine == "C") | Worker', FALSE, machines_fit),
  figures("machines_in_workers", "Machines.csv", "score ~ m", "m ~ Machine", "m | Worker/Machine", FALSE, interaction_fit))
write_expected("nlme_effects.json", c(versions("nlme"), list(script = "bench/r/reference_effects.R")), fits)
