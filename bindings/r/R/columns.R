# SPDX-License-Identifier: MIT
# Columns of data frames as the C++ libraries take them: numbers and texts.

plain_column <- function(column, name) {
  if (is.factor(column) || is.character(column)) return(as.character(column))
  is_plain <- (is.logical(column) || is.numeric(column)) && (is.null(dim(column)) || length(dim(column)) == 1)
  if (is_plain && !inherits(column, not_numbers)) return(if (is.double(column) && is.null(attributes(column))) column else as.double(column))
  remedy <- if (inherits(column, not_numbers)) "make it a number with as.numeric()" else "it has to be numeric, a factor or text"
  stop_input("column '", name, "' is of class ", class(column)[1], "; ", remedy, column = name)
}

# Classes of numbers that mean something else.
not_numbers <- c("Date", "POSIXt", "difftime", "integer64")

# \param names  columns to take; all, without those that are neither numbers nor texts, if NULL
plain_columns <- function(data, names = NULL) {
  if (is.null(names)) {
    usable <- vapply(data, function(column) {
      (is.factor(column) || is.character(column) || is.logical(column) || is.numeric(column)) &&
        is.null(dim(column)) && !inherits(column, not_numbers)
    }, logical(1))
    names <- base::names(data)[usable]
  }
  columns <- lapply(names, function(name) plain_column(data[[name]], name))
  base::names(columns) <- names
  columns
}

# Points of sf become the columns x and y.
without_geometry <- function(data) {
  if (!inherits(data, "sf")) return(data)
  if (!requireNamespace("sf", quietly = TRUE)) stop_usage("data of class sf need the package sf")
  geometry <- sf::st_geometry(data)
  plain <- sf::st_drop_geometry(data)
  if (all(sf::st_geometry_type(geometry) == "POINT")) {
    coordinates <- sf::st_coordinates(geometry)
    if (!"x" %in% names(plain)) plain$x <- coordinates[, 1]
    if (!"y" %in% names(plain)) plain$y <- coordinates[, 2]
    if (ncol(coordinates) >= 3 && !"z" %in% names(plain)) plain$z <- coordinates[, 3]
  }
  plain
}

check_data <- function(data, argument = "data") {
  if (!is.data.frame(data)) stop_usage("`", argument, "` has to be a data frame, not an object of class ", class(data)[1])
  data <- without_geometry(data)
  # Tibbles and groupedData of nlme are plain data frames from here on.
  if (!identical(class(data), "data.frame")) data <- as.data.frame(data)
  if (nrow(data) == 0) stop_input("`", argument, "` has no rows")
  twice <- names(data)[duplicated(names(data))]
  if (length(twice) > 0) stop_input("`", argument, "` has two columns '", twice[1], "'", column = twice[1])
  with_plain_values(data)
}

# An empty text is a missing value, as in CSV files: read.csv() keeps the empty cells of text columns.
# scale() makes a matrix of one column.
with_plain_values <- function(data) {
  for (name in names(data)) {
    column <- data[[name]]
    if (is.matrix(column) && ncol(column) == 1) {
      data[[name]] <- as.vector(column)
    } else if (is.factor(column) && "" %in% levels(column)) {
      levels(data[[name]])[levels(column) == ""] <- NA
    } else if (is.character(column) && any(column == "", na.rm = TRUE)) {
      data[[name]][which(column == "")] <- NA
    }
  }
  data
}

# Columns that cannot be used stop here, before other functions meet them.
check_columns <- function(data) {
  for (name in names(data)) plain_column(data[[name]], name)
  data
}
