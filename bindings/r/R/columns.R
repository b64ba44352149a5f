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

# The numbers of bit64: each in two halves of 32 bits, whose smallest is NA.
plain_integers <- function(column, name) {
  bytes <- writeBin(as.vector(unclass(column)), raw(), endian = "little")
  halves <- matrix(readBin(bytes, "integer", 2 * length(column), endian = "little"), 2)
  low <- ifelse(is.na(halves[1, ]), 2^31, halves[1, ] %% 2^32)
  numbers <- halves[2, ] * 2^32 + low
  if (any(abs(numbers) > 2^53, na.rm = TRUE)) stop_input("column '", name, "' has numbers beyond 2^53; make it text with as.character()", column = name)
  numbers
}

# \param names  columns to take; all, without those that are neither numbers nor texts, if NULL
plain_columns <- function(data, names = NULL) {
  if (is.null(names)) {
    # Dates of inventories are texts, also as labels.
    for (name in base::names(data)) if (inherits(data[[name]], c("Date", "POSIXt"))) data[[name]] <- date_text(data[[name]])
    for (name in base::names(data)) if (inherits(data[[name]], "integer64")) data[[name]] <- plain_integers(data[[name]], name)
    usable <- vapply(data, function(column) {
      (is.factor(column) || is.character(column) || is.logical(column) || is.numeric(column)) &&
        is.null(dim(column)) && !inherits(column, not_numbers)
    }, logical(1))
    names <- base::names(data)[usable]
    unread <- vapply(data[!usable], function(column) class(column)[1], "")
    if (length(unread) > 0) tell(paste0("columns that are neither numbers, texts nor factors are not read: ", paste0(base::names(unread), " (", unread, ")", collapse = ", ")))
  }
  columns <- lapply(names, function(name) plain_column(data[[name]], name))
  base::names(columns) <- names
  columns
}

# The text of a time does not depend on those of other rows: a time of the day that is midnight has none.
date_text <- function(times) {
  days <- format(times, "%Y-%m-%d")
  if (inherits(times, "Date")) return(days)
  clock <- format(times, "%H:%M:%S")
  ifelse(clock == "00:00:00", days, paste(days, clock))
}

# Points of sf become the columns x and y, in meters.
without_geometry <- function(data) {
  if (!inherits(data, "sf")) return(data)
  if (!requireNamespace("sf", quietly = TRUE)) stop_usage("data of class sf need the package sf")
  geometry <- sf::st_geometry(data)
  plain <- sf::st_drop_geometry(data)
  if (all(sf::st_geometry_type(geometry) == "POINT")) {
    coordinates <- sf::st_coordinates(geometry)
    meters <- meters_of(geometry, "the points")
    for (i in seq_len(ncol(coordinates))) {
      name <- c("x", "y", "z")[i]
      # st_as_sf(remove = FALSE) leaves the coordinates as columns.
      if (!is.null(plain[[name]]) && !has_values(plain[[name]], coordinates[, i])) {
        if (name == "z") next
        tell(paste0("the column ", name, " differs from the positions of the points; the points are used, and the column is called ", name, "_column"))
        plain[[paste0(name, "_column")]] <- plain[[name]]
      }
      plain[[name]] <- coordinates[, i] * meters
    }
  }
  plain
}

# The unit of the coordinates of a geometry in meters; 1 for degrees, which inventories refuse, and without a coordinate reference system.
meters_of <- function(geometry, what) {
  system <- sf::st_crs(geometry)
  if (is.na(system) || isTRUE(sf::st_is_longlat(system)) || isTRUE(system$units_gdal %in% c("metre", "meter"))) return(1)
  meters <- tryCatch(as.double(units::set_units(system$ud_unit, "m", mode = "standard")), error = function(e) NA)
  # sf takes units that it does not know for meters.
  if (!isTRUE(meters != 1)) stop_input("the unit of the coordinates of ", what, ", ", system$units_gdal, ", is not known; use sf::st_transform() to a coordinate reference system in meters")
  meters
}

# Units of the columns of class `units`, by name.
units_of <- function(data) {
  if (!is.data.frame(data)) return(character())
  vapply(Filter(function(column) inherits(column, "units"), as.list(data)), units::deparse_unit, "")
}

# Numbers in another unit.
in_unit <- function(values, unit, what) {
  as.double(tryCatch(units::set_units(values, unit, mode = "standard"),
                     error = function(e) stop_input(what, " has the unit ", units::deparse_unit(values), ", which is not one of ", unit)))
}

# Units of columns of trees and plots that may have another one.
tree_units <- c(dbh = "cm", x = "m", y = "m", z = "m", h = "m", hcb = "m", cw = "m", area = "m2", radius = "m")

# Whether sizes of trees have declared units that are not those of inventories.
has_other_units <- function(data) {
  given <- units_of(data)
  any(given != tree_units[tolower(names(given))], na.rm = TRUE)
}

in_units_of_trees <- function(data) {
  given <- units_of(data)
  for (name in names(given)) {
    unit <- tree_units[tolower(name)]
    if (is.na(unit)) stop_input("column '", name, "' has the unit ", given[[name]], "; make it a number with units::drop_units(), of dbh in cm, of other lengths in m", column = name)
    data[[name]] <- in_unit(data[[name]], unit, paste0("column '", name, "'"))
  }
  data
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
# scale() makes a matrix of one column; the fit knows the units of its data.
with_plain_values <- function(data) {
  for (name in names(data)) {
    column <- data[[name]]
    if ((is.matrix(column) && ncol(column) == 1) || inherits(column, "units")) {
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
