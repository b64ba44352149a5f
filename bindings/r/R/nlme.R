# SPDX-License-Identifier: MIT
# Generics of nlme. Plots, augmented predictions and correlations of residuals are computed by nlme's own methods.

#' Data, groups and response of a fit
#'
#' Methods for the generics of \pkg{nlme}.
#'
#' @param object,obj a fit of [silvafit()]
#' @param level grouping levels: 1 is the coarsest; the finest by default
#' @param form,data,sep,asList as in the generics; the fit has its own groups and data
#' @param type `"random.effects"`: the covariance matrix of these; `"conditional"`, given them, and `"marginal"`: a list of those of the responses of groups, of the
#'   model linear around the estimates
#' @param individuals labels or numbers of the groups of `"conditional"` and `"marginal"`; with nested groupings of the coarser one
#' @param ... no further arguments; unknown names stop
#' @return `getData()`: the rows of the data that the fit uses, with all columns. `getGroups()`: factor of the groups, or a data frame for
#'   several levels; NULL without random effects. `getResponse()`: the response. `getGroupsFormula()`: such as `~ stand/plot`. `getCovariate()`: the only
#'   predictor, or that of the groupedData. `isBalanced()`: TRUE or FALSE. `getVarCov()`: a matrix or a list of matrices, which are printed as by nlme.
#' @name nlme-data
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' table(nlme::getGroups(fit))
NULL

#' @rdname nlme-data
getData.silvafit <- function(object) {
  needs_data(object, "getData()")
  if (is.null(object$data)) object$frame else object$data[object$rows, , drop = FALSE]
}

#' @rdname nlme-data
getGroups.silvafit <- function(object, form, level = length(grouping_counts(object)), data, sep) {
  if (!missing(form) || !missing(data)) stop_usage("getGroups() of a fit has the groups of the fit; use getGroups(data, form)")
  if (!has_random(object)) return(NULL)
  groups <- group_frame(object)
  if (!all(level %in% seq_along(groups))) stop_usage("`level` has to be a number from 1 to ", length(groups))
  if (length(level) > 1) return(groups[level])
  structure(groups[[level]], label = names(groups)[level])
}

# The groups of each row of the fit.
group_frame <- function(object) {
  needs_data(object, "the groups of rows")
  as.data.frame(group_factors(group_columns(object, object$frame), is_crossed(object)), row.names = row.names(object$frame), optional = TRUE)
}

# A column for each grouping; of crossed terms with several columns their labels with slashes.
group_columns <- function(object, frame) {
  if (!is_crossed(object)) return(frame[names(grouping_counts(object))])
  columns <- lapply(object$fit$random, function(term) do.call(paste, c(unname(as.list(frame[c(unlist(term$within), term$group)])), sep = "/")))
  stats::setNames(columns, names(grouping_counts(object)))
}

# Columns of groups as factors. Those of the finer of two nested groupings have the names coarse/fine, as in nlme.
group_factors <- function(columns, is_crossed = FALSE) {
  columns <- lapply(columns, function(column) factor(column, exclude = NULL))
  if (length(columns) == 2 && !is_crossed) columns[[2]] <- factor(paste(columns[[1]], columns[[2]], sep = "/"))
  columns
}

#' @rdname nlme-data
getGroupsFormula.silvafit <- function(object, asList = FALSE, sep) {
  names <- names(grouping_counts(object))
  if (length(names) == 0) return(NULL)
  one <- function(name) stats::as.formula(paste("~", name), globalenv())
  if (is_crossed(object)) return(if (asList) lapply(names, one) else one(paste(names, collapse = " + ")))
  names <- vapply(names, name_text, "")
  if (asList) lapply(names, one) else one(paste(names, collapse = "/"))
}

#' @rdname nlme-data
getResponse.silvafit <- function(object, form) {
  needs_data(object, "getResponse()")
  of_data <- function(kind) attr(object$data, kind)$y
  label <- paste(c(if (is.null(of_data("labels"))) deparse1(object$formula[[2]]) else of_data("labels"), of_data("units")), collapse = " ")
  # Names of rows would become those of nlme's tables.
  structure(response_values(object), names = if (!isTRUE(object$has_labels)) row.names(object$frame), label = label)
}

#' @rdname nlme-data
getVarCov.silvafit <- strict(function(obj, individuals = 1, type = c("random.effects", "conditional", "marginal"), level = length(grouping_counts(obj)), ...) {
  type <- match.arg(type)
  terms <- random_terms_of(obj)
  if (length(terms) == 0) stop_usage("the fit has no random effects")
  if (type == "random.effects" && missing(level) && length(terms) > 1) stop_usage("give `level`, a number or a name of the groupings ", paste(names(terms), collapse = ", "))
  if (length(level) != 1 || !level %in% c(seq_along(terms), names(terms))) stop_usage("`level` has to be a number from 1 to ", length(terms), " or one of ", paste(names(terms), collapse = ", "))
  if (type == "random.effects") return(structure(terms[[level]]$covariance, class = c(type, "VarCov"), group.levels = if (is.character(level)) level else names(terms)[level]))
  groups <- as.character(group_frame(obj)[[1]])
  if (is.numeric(individuals)) individuals <- unique(groups)[individuals]
  unknown <- setdiff(individuals, groups)
  if (length(unknown) > 0) stop_usage("`individuals`: no row of the fit is of ", names(terms)[1], " ", unknown[1])
  matrices <- lapply(stats::setNames(individuals, individuals), function(one) {
    found <- analysis_of_fit("covariance", obj, list(marginal = type == "marginal"), obj$frame[groups == one, , drop = FALSE])
    do.call(cbind, unname(found$tables$covariance))
  })
  for (one in names(matrices)) dimnames(matrices[[one]]) <- rep(list(seq_len(nrow(matrices[[one]]))), 2)
  structure(matrices, class = c(type, "VarCov"), group.levels = names(terms)[1])
})

#' @rdname nlme-data
#' @param countOnly whether only the numbers of rows of the groups have to agree, not their values of the covariate
isBalanced.silvafit <- function(object, countOnly = FALSE, level = length(grouping_counts(object))) {
  check_flag(countOnly, "countOnly")
  groups <- getGroups.silvafit(object, level = level)
  if (is.null(groups)) stop_usage("the fit has no groups")
  counts <- if (countOnly) table(groups) else table(getCovariate.silvafit(object), groups)
  all(counts == counts[1])
}

#' @rdname nlme-data
getCovariate.silvafit <- function(object, form, data) {
  rows <- if (missing(data)) getData.silvafit(object) else data
  if (!missing(form) || inherits(rows, "groupedData")) return(if (missing(form)) nlme::getCovariate(rows) else nlme::getCovariate(as.data.frame(rows), form))
  rows[[only_predictor(object, "form")]]
}

# The covariate that a fit has, if it is the only one.
only_predictor <- function(object, argument) {
  predictors <- all.vars(stats::delete.response(terms.silvafit(object)))
  if (length(predictors) != 1) stop_usage("`", argument, "` has to name the covariate, such as ~ ", c(predictors, "dbh")[1])
  predictors
}

# The groups that have random effects, where no data are needed. Labels of the finer ones begin with that of the coarser one, a slash in it written as %2F.
groups_of_effects <- function(terms) {
  if (length(terms) == 0) return(NULL)
  # Only the numbers of groups matter, which differ.
  if (attr(terms, "is_crossed")) return(lapply(terms, function(term) factor(rownames(term$modes))))
  labels <- rownames(terms[[length(terms)]]$modes)
  columns <- if (length(terms) == 1) list(labels) else list(gsub("%2F", "/", sub("/.*", "", labels), fixed = TRUE), labels)
  as.data.frame(stats::setNames(lapply(columns, function(one) factor(one, unique(one))), names(terms)), optional = TRUE)
}

# A fit with the elements that methods of nlme read besides generics (?nlme::lmeObject, ?nlme::gnlsObject).
#
# \param with_data  with what needs the data
view_for_nlme <- function(object, with_data = TRUE) {
  terms <- random_terms_of(object)
  object$dims <- list(N = nobs(object), Q = length(terms))
  object$sigma <- sigma(object)
  object$coefficients <- list(fixed = fixef(object), random = lapply(terms, function(term) as.matrix(term$modes)))
  object$modelStruct <- list(reStruct = lapply(terms, function(term) term$covariance / object$sigma^2))
  object$groups <- if (with_data) group_frame(object) else groups_of_effects(terms)
  if (with_data) object$call$data <- getData.silvafit(object)
  # Residuals have the rows of getData(), and labels for the axes of plots.
  object$na.action <- NULL
  object$has_labels <- TRUE
  object
}

# Evaluates a call of a generic by the method of nlme for fits of lme(), or of gls() without random effects.
#
# \param generic  its name
# \param call     match.call() of the method of silvafit
# \param frame    where its arguments are evaluated
# \param also     further names that its `...` accepts
# \param fits     arguments that are fits
by_nlme <- function(generic, call, frame, also = character(), fits = names(call)[2]) {
  objects <- lapply(fits, function(argument) eval(call[[argument]], frame))
  for (i in seq_along(fits)) if (!inherits(objects[[i]], "silvafit")) stop_usage("`", fits[i], "` has to be a fit of silvafit()")
  method <- utils::getS3method(generic, if (has_random(objects[[1]])) "lme" else "gls", optional = TRUE, envir = asNamespace("nlme"))
  if (is.null(method)) stop_usage("the fit has no random effects, which ", generic, "() shows")
  # Names may be shortened, as in ranef(fit, aug = TRUE).
  own <- setdiff(names(formals(method)), c(fits, "..."))
  whole <- own[pmatch(names(call), own)]
  names(call)[!is.na(whole)] <- whole[!is.na(whole)]
  unknown <- setdiff(names(call)[-1], c(own, also, fits, ""))
  if (length(unknown) > 0) stop_unknown(unknown[1], c(own, also), shown = if (length(also) > 20) own else c(also, own))
  if ("primary" %in% own && is.null(call$primary) && !inherits(getData.silvafit(objects[[1]]), "groupedData")) {
    call$primary <- stats::reformulate(only_predictor(objects[[1]], "primary"))
  }
  # Tables of effects need no data unless they have its columns.
  with_data <- !generic %in% c("ranef", "coef") || isTRUE(eval(call$augFrame, frame))
  where <- new.env(parent = frame)
  for (i in seq_along(fits)) {
    if (with_data) needs_data(objects[[i]], paste0(generic, "()"))
    # Results and plots have the names of the fits.
    name <- if (is.language(call[[fits[i]]])) deparse1(call[[fits[i]]]) else fits[i]
    assign(name, view_for_nlme(objects[[i]], with_data), where)
    call[[fits[i]]] <- as.name(name)
  }
  call[[1]] <- method
  eval(call, where)
}

# A method with the arguments of its generic.
method_by_nlme <- function(generic, formals, ...) {
  method <- function() NULL
  formals(method) <- formals
  body(method) <- bquote(by_nlme(.(generic), match.call(), parent.frame(), ..(list(...))), splice = TRUE)
  environment(method) <- parent.frame()
  method
}

#' Predictions and residuals by nlme
#'
#' Methods for the generics of \pkg{nlme} and for `pairs()`, with the arguments of the methods there: [nlme::augPred.lme()] (predictions of
#' each group over a covariate), [nlme::comparePred()], [nlme::ACF.lme()] (correlation of the residuals within groups), [nlme::Variogram.lme()] and [nlme::pairs.lme()].
#'
#' @param object,object1,object2,x fits of [silvafit()]
#' @param primary covariate of the predictions, such as `~ age`; by default that of the groupedData, or the only one of the fit
#' @param minimum,maximum,length.out range and number of its values
#' @param level grouping levels of the predictions
#' @param maxLag largest lag
#' @param distance,... as in nlme; unknown names stop
#' @return Objects of nlme, which `plot()` shows; `pairs()` a plot of lattice.
#' @name nlme-methods
#' @examples
#' fit <- silvafit(height ~ Asym + (R0 - Asym) * exp(-exp(lrc) * age), data = Loblolly,
#'                 random = Asym ~ 1 | Seed)
#' nlme::ACF(fit)
#' plot(nlme::augPred(fit, level = 0:1))
NULL

#' @rdname nlme-methods
ACF.silvafit <- method_by_nlme("ACF", alist(object = , maxLag = , ... = ))

#' @rdname nlme-methods
Variogram.silvafit <- method_by_nlme("Variogram", alist(object = , distance = , ... = ))

#' @rdname nlme-methods
augPred.silvafit <- method_by_nlme("augPred", formals(nlme::augPred))

#' @rdname nlme-methods
comparePred.silvafit <- method_by_nlme("comparePred", formals(nlme::comparePred), fits = c("object1", "object2"))

#' @rdname nlme-methods
pairs.silvafit <- method_by_nlme("pairs", alist(x = , ... = ), also = quote(lattice_names()))

# Names that plots of lattice accept.
lattice_names <- function() c(names(graphics::par(no.readonly = TRUE)), names(formals(utils::getS3method("xyplot", "formula", envir = asNamespace("lattice")))))
