# SPDX-License-Identifier: MIT
# Each setting of docs/settings.md is an argument of the functions that the page names.
checkout <- Sys.getenv("SILVAFIT_CHECKOUT")
if (checkout == "") exit_file("the pages are those of a checkout")
page <- readLines(file.path(checkout, "docs", "settings.md"))
starts <- grep("^## ", page)

# The arguments of a function: its own, and those that it takes in its dots.
takes <- function(name, argument) {
  call_it <- getFromNamespace(name, "silvafit")
  if (argument %in% names(formals(call_it))) return(TRUE)
  if (!"..." %in% names(formals(call_it))) return(FALSE)
  # A value that no setting has: the argument is refused for its value, not for its name.
  given <- list(quote(trees), tempfile(fileext = ".glb"))
  if (grepl("^predict", name)) given[[1]] <- read_library("shanxia-2023")
  trees <- data.frame(plot = 1, tree = 1:2, species = "SM", x = c(0, 4), y = c(0, 1), dbh = c(18, 24), h = c(14, 17))
  if (grepl("^predict", name)) given[[2]] <- trees
  if (name %in% c("structural_units", "stand_summary", "stand_growth", "impute")) given <- given[1]
  given[[argument]] <- complex(1)
  message <- tryCatch({
    do.call(call_it, given)
    ""
  }, error = conditionMessage)
  !grepl("unknown argument", message)
}

for (k in seq_along(starts)) {
  lines <- page[starts[k]:c(starts[-1] - 1, length(page))[k]]
  functions <- regmatches(grep("^- R:", lines, value = TRUE), gregexpr("`[^`]+`", grep("^- R:", lines, value = TRUE)))[[1]]
  settings <- sub("^\\| `[^`]+` \\| [^|]* \\| `([^`]+)`.*", "\\1", grep("^\\| `", lines, value = TRUE))
  expect_true(length(functions) > 0 && length(settings) > 0)
  for (name in gsub("`", "", functions)) {
    for (argument in strsplit(settings, ", ")) {
      expect_true(all(vapply(argument, takes, TRUE, name = name)), info = paste(name, paste(argument, collapse = ", ")))
    }
  }
}

# The help page ?settings has each setting with its meaning; where it does not, run scripts/r-help.
letters_of <- function(text) gsub("[^[:alnum:]]", "", text)
help <- letters_of(paste(capture.output(tools::Rd2txt(file.path(checkout, "bindings/r/man/settings.Rd"))), collapse = ""))
settings <- silvafit:::setting_list("reading", "units", "sampling", "stand", "equations", "study", "imputation", "predictions", "grow", "view")
expect_true(length(settings$name) > 100)
entries <- letters_of(paste0(settings$argument, settings$help))
expect_equal(settings$name[!vapply(entries, grepl, NA, x = help, fixed = TRUE)], character())

expect_error(structural_units(data.frame(dbh = 1), fil_down = "plot"), "did you mean 'fill_down'")
expect_error(impute(data.frame(dbh = 1), fil_down = "plot"), "did you mean 'fill_down'")

# A model of the catalogue by its id, with the start values of its rules: M4 is its formula.
source("helpers.R", local = TRUE)
set.seed(3)
stand <- data.frame(dbh = runif(80, 8, 40))
stand$h <- 1.3 + 24 * (1 - exp(-0.05 * stand$dbh)) + rnorm(80, sd = 0.5)
by_id <- silvafit("M4", stand)
expect_equal(coef(by_id), coef(silvafit(formula(by_id), stand)), tolerance = 1e-6)
expect_equal(by_id$fit$model, "M4")
expect_error(silvafit("M4x", stand), "M4")
# Its predictions read rows as the program does.
codes <- transform(stand[1:4, ], dbh = c(0, -999, 20, 30))
expect_message(by_code <- predict(by_id, codes), "codes read as missing values: dbh 2 (0, -999)", class = "silvafit_note", fixed = TRUE)
expect_equal(is.na(unname(by_code)), c(TRUE, TRUE, FALSE, FALSE))
expect_error(predict(by_id, transform(codes, dbh = -1)), "outside the domain of the model", class = "silvafit_domain_error")
