# SPDX-License-Identifier: MIT
# Predictions.

#' Predictions of a fit
#'
#' @param object a fit of [silvafit()]
#' @param newdata data frame; without it the data of the fit
#' @param re.form as in lme4, instead of `level`: `NULL` is `"conditional"`, `NA` or `~ 0` is `"population"`
#' @param level `"population"`: random effects 0, a typical group. `"conditional"`: with the random effects of the
#'   groups of the fit. `"calibrated"`: with the random effects that the rows with a measured response in `newdata`
#'   imply for their group. `"marginal"`: mean over all groups. The numbers of nlme are accepted: 0 is the population.
#' @param interval `"none"`, `"prediction"` (for the value of a new observation) or `"confidence"` (for the mean of such observations)
#' @param coverage coverage of the intervals
#' @param se.fit add standard errors: of the mean, as [predict()] of other models has them, or with `interval = "prediction"` of a new observation
#' @param new_groups prediction for groups that were not in the fit (level `"conditional"`), or without a measured
#'   row (`"calibrated"`): `"population"`, `"marginal"`, `"missing"` (NA) or `"error"`. Without this argument it is
#'   `"population"`, and a message names the groups that are not in the fit
#' @param seen_groups for calibrated predictions, the effects of groups that were in the fit: `"fitted"`, those of the fit; `"new"`,
#'   from the rows of `newdata` alone; `"combined"`, from both
#' @param na.action for rows with missing values: `na.pass` and `na.exclude` give NA, `na.omit` omits the rows, `na.fail` stops
#' @param threads number of threads; 0 means all cores
#' @param ... `allow.new.levels` of lme4: TRUE is `new_groups = "population"`, FALSE `"error"`; other names stop
#' @return A vector; with `interval` or `se.fit` a data frame with the columns `fit`, `lwr`, `upr` and `se.fit`. Calibrated predictions have the
#'   attribute `measured`, the number of rows that calibrated the group of each row.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' # A new tree that was measured at age 10
#' new <- data.frame(Seed = "new", age = c(5, 10, 15, 20), height = c(NA, 30, NA, NA))
#' predict(fit, new, level = "calibrated", interval = "prediction")
predict.silvafit <- function(object, newdata, level = "conditional", interval = c("none", "prediction", "confidence"),
                             coverage = 0.95, se.fit = FALSE, new_groups = c("population", "marginal", "missing", "error"),
                             seen_groups = c("fitted", "new", "combined"), na.action = stats::na.pass, threads = 1, re.form, ...) {
  if (!missing(coverage) && (missing(interval) || identical(interval, "none"))) stop_usage("`coverage` is that of intervals; give `interval`, too")
  no_further(list(...), "allow.new.levels", instead = c(conf.level = "use coverage", type = "predictions are those of the response", asList = "use split()"))
  if (!missing(re.form)) {
    if (!missing(level)) stop_usage("give either `level` or `re.form`")
    level <- level_of_re_form(re.form)
  }
  if (!is.null(list(...)$allow.new.levels)) {
    if (!missing(new_groups)) stop_usage("give either `new_groups` or `allow.new.levels`")
    check_flag(list(...)$allow.new.levels, "allow.new.levels")
    new_groups <- if (list(...)$allow.new.levels) "population" else "error"
  }
  says_new <- missing(new_groups)
  is_plain <- says_new && missing(seen_groups)
  interval <- match.arg(interval)
  check_flag(se.fit, "se.fit")
  action <- name_of_action(na.action, c("na.pass", "na.exclude", "na.omit", "na.fail"))
  new_groups <- match.arg(new_groups)
  seen_groups <- match.arg(seen_groups)
  is_own <- missing(newdata) || is.null(newdata)
  if (length(level) > 1 && is.numeric(level)) {
    if (interval != "none" || se.fit) stop_usage("intervals and standard errors are available for one `level` at a time")
    levels <- predict_levels(object, newdata, level, says_new, new_groups = new_groups)
    return(if (is_own) with_excluded_rows(object, levels) else levels)
  }
  level <- level_word(object, level)
  if (is_own) {
    if (interval == "none" && !se.fit && is_plain && level %in% c("population", "conditional")) return(fitted(object, level))
    needs_data(object, "a prediction without `newdata`")
    newdata <- object$frame
  }
  newdata <- prediction_data(object, newdata, level)
  if (interval == "prediction") require_variance_columns(object, newdata)
  absent <- setdiff(grouping_names(object), names(newdata))
  if (level == "conditional" && length(absent) > 0) {
    stop_input("unknown column '", absent[1], "' in `newdata`; without the groups use level = \"population\"", column = absent[1])
  }
  is_outer <- level == "outer"
  if (is_outer) {
    # All inner groups are new.
    is_new <- !as.character(newdata[[grouping_names(object)[1]]]) %in% rownames(random_terms_of(object)[[1]]$modes)
    if (any(is_new) && new_groups == "error") stop_input(sentence_on_groups(object, newdata, is_new))
    rows_of_no_group <- which(is_new & new_groups == "missing")
    if (new_groups %in% c("error", "missing")) new_groups <- "population"
    if (says_new && any(is_new)) tell(paste0(sentence_on_groups(object, newdata, is_new), ": their predictions have random effects 0; `new_groups` has other choices"))
    newdata <- without_inner_groups(object, newdata)
    level <- "conditional"
  }
  settings <- list(level = level, new_groups = if (!says_new || is_outer) new_groups, seen_groups = seen_groups,
                   coverage = if (interval != "none") coverage, interval = if (interval == "prediction") "prediction" else if (interval != "none" || se.fit) "confidence",
                   standard_errors = se.fit, threads = threads)
  result <- analysis_of_fit("predict", object, settings, newdata)
  if (is_outer) for (name in intersect(c("value", "lower", "upper", "standard_error"), names(result$tables$rows))) result$tables$rows[[name]][rows_of_no_group] <- NA
  output <- predicted(result$tables$rows, row.names(newdata), interval, se.fit, level, action)
  if (is_own) with_excluded_rows(object, output) else output
}

# With na.exclude, rows that the fit does not use have missing values.
with_excluded_rows <- function(object, output) {
  if (!is.data.frame(output)) return(stats::napredict(object$na.action, output))
  excluded <- object$na.action
  if (!inherits(excluded, "exclude")) return(output)
  names <- character(nrow(output) + length(excluded))
  names[-excluded] <- row.names(output)
  names[excluded] <- names(excluded)
  at <- rep(NA_integer_, length(names))
  at[-excluded] <- seq_len(nrow(output))
  output <- output[at, , drop = FALSE]
  row.names(output) <- names
  output
}

# \param is_new  rows of groups of the coarser grouping that are not in the fit
sentence_on_groups <- function(object, newdata, is_new) {
  name <- grouping_names(object)[1]
  labels <- unique(as.character(newdata[[name]][is_new]))
  paste0(if (sum(is_new) == 1) "1 row is" else paste(sum(is_new), "rows are"), " of groups that are not in the fit (", name, " ",
         paste(c(utils::head(labels, 5), if (length(labels) > 5) "..."), collapse = ", "), ")")
}

# Columns of the variance function and its strata.
variance_columns <- function(fit) unlist(lapply(c(list(fit$variance), fit$variance$factors), function(one) c(if (!identical(one$of, "fitted")) one$of, one$strata)))

require_variance_columns <- function(object, newdata) {
  absent <- setdiff(variance_columns(object$fit), names(newdata))
  if (length(absent) > 0) stop_input("unknown column '", absent[1], "' in `newdata`, which the variance of a new observation needs", column = absent[1])
}

# lme4's argument as a level.
level_of_re_form <- function(re.form) {
  if (is.null(re.form)) return("conditional")
  is_none <- length(re.form) == 1 && is.atomic(re.form) && is.na(re.form)
  if (is_none || (inherits(re.form, "formula") && identical(re.form[[2]], 0))) return("population")
  stop_usage("`re.form` has to be NULL, NA or ~ 0; for the coarser of two groupings use level = 1")
}

# The label of no group.
new_group_label <- "\u0001"

predicted <- function(result, names, interval, se.fit, level, action) {
  value <- result$value
  if (action == "na.fail" && anyNA(value)) stop_input("row ", names[is.na(value)][1], " has no prediction because of missing values or a new level")
  if (interval == "none" && !se.fit) {
    output <- stats::setNames(value, names)
  } else {
    output <- data.frame(fit = value, row.names = names)
    if (interval != "none") {
      output$lwr <- result$lower
      output$upr <- result$upper
    }
    if (se.fit) output$se.fit <- result$standard_error
  }
  measured <- result$calibrated_from
  if (action == "na.omit") {
    keep <- !is.na(value)
    output <- if (is.data.frame(output)) output[keep, , drop = FALSE] else output[keep]
    measured <- measured[keep]
  }
  if (level == "calibrated" && length(measured) > 0) attr(output, "measured") <- ifelse(measured < 0, NA_integer_, as.integer(measured))
  output
}

# Several levels of nlme beside each other.
predict_levels <- function(object, newdata, levels, says_new, ...) {
  data <- if (missing(newdata) || is.null(newdata)) object$frame else newdata
  groups <- names(grouping_counts(object))
  at <- function(level) if (says_new) stats::predict(object, data, level = level) else stats::predict(object, data, level = level, ...)
  columns <- lapply(levels, function(level) as.vector(at(level)))
  names(columns) <- ifelse(levels == 0, "predict.fixed", paste0("predict.", groups[pmax(levels, 1)]))
  of_rows <- if (is_crossed(object)) group_columns(object, data) else as.list(data)[intersect(groups, names(data))]
  data.frame(group_factors(of_rows, is_crossed(object)), columns, check.names = FALSE, row.names = row.names(data))
}

# The columns that the model reads. A missing response is no error unless calibration needs it.
prediction_data <- function(object, newdata, level) {
  newdata <- check_data(in_units_of_fit(newdata, object), "newdata")
  left <- if (is.null(object$formula)) NULL else with_left_side(object$formula, newdata)[[2]]
  response <- deparse1(left)
  if (!is.null(left) && !is.name(left) && !response %in% names(newdata) && all(all.vars(left) %in% names(newdata))) {
    newdata[[response]] <- eval(left, newdata, environment(object$formula))
  }
  wanted <- if (is.null(object$frame)) names(newdata) else names(object$frame)
  newdata <- newdata[intersect(wanted, names(newdata))]
  if (length(newdata) == 0) stop_input("`newdata` has none of the columns of the model: ", paste(wanted, collapse = ", "))
  for (name in names(newdata)) {
    # A column of missing values only is logical.
    if (is.logical(newdata[[name]]) && all(is.na(newdata[[name]])) && is_text(object$frame[[name]])) newdata[[name]] <- as.character(newdata[[name]])
    if (is.logical(newdata[[name]]) && all(is.na(newdata[[name]]))) newdata[[name]] <- as.numeric(newdata[[name]])
  }
  newdata
}

# Numbers in the units of the data of the fit.
in_units_of_fit <- function(newdata, object, argument = "newdata") {
  given <- units_of(newdata)
  wanted <- object$units[intersect(names(object$units), intersect(names(newdata), names(object$frame)))]
  unknown <- setdiff(intersect(names(given), if (is.null(object$frame)) names(given) else names(object$frame)), names(wanted))
  if (length(unknown) > 0) {
    stop_input("`", argument, "`: column '", unknown[1], "' has the unit ", given[[unknown[1]]], ", but the data of the fit have no unit; use units::drop_units()", column = unknown[1])
  }
  for (name in intersect(names(wanted), names(given))) newdata[[name]] <- in_unit(newdata[[name]], wanted[[name]], paste0("`", argument, "`: column '", name, "'"))
  # The data of the fit are plain numbers.
  bare <- setdiff(names(wanted), names(given))
  if (length(bare) > 0 && !identical(newdata, object$frame)) tell(paste0("`", argument, "`: ", paste(bare, "in", wanted[bare], collapse = ", "), ", as in the data of the fit"))
  newdata
}

is_text <- function(column) is.character(column) || is.factor(column)

# With labels that no group of the fit has, only the effects of the coarser grouping are used.
without_inner_groups <- function(object, newdata) {
  inner <- names(grouping_counts(object))[2]
  if (inner %in% names(newdata)) newdata[[inner]] <- new_group_label
  newdata
}

# By R's generator.
drawn_seed <- function() sample.int(.Machine$integer.max, 1)

#' Draw responses from a fit
#'
#' Draws new random effects for each group and new residuals, on the rows of the fit.
#'
#' @param object a fit of [silvafit()]
#' @param nsim number of replicates
#' @param seed seed of the random numbers; without it, it is drawn by R, so that [set.seed()] has effect
#' @param ... `re.form = NA` and `use.u = FALSE` of lme4, which mean new random effects; other values and names stop
#' @return Data frame with a column `sim_1`, `sim_2`, ... for each replicate, and the attribute `seed`.
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' simulated <- simulate(fit, nsim = 3, seed = 1)
#' head(simulated)
simulate.silvafit <- function(object, nsim = 1, seed = NULL, ...) {
  no_further(list(...), c("re.form", "use.u"), c(newdata = "simulate() draws on the rows of the fit"))
  keeps_effects <- isTRUE(list(...)$use.u) || ("re.form" %in% names(list(...)) && level_of_re_form(list(...)$re.form) == "conditional")
  if (keeps_effects) stop_usage("simulate() draws new random effects for all groups")
  needs_data(object, "simulate()")
  check_count(nsim, "nsim", 1)
  if (is.null(seed)) seed <- drawn_seed()
  check_count(seed, "seed")
  result <- analysis_of_fit("simulate", object, list(count = nsim, seed = seed))
  frame <- as.data.frame(matrix(NA_real_, nrow(object$frame), nsim), row.names = row.names(object$frame))
  frame[result$rows, ] <- result$tables$rows
  names(frame) <- paste0("sim_", seq_len(nsim))
  attr(frame, "seed") <- seed
  frame
}
