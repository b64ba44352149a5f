# SPDX-License-Identifier: MIT

#' silvafit: models of forest inventories with random effects
#'
#' [silvafit()] fits nonlinear mixed-effects models without start values and says whether the fit has converged; [predict.silvafit()] calibrates
#' predictions for new plots by a few measured trees. [structural_units()], [stand_summary()], [stand_growth()], [impute()], [fit_study()], [read_library()],
#' [grow_trees()] and [view_stand()] analyze inventories. `vignette("from-nlme", package = "silvafit")` is for users of nlme.
#'
#' @name silvafit-package
#' @useDynLib silvafit, .registration = TRUE
#' @keywords internal
NULL
