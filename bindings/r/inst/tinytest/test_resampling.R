# SPDX-License-Identifier: MIT
# The bootstrap and cross-validation, against what the formulas give for straight lines.
source("helpers.R", local = TRUE)
line <- silvafit(dist ~ a + b * speed, data = cars)

# The parametric bootstrap of a straight line has the standard errors of lm with n for n - 2 in sigma^2, to the noise of 400 replicates
# (3.5 %, one standard error).
drawn <- bootstrap(line, 400, seed = 1, progress = FALSE)
errors <- sqrt(diag(vcov(lm(dist ~ speed, cars)))) * sqrt(48 / 50)
expect_true(all(abs(drawn$parameters[c("a", "b"), "se"] / errors - 1) < 0.15))
expect_equal(drawn$parameters["b", "estimate"], unname(fixef(line)["b"]))
expect_equal(drawn$converged, 400)
expect_equal(dim(drawn$values), c(400L, 3L))
expect_equal(drawn$parameters$se, unname(apply(drawn$values, 2, sd)), tolerance = 1e-10)
expect_identical(drawn$values, bootstrap(line, 400, seed = 1, threads = 1, progress = FALSE)$values)
expect_true(length(capture.output(print(drawn))) > 4)
# A fixed coefficient stays fixed.
held <- silvafit(dist ~ a + b * speed, data = cars, hold = c(a = -20))
expect_true(all(bootstrap(held, 5, progress = FALSE)$values[, "a"] == -20))
expect_equal(class_of_error(bootstrap(line, 0)), "silvafit_usage_error")

curve <- height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age)
fit <- silvafit(curve, data = Loblolly, random = Asym ~ 1 | Seed)
left_out <- cross_validate(fit, 0, measured = 2, progress = FALSE)
expect_equal(nrow(left_out), 84L)
expect_equal(rownames(left_out), rownames(Loblolly))
expect_equal(left_out$observed, Loblolly$height)
# Each fold is one group, and its prediction does not use the group.
expect_equal(length(unique(paste(left_out$fold, Loblolly$Seed))), 14L)
without <- suppressMessages(update(fit, data = Loblolly[Loblolly$Seed != "301", ]))
own <- Loblolly$Seed == "301"
expect_equal(left_out$predicted[own], unname(predict(without, Loblolly[own, ], level = "population")), tolerance = 1e-5)
expect_equal(tapply(is.na(left_out$calibrated), Loblolly$Seed, sum)[["301"]], 2L)
error <- left_out$observed - left_out$predicted
expect_equal(attr(left_out, "population")[["mae"]], mean(abs(error)))
expect_true(attr(left_out, "calibrated")[["rmse"]] < attr(left_out, "population")[["rmse"]])
file <- tempfile(fileext = ".json")
fit_json(fit, file)
expect_equal(class_of_error(cross_validate(read_fit(file), 5)), "silvafit_usage_error")
