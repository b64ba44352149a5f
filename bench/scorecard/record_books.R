# SPDX-License-Identifier: MIT
# The nlme, lme and gnls fits of family "books", by the names of books.py, and their log-likelihoods as recorded/nlme-books.csv.
# Calls follow Pinheiro and Bates 2000 and Venables and Ripley 2002 where they have one. Usage: Rscript bench/scorecard/record_books.R
suppressPackageStartupMessages({ library(nlme); library(MASS) })
options(contrasts = c("contr.treatment", "contr.poly"))
rows <- list()
fits <- list()

record <- function(name, call) {
  begin <- proc.time()
  setTimeLimit(cpu = 120, transient = TRUE)
  fit <- tryCatch(suppressWarnings(call), error = function(e) conditionMessage(e))
  setTimeLimit()
  seconds <- sum((proc.time() - begin)[c("user.self", "sys.self")])
  failed <- is.character(fit)
  rows[[name]] <<- data.frame(family = "books", case = name, method = "nlme", log_likelihood = if (failed) "" else sprintf("%.6f", logLik(fit)),
                              converged = if (failed) "no" else "yes", ended = "yes", fit_seconds = sprintf("%.4g", seconds),
                              cpu_seconds = sprintf("%.4g", seconds), estimates = "{}",
                              verdict = if (failed) substr(gsub("\\s+", " ", fit), 1, 80) else "")
  fits[[name]] <<- fit
}

indometh <- suppressWarnings(nlsList(conc ~ SSbiexp(time, A1, lrc1, A2, lrc2), data = Indometh))
record("Indometh-1", nlme(indometh, random = pdDiag(A1 + lrc1 + A2 + lrc2 ~ 1), control = list(tolerance = 1e-4)))
record("Indometh-2", update(fits[["Indometh-1"]], random = pdDiag(A1 + lrc1 + A2 ~ 1)))
record("Indometh-3", update(fits[["Indometh-2"]], random = A1 + lrc1 + A2 ~ 1))
record("Indometh-4", update(fits[["Indometh-3"]], random = pdBlocked(list(A1 + lrc1 ~ 1, A2 ~ 1))))

soybean <- suppressWarnings(nlsList(weight ~ SSlogis(Time, Asym, xmid, scal), data = Soybean, control = list(maxiter = 60)))
record("Soybean-1", nlme(soybean))
record("Soybean-2", update(fits[["Soybean-1"]], weights = varPower()))
s <- fixef(fits[["Soybean-2"]])
record("Soybean-3", update(fits[["Soybean-2"]], fixed = Asym + xmid + scal ~ Year, start = c(s[1], 0, 0, s[2], 0, 0, s[3], 0, 0)))
record("Soybean-4", nlme(weight ~ SSlogis(Time, Asym, xmid, scal), data = Soybean, weights = varPower(0.95), random = Asym ~ 1,
                         fixed = list(Asym ~ Year * Variety, xmid ~ Year + Variety, scal ~ Year),
                         start = c(17, 0, 0, 0, 0, 0, 52, 0, 0, 0, 7.5, 0, 0)))

orange <- c(Asym = 191.5, xmid = 722, scal = 344)
record("Orange-1", nlme(circumference ~ SSlogis(age, Asym, xmid, scal), data = Orange, fixed = Asym + xmid + scal ~ 1, start = orange))
record("Orange-2", nlme(circumference ~ SSlogis(age, Asym, xmid, scal), data = Orange, fixed = Asym + xmid + scal ~ 1, random = Asym ~ 1, start = orange))

theoph <- suppressWarnings(nlsList(conc ~ SSfol(Dose, Time, lKe, lKa, lCl), data = Theoph))
record("Theoph-1", nlme(theoph))
record("Theoph-2", nlme(theoph, random = pdDiag(lKe + lKa + lCl ~ 1)))
record("Theoph-3", nlme(theoph, random = pdDiag(lKa + lCl ~ 1)))
record("Theoph-4", nlme(theoph, random = pdDiag(lKa + lCl ~ 1), weights = varConstPower(power = 0.1)))

co2 <- suppressWarnings(nlsList(SSasympOff, CO2))
record("CO2-1", nlme(co2))
record("CO2-2", nlme(co2, random = Asym + lrc ~ 1))
record("CO2-3", update(fits[["CO2-2"]], fixed = list(Asym ~ Type * Treatment, lrc + c0 ~ 1), start = c(32.412, 0, 0, 0, -4.5603, 49.344)))
s <- fixef(fits[["CO2-3"]])
record("CO2-4", update(fits[["CO2-3"]], fixed = list(Asym + lrc ~ Type * Treatment, c0 ~ 1), start = c(s[1:5], 0, 0, 0, s[6])))
record("CO2-5", update(fits[["CO2-4"]], random = Asym ~ 1))

record("Wafer-2", nlme(current ~ A + B * cos(w * voltage + pi / 4), data = Wafer, fixed = list(A ~ voltage + I(voltage^2), B + w ~ 1),
                       random = list(Wafer = pdDiag(list(A ~ voltage + I(voltage^2), B + w ~ 1)), Site = pdDiag(list(A ~ voltage + I(voltage^2), B ~ 1))),
                       start = c(-4.255, 5.622, 1.258, -0.09555, 4.5679)))
record("Ovary", nlme(follicles ~ A + B * sin(2 * pi * w * Time) + C * cos(2 * pi * w * Time), data = Ovary, fixed = A + B + C + w ~ 1,
                     random = pdDiag(A + B + w ~ 1), start = c(12.18, -3.298, -0.862, 1)))
record("Dialyzer-1", gnls(rate ~ SSasympOff(pressure, Asym, lrc, c0), data = Dialyzer, params = list(Asym + lrc ~ QB, c0 ~ 1),
                          start = c(53.6, 8.6, 0.51, -0.26, 0.225)))
record("Dialyzer-2", update(fits[["Dialyzer-1"]], weights = varPower(form = ~pressure)))
record("Loblolly-1", nlme(height ~ SSasymp(age, Asym, R0, lrc), data = Loblolly, fixed = Asym + R0 + lrc ~ 1, random = Asym ~ 1,
                          start = c(Asym = 103, R0 = -8.5, lrc = -3.3)))
record("Loblolly-2", update(fits[["Loblolly-1"]], random = pdDiag(Asym + lrc ~ 1)))
record("Loblolly-3", update(fits[["Loblolly-1"]], random = Asym + R0 + lrc ~ 1))

chicks <- function(random, weights = NULL)
  nlme(weight ~ SSlogis(Time, Asym, xmid, scal), data = ChickWeight, fixed = Asym + xmid + scal ~ 1, random = random, weights = weights,
       start = c(Asym = 368, xmid = 20, scal = 10))
record("ChickWeight-1", chicks(Asym ~ 1 | Chick))
record("ChickWeight-2", chicks(list(Chick = pdDiag(Asym + xmid ~ 1))))
record("ChickWeight-3", chicks(Asym + xmid ~ 1 | Chick))
record("ChickWeight-4", chicks(Asym + xmid + scal ~ 1 | Chick, varPower()))
record("ChickWeight-5", chicks(Asym + xmid ~ 1 | Chick, varPower()))

record("Rabbit-1", nlme(BPchange ~ B + (A - B) / (1 + exp((log(Dose) - ld50) / th)), fixed = A + B + ld50 + th ~ 1, random = A + ld50 ~ 1 | Animal/Run,
                        data = Rabbit, start = c(A = 28, B = 1.6, ld50 = 3.9, th = -0.25)))
record("Rabbit-2", update(fits[["Rabbit-1"]], fixed = list(A ~ Treatment, B ~ Treatment, ld50 ~ Treatment, th ~ Treatment),
                          start = c(28, 0, 1.6, 0, 3.9, 0.5, -0.25, 0)))
record("Sitka", nlme(size ~ A + B * (1 - exp(-(Time - 100) / C)), fixed = list(A ~ treat, B ~ treat, C ~ 1), random = A + B ~ 1 | tree, data = Sitka,
                     start = list(fixed = c(2, 0, 4, 0, 100)), method = "ML"))
record("PBG", nlme(deltaBP ~ A + (B - A) / (1 + exp((xmid - log(dose)) / scal)), data = PBG, fixed = list(A + B ~ 1, xmid ~ Treatment, scal ~ 1),
                   random = B + xmid ~ 1 | Rabbit, start = c(1, 28, 3.9, 0.5, 0.3)))
cefamandole <- suppressWarnings(nlsList(SSbiexp, Cefamandole))
record("Cefamandole-1", nlme(cefamandole, random = pdDiag(A1 + lrc1 ~ 1)))
record("Cefamandole-2", nlme(cefamandole, random = pdDiag(A1 + lrc1 ~ 1), weights = varPower()))
record("Spruce-1", nlme(logSize ~ SSasymp(days, Asym, R0, lrc), data = Spruce, fixed = Asym + R0 + lrc ~ 1, random = Asym + R0 ~ 1 | Tree,
                        start = c(6.5, 3.5, -5)))
record("Spruce-2", nlme(logSize ~ SSasymp(days, Asym, R0, lrc), data = Spruce, fixed = Asym + R0 + lrc ~ 1,
                        random = list(plot = Asym ~ 1, Tree = Asym + R0 ~ 1), start = c(6.5, 3.5, -5)))
record("Nitrendipene", nlme(activity ~ A + (B - A) / (1 + exp((xmid - log(NIF)) / scal)), data = as.data.frame(Nitrendipene), fixed = A + B + xmid + scal ~ 1,
                            random = A ~ 1 | Tissue, start = c(2000, 100, -21, 1)))

record("Orthodont-1", lme(distance ~ age * Sex, data = Orthodont, random = ~ age | Subject))
record("Orthodont-2", lme(distance ~ age * Sex, data = Orthodont, random = ~ age | Subject, weights = varIdent(form = ~ 1 | Sex), method = "ML"))
record("Oxide", lme(Thickness ~ 1, Oxide))
record("Pixel-1", lme(pixel ~ day + I(day^2), data = Pixel, random = list(Dog = ~day, Side = ~1), method = "ML"))
record("Pixel-2", lme(pixel ~ day + I(day^2), data = Pixel, random = list(Dog = ~day, Side = ~1)))
record("BodyWeight", lme(weight ~ Time * Diet, BodyWeight, random = ~ Time | Rat, weights = varPower(), method = "ML"))
record("Dialyzer-3", lme(rate ~ (pressure + I(pressure^2) + I(pressure^3) + I(pressure^4)) * QB, Dialyzer, ~ pressure + I(pressure^2),
                         weights = varPower(form = ~pressure), method = "ML"))
record("RatPupWeight", lme(weight ~ sex * Treatment + Lsize, data = RatPupWeight, random = ~ 1 | Litter, weights = varIdent(form = ~ 1 | Treatment), method = "ML"))
record("IGF-1", lme(conc ~ age, data = IGF, random = ~ age | Lot, method = "ML"))
record("IGF-2", lme(conc ~ age, data = IGF, random = list(Lot = pdDiag(~age))))
record("Milk", lme(protein ~ Time, data = Milk, random = ~ Time | Cow, method = "ML"))

write.csv(do.call(rbind, rows), "bench/scorecard/recorded/nlme-books.csv", row.names = FALSE, quote = 9:10)
