# SPDX-License-Identifier: MIT
# Inventories: structural units, stand tables, imputation, studies, libraries, trees in three dimensions.

#' Arguments of inventories
#'
#' @param trees data frame with a row for each tree, points of class `sf`, or the path of a CSV file. Columns with usual names are recognized:
#'   `plot`, `tree`, `species`, `x`, `y` \[m\], `dbh` \[cm\], `h`, `hcb`, `cw` \[m\].
#' @param window the area in which all trees were measured: polygons of class `sf` or `sfc` (the column `plot`, if there is one, names the
#'   plot), or the path of a GeoJSON, WKT or CSV file
#' @param circle center and radius of every plot in its own coordinates \[m\], instead of a window: `c(0, 0, 12.62)`
#' @eval setting_params(c("reading", "units", "stand", "study", "grow"))
#' @param threads number of threads; 0 means all cores
#' @param progress show the progress in the console
#' @param seed seed of the random numbers
#' @param ... further settings of the lists of [settings] that the function has
#' @name inventory-arguments
#' @keywords internal
NULL

data_folder <- function() {
  folder <- Sys.getenv("SILVAFIT_DATA_DIR", system.file("silvafit", package = "silvafit"))
  if (folder == "") stop_input("the catalogue of models is missing; reinstall the package")
  folder
}

# Names that CRAN's example data sets, forest offices and others give to these columns are for C++ to know.
tree_source <- function(trees) {
  if (is.character(trees) && length(trees) == 1) {
    if (!file.exists(trees)) stop_input(trees, ": there is no such file")
    return(trees)
  }
  plain_columns(check_data(in_units_of_trees(trees), "trees"))
}

# The settings of lists: name, help and words that are allowed.
setting_list <- function(...) engine(.Call(C_setting_list, c(...)))

# For the help pages. An argument that several lists have is described by the first.
setting_params <- function(lists, names = NULL) {
  settings <- setting_list(lists)
  shown <- !duplicated(settings$name) & !settings$name %in% c("window", "circle", "scene") & (is.null(names) | settings$name %in% names)
  paste("@param", settings$name[shown], escaped_help(settings$help[shown]))
}

escaped_help <- function(texts) gsub("%", "\\%", gsub("`", "", texts, fixed = TRUE), fixed = TRUE)

#' Settings of inventories and trees
#'
#' The arguments of [structural_units()], [stand_summary()], [stand_growth()], [impute()], [fit_study()], [grow_trees()], [view_stand()] and
#' [predict.silvafit_library()] that are settings, with those that these functions take in `...`.
#'
#' @eval setting_sections()
#' @name settings
NULL

setting_sections <- function() {
  headings <- c(reading = "Table of trees, of all functions", rows = "Rows of the table of trees, of studies", units = "Structural units, of inventories and studies",
                sampling = "Sampled plots, of inventories and studies", stand = "Stand figures", equations = "Volume, biomass and carbon", study = "Models of a study",
                imputation = "Imputation", predictions = "Predictions of libraries", grow = "Trees and scenes", view = "3D page")
  vapply(names(headings), function(list) {
    settings <- setting_list(list)
    paste0("@section ", headings[[list]], ":\n", paste0("- `", settings$argument, "`: ", escaped_help(settings$help), collapse = "\n"))
  }, "")
}

# An analysis by the settings of a call: the arguments of the caller, and those in its dots.
#
# \param lists  settings that the analysis has
# \param own    values of arguments that are given in another form, by name
# \param given  names of the arguments that count, if those with default values do not
analysis_of_call <- function(name, table, lists, own = list(), instead = character(), library = NULL, given = NULL) {
  frame <- parent.frame()
  formal <- formals(sys.function(sys.parent()))
  further <- eval(quote(list(...)), frame)
  known <- setting_list(lists)$name
  # The scene of grow_trees() is its argument `file`.
  no_further(further, setdiff(known, "scene"), instead, formal)
  settings <- c(mget(intersect(names(formal), c(known, "threads", "seed")), frame), further)
  settings[names(own)] <- own
  if (!is.null(given)) settings <- settings[intersect(names(settings), c(given, names(own), "threads"))]
  settings <- settings_without_units(settings, lists)
  if (!is.null(settings$circle)) {
    if (!is.numeric(settings$circle) || length(settings$circle) != 3) stop_usage("`circle` has to be c(x, y, radius)")
    settings$circle <- paste(vapply(settings$circle, number_text, ""), collapse = ",")
  }
  plots <- if ("sampling" %in% lists && is.data.frame(settings$plots)) tree_source(settings$plots)
  if (!is.null(plots)) settings$plots <- NULL
  settings <- c(settings[names(settings) != "window"], window_arguments(settings$window, table))
  result <- analysis(name, tree_source(table), settings, library, plots, frame$progress, data_folder())
  tell_notes(result$notes)
  result
}

# Numbers of class `units` in the unit that the help of their setting names.
settings_without_units <- function(settings, lists) {
  has_unit <- function(value) inherits(value, "units") || (is.list(value) && !is.data.frame(value) && any(vapply(value, inherits, NA, "units")))
  known <- setting_list(lists)
  for (name in names(Filter(has_unit, settings))) {
    unit <- unique(unlist(regmatches(known$help[known$name == name], gregexpr("(?<=\\bin )(m2/ha|m2|cm|ha|m)\\b", known$help[known$name == name], perl = TRUE))))
    if (length(unit) != 1 || is.list(settings[[name]])) stop_usage("`", name, "` has a unit; give numbers without one, see ?settings")
    settings[[name]] <- in_unit(settings[[name]], unit, paste0("`", name, "`"))
  }
  settings
}

# A path, or polygons of sf as texts with the labels of their plots, in meters.
window_arguments <- function(window, trees) {
  if (is.null(window)) return(list())
  if (is.character(window)) {
    if (!file.exists(window)) stop_input(window, ": there is no such file")
    return(list(window = window))
  }
  if (!inherits(window, c("sf", "sfc", "sfg"))) stop_usage("`window` has to be a path or polygons of class sf or sfc")
  if (!requireNamespace("sf", quietly = TRUE)) stop_usage("windows of class sf need the package sf")
  geometry <- if (inherits(window, "sfg")) sf::st_sfc(window) else sf::st_geometry(window)
  if (inherits(trees, "sf") && !isTRUE(sf::st_crs(trees) == sf::st_crs(geometry))) {
    stop_usage("`trees` and `window` have different coordinate reference systems; use sf::st_transform(window, sf::st_crs(trees))")
  }
  meters <- meters_of(geometry, "`window`")
  if (meters != 1 && !inherits(trees, "sf")) stop_usage("the coordinates of `window` are not in meters, those of trees without a coordinate reference system are; use sf::st_transform()")
  if (meters != 1) geometry <- geometry * meters
  plots <- if (inherits(window, "sf") && "plot" %in% names(window)) lapply(as.character(window$plot), function(plot) if (!is.na(plot)) plot)
  list(windows = Filter(Negate(is.null), list(wkt = as.list(sf::st_as_text(sf::st_zm(geometry), digits = 17)), plot = plots)))
}

# A table with further columns. Those that the table has with other values are not replaced.
with_columns <- function(table, columns, argument) {
  for (name in names(columns)) {
    if (name %in% names(table) && !has_values(table[[name]], columns[[name]])) {
      stop_usage("`", argument, "` has a column '", name, "' with other values, which a result would replace; rename or remove it")
    }
    table[[name]] <- columns[[name]]
  }
  table
}

has_values <- function(column, values) {
  if (is.numeric(column) && is.numeric(values)) return(isTRUE(all.equal(as.numeric(column), as.numeric(values))))
  identical(as.character(column), as.character(values))
}

#' Structural indices of each tree
#'
#' Computes the structural unit of each tree, the tree and its nearest neighbors, and its indices: uniform angle index W, mingling M, dominance
#' U, crowding C, and further ones.
#'
#' @inheritParams inventory-arguments
#' @param ... further [settings] of the table, structural units and sampled plots: `plots` is a data frame or file, `circles` as in `c("7" = 4, "30" = 12)`
#' @return `trees` with the columns `core` (1 if all nearest neighbors are known) and the indices; NA for rows that cannot be used. A column of
#'   `trees` with one of these names and other values is an error. If
#'   `trees` is a path, the columns of the inventory as it was read. The attribute `summary` has the means.
#' @examples
#' trees <- data.frame(x = c(1, 3, 6, 4, 8, 9, 2, 7), y = c(1, 7, 2, 5, 9, 4, 9, 7),
#'                     dbh = c(20, 15, 30, 22, 18, 25, 28, 14),
#'                     species = c("A", "B", "A", "A", "B", "B", "A", "B"))
#' units <- structural_units(trees, edge = "none")
#' units
structural_units <- function(trees, window = NULL, edge = "buffer", buffer = 5, per = "plot", neighbors = 4, columns = NULL, circle = NULL,
                             dead = "leave-out", trust_units = FALSE, threads = 0, progress = interactive(), ...) {
  result <- analysis_of_call("structural_units", trees, c("reading", "units", "sampling"))
  table <- as.data.frame(result$tables$units, check.names = FALSE)
  if (!is.character(trees)) {
    new <- names(table)[seq(match("core", names(table)), ncol(table))]
    table <- with_columns(trees, lapply(table[new], function(values) {
      column <- rep(NA_real_, nrow(trees))
      column[result$rows] <- values
      column
    }), "trees")
  }
  attr(table, "summary") <- result$json
  own_copy(table)
}

# A data.table whose columns were set by other means than its own needs a copy before `:=`.
own_copy <- function(table) if (inherits(table, "data.table")) data.table::copy(table) else table

#' Stand tables of an inventory
#'
#' @inheritParams inventory-arguments
#' @param ... further [settings] of the table, structural units, sampled plots, stand figures and equations, such as `equations = c("jenkins-pine", B = "taper")`
#' @return List of class `silvafit_stand` with data frames: `plots`, `strata`, `species`, `diameters` and, with positions, `classes`.
#' @examples
#' trees <- data.frame(plot = rep(1:2, each = 4), species = c("A", "A", "B", "A"),
#'                     dbh = c(20, 31, 14, 25, 22, 18, 40, 33),
#'                     h = c(18, 24, 12, 20, 19, 16, 27, 25))
#' stand_summary(trees, plot_area = 400)
stand_summary <- function(trees, window = NULL, plot_area = NULL, edge = "buffer", buffer = 5, per = "plot", neighbors = 4, columns = NULL,
                          circle = NULL, class_width = 4, dominant_trees = 100, stratum = "", stratum_areas = NULL, dead = "leave-out",
                          trust_units = FALSE, threads = 0, progress = interactive(), ...) {
  stand_tables(analysis_of_call("stand_summary", trees, c("reading", "units", "sampling", "stand", "equations")))
}

stand_tables <- function(result) {
  structure(lapply(result$tables, as.data.frame, check.names = FALSE), json = result$json, class = "silvafit_stand")
}

#' Growth between repeated measurements
#'
#' Increments of trees, ingrowth, mortality and cut between two measurements of a plot, by tree, plot and stratum. The column `year` or `date`
#' has the time of each row; a column of the status says which trees are dead or cut at the end of a period.
#'
#' @inheritParams inventory-arguments
#' @inheritParams stand_summary
#' @return List of class `silvafit_stand` with data frames: `growth_trees`, `growth_plots` and `growth_strata`.
#' @examples
#' trees <- data.frame(plot = 1, tree = c(1, 2, 1, 2, 3), year = c(2010, 2010, 2020, 2020, 2020),
#'                     dbh = c(20, 31, 24, 33, 8))
#' stand_growth(trees, plot_area = 400)$growth_trees
stand_growth <- function(trees, window = NULL, plot_area = NULL, columns = NULL, circle = NULL, stratum = "", stratum_areas = NULL,
                         trust_units = FALSE, threads = 0, progress = interactive(), ...) {
  stand_tables(analysis_of_call("stand_growth", trees, c("reading", "units", "sampling", "stand", "equations")))
}

print.silvafit_stand <- strict(function(x, digits = 3, ...) {
  for (name in setdiff(names(x), "classes")) {
    if (nrow(x[[name]]) == 0) next
    cat(toupper(substr(name, 1, 1)), substring(name, 2), "\n", sep = "")
    shown <- x[[name]]
    # Importance values by layer and relative values stay in the table.
    is_empty <- vapply(shown, function(column) all(is.na(column)), logical(1)) | grepl("^(lower|middle|upper|relative)_|_plot_mean$", names(shown))
    print(shown[!is_empty], digits = digits, row.names = FALSE)
    cat("\n")
  }
  invisible(x)
})

#' Impute values that were measured on some trees only
#'
#' Fits a model with random effects of the plots to the measured trees, and predicts the others with the effects of their plot.
#'
#' @inheritParams inventory-arguments
#' @eval setting_params("imputation")
#' @param seed seed of `add_residual`; without it, it is drawn by R, so that [set.seed()] has effect
#' @param ... further [settings] of the table
#' @return `trees` with the response filled in, under its name in `trees`, and the columns `RESPONSE_source` (measured, imputed, missing), `RESPONSE_level`
#'   (plot, stand, population) and `RESPONSE_flag`, and with `coverage` the limits `RESPONSE_lower` and `RESPONSE_upper`. The attribute `models` is a list of the fits, objects of class `silvafit` without data (see [read_fit()]).
#' @examples
#' trees <- as.data.frame(Loblolly)
#' names(trees) <- c("h", "dbh", "plot")
#' trees$h[seq(1, 84, 3)] <- NA
#' filled <- impute(trees, "h", formula = h ~ 1.3 + a * (1 - exp(-b * dbh)), trust_units = TRUE)
#' head(filled)
impute <- function(trees, response = "h", group = "", by = "", minimum_trees = 30, formula = NULL, models = NULL, random = "", variance = NULL, method = "",
                   add_residual = FALSE, coverage = NULL, seed = NULL, columns = NULL, dead = NULL, trust_units = FALSE, threads = 0, progress = interactive(), ...) {
  if (inherits(formula, "formula")) formula <- with_pi(paste(expression_text(formula[[2]]), "~", expression_text(formula[[3]])), names(trees))
  if (is.null(seed)) seed <- if (isTRUE(add_residual)) drawn_seed() else 1
  result <- analysis_of_call("impute", trees, c("reading", "imputation"), list(formula = formula, variance = variance_text(variance)))
  tell_notes(result$json$sentences)
  if (isTRUE(add_residual)) tell(paste0("imputed values have drawn residuals (seed = ", seed, ")"))
  if (is.character(trees)) {
    filled <- rows_of_file(result)
  } else {
    filled <- trees
    columns <- result$tables$columns
    for (name in names(columns)) {
      if (length(columns[[name]]) != nrow(filled)) stop_input("the imputed rows are not those of `trees`")
      # Limits have the unit of their column.
      measured <- sub("_(lower|upper)$", "", name)
      filled[[name]] <- with_unit_of(columns[[name]], filled[[measured]], tree_units[tolower(measured)])
    }
  }
  attr(filled, "models") <- lapply(result$fits, stored_fit, call = match.call())
  own_copy(filled)
}

# Values in the unit of a column that had them in part.
with_unit_of <- function(values, column, unit) {
  if (!inherits(column, "units")) return(values)
  units::set_units(units::set_units(values, unit, mode = "standard"), units::deparse_unit(column), mode = "standard")
}

#' Run a whole study
#'
#' From an inventory to structural indices, models at three levels (least squares, covariates, random effects), a model library, predictions and a
#' report, which are written to a folder.
#'
#' @inheritParams inventory-arguments
#' @param out folder for the results
#' @param config path of a study.json (`silvafit study --init`); arguments of the call have priority over it
#' @param ... further [settings] of the models, the table, structural units and sampled plots, such as `candidates = list(h = c("M4", "h ~ 1.3 + a*dbh^b"))`
#' @return List of class `silvafit_study`: `results`, a data frame with a row for each species and response; `predictions`, the inventory with those of the
#'   chosen models; `notes`; the paths `out` and `report`.
#'   `read_library(study)` has its models.
#' @examples
#' \donttest{
#' set.seed(1)
#' plots <- rep(1:12, each = 25)
#' trees <- data.frame(plot = plots, species = "A", dbh = round(runif(300, 8, 45), 1))
#' a <- 24 + rnorm(12)[plots]
#' trees$h <- round(1.3 + a * (1 - exp(-0.06 * trees$dbh)) + rnorm(300), 1)
#' study <- fit_study(trees, tempfile("study"), responses = "h", progress = FALSE)
#' study
#' }
fit_study <- function(trees, out, species = NULL, responses = c("h", "hcb", "cw"), covariates = c("W", "M", "C", "U"), group = "plot", period = NULL,
                      minimum_trees = 100, window = NULL, edge = "buffer", buffer = 5, per = "plot", neighbors = 4, columns = NULL, circle = NULL, dead = "leave-out",
                      trust_units = FALSE, config = NULL, threads = 0, progress = interactive(), ...) {
  if (missing(out)) stop_usage("`out` is missing: the folder for the results")
  own <- list(config = config, out = path.expand(out), call = "silvafit::fit_study()")
  result <- analysis_of_call("study", trees, c("reading", "rows", "units", "sampling", "study"), own, given = if (!is.null(config)) names(match.call()))
  summary <- result$json
  structure(list(results = study_results(summary$results), predictions = as.data.frame(result$tables$predictions, check.names = FALSE), out = summary$out,
                 report = summary$report, fits = summary$fits, notes = result$notes), class = "silvafit_study")
}

study_results <- function(results) {
  joined <- lapply(results, function(one) {
    one$doubts <- paste(unlist(one$doubts), collapse = " ")
    lapply(c(one, message = one$verdict), function(value) if (length(value) > 1) paste(value, collapse = "; ") else value)
  })
  records(joined, c("species", "response", "n", "model", "formula", "covariates", "random", "variance", "r2_ols", "r2_nlme", "converged", "sound", "doubts", "message"))
}

print.silvafit_study <- strict(function(x, ...) {
  cat("Study: ", sum(x$results$sound), " of ", NROW(x$results), " final models are sound\n\n", sep = "")
  print(x$results[c("species", "response", "n", "model", "covariates", "random", "variance", "r2_ols", "r2_nlme", "sound")], digits = 3, row.names = FALSE)
  cat("\nReport:", x$report, "\n")
  invisible(x)
})

#' Model libraries
#'
#' A library has the models of a study, or published ones such as `"shanxia-2023"`. `predict()` adds predictions of all responses to a table of trees.
#'
#' @param file path of a library.json, of a fit in JSON, the name of a published library, or a study of [fit_study()]
#' @param object,x a library
#' @param newdata data frame or path of a CSV file
#' @param level,interval,coverage,se.fit,new_groups,seen_groups,threads as in [predict.silvafit()]
#' @param role,equations,equation_files see [settings]; predicted heights are used where none is measured
#' @param columns,trust_units,progress as in [structural_units()]
#' @param ... further [settings] of the table; `print()` has none
#' @return `read_library()`: list of class `silvafit_library` with the data frame `models` and, for each of its rows, an object of class
#'   `silvafit` in the list `fits`, such as `fits[["SM h nlme"]]`; these have no data (see [read_fit()]). `predict()`: `newdata` with columns such as `h_pred`, `h_lower`,
#'   `h_upper`, `h_se`, `h_trees`, those of equations such as `volume_m3`, and `flag`.
#' @examples
#' library <- read_library("shanxia-2023")
#' library
#' predict(library, data.frame(species = "SM", dbh = c(10, 20), C = 0.5, M = 0.2, U = 0.5))
read_library <- function(file) {
  if (inherits(file, "silvafit_study")) file <- file.path(file$out, "library.json")
  if (inherits(file, "silvafit")) {
    path <- tempfile(fileext = ".json")
    on.exit(unlink(path))
    fit_json(file, path)
    file <- path
  }
  if (!is.character(file) || length(file) != 1) stop_usage("`file` has to be a path, the name of a published library, a study or a fit")
  result <- engine(.Call(C_read_library, path.expand(file), data_folder()))
  fits <- lapply(result$fits, stored_fit, call = match.call())
  models <- cbind(records(result$models, c("species", "response", "role")), records(lapply(fits, `[[`, "fit"), c("formula", "n", "converged")))
  names(fits) <- apply(models[1:3], 1, function(parts) paste(parts[parts != ""], collapse = " "))
  structure(list(models = models, fits = fits, handle = result$handle), class = "silvafit_library")
}

#' @rdname read_library
print.silvafit_library <- strict(function(x, ...) {
  cat("Library of", nrow(x$models), "models\n")
  print(x$models, row.names = FALSE)
  invisible(x)
})

#' @rdname read_library
predict.silvafit_library <- function(object, newdata, level = "population", interval = c("none", "prediction", "confidence"), coverage = 0.95, se.fit = FALSE,
                                     new_groups = "population", seen_groups = "fitted", role = "", equations = NULL, equation_files = NULL, columns = NULL,
                                     trust_units = FALSE, threads = 0, progress = interactive(), ...) {
  interval <- match.arg(interval)
  has_interval <- interval != "none"
  if (!missing(coverage) && !has_interval) stop_usage("`coverage` is that of intervals; give `interval`, too")
  own <- list(interval = if (has_interval) interval, coverage = if (has_interval) coverage, standard_errors = se.fit)
  result <- analysis_of_call("predict_library", newdata, c("reading", "predictions", "equations"), own, c(conf.level = "use coverage"), object$handle)
  if (is.character(newdata)) return(rows_of_file(result))
  predicted <- as.data.frame(result$tables$columns, check.names = FALSE)
  if (nrow(newdata) != nrow(predicted)) stop_input("the predicted rows are not those of `newdata`")
  own_copy(with_columns(newdata, predicted, "newdata"))
}

# The rows of a file as the program read them, with the new columns.
rows_of_file <- function(result) {
  rows <- as.data.frame(result$tables$rows, check.names = FALSE)
  # Texts that are all empty would be missing values.
  rows[names(result$tables$columns)] <- result$tables$columns
  rows
}

#' Grow trees into a 3D file
#'
#' @inheritParams inventory-arguments
#' @param file file of the scene, with the ending .glb, .gltf, .obj or .ply; without it, `out` is a folder for a file of each tree
#' @param ... further [settings] of trees and scenes and of the table
#' @return Data frame with a row for each tree, invisibly: its file and the measurements of its mesh.
#' @examples
#' trees <- data.frame(plot = 1, tree = 1:2, species = "SM", x = c(0, 4), y = c(0, 1),
#'                     dbh = c(18, 24), h = c(14, 17), hcb = c(5, 7), cw = c(3, 4))
#' file <- tempfile(fileext = ".glb")
#' grow_trees(trees, file, lod = 3)
#' file.size(file) > 0
grow_trees <- function(trees, file, plots = NULL, use = "observed", builder = "segment", preset = "", lod = 0, share = FALSE, seed = 1, columns = NULL,
                       trust_units = FALSE, threads = 0, progress = interactive(), ...) {
  if (missing(file) && is.null(list(...)$out)) stop_usage("`file` is missing: the file of the scene, such as stand.glb")
  result <- analysis_of_call("grow", trees, c("reading", "grow"), list(scene = if (!missing(file)) path.expand(file)))
  invisible(records(lapply(result$json$trees, Filter, f = function(value) length(value) == 1 && is.atomic(value))))
}

#' Show a stand in three dimensions
#'
#' Writes an HTML page with the trees and opens it in the viewer pane of the editor or in the browser.
#'
#' @inheritParams inventory-arguments
#' @param trees data frame, path of a CSV file, of a scene (.glb) or of the folder of a study
#' @param file HTML file to write
#' @eval setting_params("view", c("plots", "title"))
#' @param open open the page
#' @param ... further [settings] of the page and the table
#' @return The path of the page, invisibly.
#' @examples
#' trees <- data.frame(plot = 1, tree = 1:2, species = "SM", x = c(0, 4), y = c(0, 1),
#'                     dbh = c(18, 24), h = c(14, 17), hcb = c(5, 7), cw = c(3, 4))
#' page <- view_stand(trees, open = FALSE)
view_stand <- function(trees, file = tempfile("stand", fileext = ".html"), title = "Stand", plots = NULL, seed = 1, columns = NULL, trust_units = FALSE,
                       open = interactive(), threads = 0, progress = interactive(), ...) {
  if (inherits(trees, "silvafit_study")) trees <- trees$out
  analysis_of_call("view", trees, c("reading", "view"), list(file = path.expand(file)))
  if (open) (getOption("viewer", utils::browseURL))(file)
  invisible(file)
}
