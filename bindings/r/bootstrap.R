# SPDX-License-Identifier: MIT
# Copies into the package what it needs of the checkout, so that it can be compiled without installed libraries: `R CMD build`, after this,
# writes the source package. pkgbuild, and with it remotes and r-universe, run this by themselves.
#
# SILVAFIT_SOURCE is the checkout (default: two folders up). The headers of other libraries are those of the system (Debian and Ubuntu:
# libeigen3-dev, libceres-dev, libfmt-dev, libhwy-dev, nlohmann-json3-dev, libnanoflann-dev, libkainjow-mustache-dev, libmeshoptimizer-dev). SILVAFIT_LIBRARY_SOURCES is a
# folder with sources of highway, meshoptimizer and Ceres Solver, beside which scripts/static-libraries has installed them; without it, the package is linked with the system's libraries.
checkout <- normalizePath(Sys.getenv("SILVAFIT_SOURCE", file.path("..", "..")))
if (!dir.exists(file.path(checkout, "libfit"))) stop("the checkout of silvafit was not found; set SILVAFIT_SOURCE")
library_sources <- Sys.getenv("SILVAFIT_LIBRARY_SOURCES")
sources_of_a_unit <- 12L

copy <- function(from, to, files) {
  for (folder in unique(dirname(file.path(to, files)))) dir.create(folder, recursive = TRUE, showWarnings = FALSE)
  stopifnot(file.copy(file.path(from, files), file.path(to, files), overwrite = TRUE))
}

# Returns the names of the files.
copy_folder <- function(from, to, pattern = NULL, without = "^$") {
  files <- grep(without, list.files(from, pattern, recursive = TRUE), perl = TRUE, invert = TRUE, value = TRUE)
  if (length(files) == 0) stop("no files in ", from)
  copy(from, to, files)
  files
}

# The C++ libraries, in one folder, because their files have different names. The sources of threads/ replace those of TBB.
copy_core <- function() {
  for (name in c("base", "data", "fit", "stand", "tree", "study")) {
    folder <- file.path(checkout, paste0("lib", name))
    copy_folder(file.path(folder, "include"), "src/core", "[.]hpp$")
    files <- copy_folder(file.path(folder, "src"), "src/core", "[.][ch]pp$", "_test[.]cpp$|test_support|^mpi/|^parallel[.]cpp$")
    if (name == "stand") files <- c(files, write_known_tables("trees/known_table_texts.cpp"))
    # In an order that does not depend on the language.
    write_units(name, sort(grep("[.]cpp$", files, value = TRUE), method = "radix"))
  }
}

# The descriptions of national inventories as texts of a source file, as libstand/CMakeLists.txt makes it.
write_known_tables <- function(file) {
  texts <- vapply(sort(list.files(file.path(checkout, "models/sources"), "[.]json$", full.names = TRUE), method = "radix"),
                  function(path) paste0("      R\"json(", paste(readLines(path), collapse = "\n"), ")json\","), "")
  writeLines(c('#include "trees/known_tables.hpp"', "namespace silvafit::stand {", "const std::vector<std::string_view>& known_table_texts() {",
               "  static const std::vector<std::string_view> texts{", texts, "  };", "  return texts;", "}", "}"), file.path("src/core", file))
  file
}

# Several sources of a folder are compiled as one, as by cmake/SilvafitTargets.cmake. Vector code stands alone. The package may be compiled on
# another system than it was written on.
write_units <- function(library, sources) {
  alone <- vapply(file.path("src/core", sources), function(path) any(grepl("HWY_TARGET_INCLUDE", readLines(path))), NA)
  groups <- ifelse(alone, sources, dirname(sources))
  for (group in unique(groups)) {
    # In libstand, windows are those of plots.
    condition <- if (library == "base") c(windows = "defined(_WIN32)", posix = "!defined(_WIN32)", linux = "defined(__linux__)")[group] else NA
    write_unit(paste("core", library, sub("[.]cpp$", "", group), sep = "_"), file.path("core", sources[groups == group]), condition)
  }
}

write_unit <- function(name, sources, condition = NA) {
  parts <- split(sources, (seq_along(sources) - 1L) %/% sources_of_a_unit)
  for (part in names(parts)) {
    lines <- sprintf('#include "%s"', parts[[part]])
    if (!is.na(condition)) lines <- c(paste("#if", condition), lines, "#endif")
    writeLines(lines, file.path("src", paste0(gsub("[^a-z0-9]+", "_", paste(name, part, sep = "_")), ".cpp")))
  }
}

# The folder of the system's headers with this one.
include_folder <- function(header) {
  folders <- c("/usr/include/eigen3", "/usr/include", "/usr/local/include", "/opt/homebrew/include", "/opt/homebrew/include/eigen3")
  found <- folders[file.exists(file.path(folders, header))]
  if (length(found) == 0) stop("the header ", header, " was not found; the beginning of bootstrap.R names the packages")
  found[1]
}

copy_headers <- function() {
  for (header in c("nanoflann.hpp", "meshoptimizer.h", "kainjow/mustache.hpp", "unsupported/Eigen/AutoDiff")) copy(include_folder(header), "src/third_party", header)
  for (folder in c("fmt", "hwy", "nlohmann", "Eigen")) {
    first <- c(fmt = "fmt/format.h", hwy = "hwy/highway.h", nlohmann = "nlohmann/json.hpp", Eigen = "Eigen/Dense")[[folder]]
    copy_folder(file.path(include_folder(first), folder), file.path("src/third_party", folder), without = "^tests/|^contrib/(?!math)|^CMake")
  }
  automatic <- "unsupported/Eigen/src/AutoDiff"
  copy_folder(file.path(include_folder(automatic), automatic), file.path("src/third_party", automatic))
}

# Highway's choice of the instruction set, meshoptimizer and Ceres Solver.
copy_library_sources <- function() {
  if (library_sources == "") {
    copy_folder(file.path(include_folder("ceres/ceres.h"), "ceres"), "src/third_party/ceres", "[.]h$")
    return(c("-lhwy", "-lmeshoptimizer", "-lceres", "-lglog"))
  }
  copy_ceres()
  copy(file.path(library_sources, "highway"), "src/third_party", c("hwy/targets.cc"))
  writeLines(c("#include <stdexcept>", '#include "third_party/hwy/targets.cc"'), "src/third_party_hwy.cpp")
  folder <- file.path(library_sources, "meshoptimizer/src")
  sources <- list.files(folder, "codec|filter|vcacheoptimizer|vfetchoptimizer|indexgenerator|allocator")
  copy(folder, "src/third_party/meshoptimizer", c(sources, "meshoptimizer.h"))
  for (source in sources) {
    writeLines(sprintf('#include "third_party/meshoptimizer/%s"', source), file.path("src", paste0("third_party_", source)))
  }
  character()
}

# What the static library was made of, with its headers and its own logging.
copy_ceres <- function() {
  installed <- file.path(library_sources, "..")
  private <- file.path(library_sources, "ceres-solver/internal/ceres")
  copy_folder(file.path(installed, "include/ceres"), "src/third_party/ceres", "[.]h$")
  headers <- list.files(private, "[.]h$")
  copy(private, "src/third_party/ceres", headers)
  # One of them is included twice in a unit and has no guard.
  for (header in file.path("src/third_party/ceres", headers)) {
    lines <- readLines(header)
    if (!any(grepl("^#ifndef|^#pragma once", lines))) writeLines(c("#pragma once", lines), header)
  }
  objects <- system2("ar", c("t", shQuote(file.path(installed, "lib/libceres.a"))), stdout = TRUE)
  found <- list.files(private, "[.]cc$", recursive = TRUE)
  sources <- sort(found[basename(found) %in% sub("[.]o$", "", objects)], method = "radix")
  copy(private, "src/third_party/ceres", sources)
  write_unit("third_party_ceres", file.path("third_party/ceres", sources))
}

# R's rules: compiled code does not end the process, does not write to its streams, does not draw the system's random numbers, and gives no
# warnings nor suppresses them.
replace <- function(file, ...) {
  text <- paste(readLines(file), collapse = "\n")
  for (change in list(...)) text <- gsub(change[1], change[2], text)
  writeLines(text, file)
}
follow_rules_of_r <- function() {
  replace("src/core/ranks.cpp", c("std::_Exit\\(status\\)", "throw status"))
  replace("src/third_party/nanoflann.hpp", c("fprintf\\(stderr[^;]*;", ""))
  if (file.exists("src/third_party/hwy/targets.cc")) {
    replace("src/third_party/hwy/targets.cc", c("f(printf|flush)\\(stderr[^;]*;", ""), c("abort\\(\\)", "throw std::runtime_error(buf)"))
  }
  follow_rules_in_ceres()
  for (file in list.files("src/third_party/nlohmann", recursive = TRUE, full.names = TRUE)) {
    replace(file, c("(^|\n)[ \t]*# *pragma (GCC|clang) diagnostic[^\n]*", "\\1"))
  }
}

follow_rules_in_ceres <- function() {
  inside <- function(file, ...) replace(file.path("src/third_party/ceres", file), ...)
  inside("internal/port.h", c("(define CERES_DEPRECATED_WITH_MSG\\(message\\))[^\n]*", "\\1"))
  if (library_sources == "") return(invisible())
  for (file in c("c_api.cc", "callbacks.cc")) inside(file, c("std::cout[^;]*;", ";"))
  inside("internal/miniglog/glog/logging.h", c("std::cerr << stream_.str\\(\\);", ""), c("#include <ctime>", "#include <ctime>\n#include <stdexcept>"),
         c("~MessageLogger\\(\\)", "~MessageLogger() noexcept(false)"), c("abort\\(\\);", "throw std::runtime_error(stream_.str());"))
  engine <- "inline std::minstd_rand& random_engine() {\n  thread_local std::minstd_rand engine;\n  return engine;\n}"
  inside("random.h", c("#include <cstdlib>", "#include <random>"), c("namespace ceres \\{", paste0("namespace ceres {\n\n", engine)),
         c("srand\\(state\\)", "random_engine().seed(state)"), c("rand\\(\\)", "random_engine()()"), c("RAND_MAX", "std::minstd_rand::max()"))
}

copy_data <- function() {
  copy_folder(file.path(checkout, "models"), "inst/silvafit/models", without = "^CMakeLists")
  pages <- file.path(checkout, "build/share/silvafit/viewer")
  if (!dir.exists(pages)) return(message("without the report pages, which `make build` writes"))
  copy_folder(pages, "inst/silvafit/viewer", "[.]html$")
  # The headers contain their licences, the pages do not.
  files <- file.path(checkout, c("scripts/package-copyright", "LICENSE", "build/viewer/workshop"))
  writeLines(system2("python3", shQuote(files), stdout = TRUE), "inst/COPYRIGHTS")
}

unlink(c("src/core", "src/third_party", "inst/silvafit", "inst/COPYRIGHTS", Sys.glob(c("src/core_*.cpp", "src/third_party_*.cpp"))), recursive = TRUE)
copy_core()
copy_headers()
libraries <- copy_library_sources()
follow_rules_of_r()
copy_data()
# configure looks for this file.
writeLines(paste(c(libraries, "-lpng", "-lz"), collapse = " "), "src/core/libraries")
