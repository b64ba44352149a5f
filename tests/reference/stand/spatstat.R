# SPDX-License-Identifier: MIT
# Figures of spatstat that structural units and stand figures are compared with. Not run by the tests.
#   Rscript spatstat.R PUBLIC_FOLDER     (PUBLIC_FOLDER holds longleaf.csv and finpines.csv)
# Debian: r-cran-spatstat.geom, r-cran-spatstat.explore, r-cran-jsonlite.
# Writes pattern.csv (300 clustered points in a concave window with a hole, and what spatstat says of each)
# and patterns.json beside the script's working folder.
suppressMessages({
  library(spatstat.geom)
  library(spatstat.random)
  library(spatstat.explore)
  library(jsonlite)
})
folder <- commandArgs(TRUE)[1]
options(digits = 17)

outer <- list(x = c(0, 60, 60, 35, 35, 0), y = c(0, 0, 40, 40, 22, 35))
hole <- list(x = c(12, 12, 20, 20), y = c(8, 16, 16, 8))
window <- owin(poly = list(outer, hole))

set.seed(20220407)
points <- rMatClust(0.02, 4, 8, win = window)
points <- points[seq_len(min(300, npoints(points)))]
points <- ppp(round(points$x, 3), round(points$y, 3), window = window)
points <- unique(points)
n <- npoints(points)
dbh <- round(5 + rgamma(n, 2, 0.15), 1)
cw <- round(runif(n, 1, 5), 2)
species <- sample(c("A", "B", "C"), n, replace = TRUE)

k <- 4
distances <- nndist(points, k = 1:k)
which <- nnwhich(points, k = 1:k)
boundary <- bdist.points(points)
# Areas of the window less a margin, by Clipper's polygon offset with fine arcs (erosion() has coarse ones).
ring_area <- function(ring) {
  after <- c(2:length(ring$x), 1)
  sum(ring$x * ring$y[after] - ring$x[after] * ring$y) / 2
}
eroded <- sapply(distances[, k], function(r) {
  rings <- polyclip::polyoffset(list(outer, hole), -r, jointype = "round", arctol = 1e-6, eps = 1e-7)
  sum(sapply(rings, ring_area))
})
keep <- distances[, k] < boundary
differentiation <- sapply(seq_len(n), function(i) {
  mean(1 - pmin(dbh[i], dbh[which[i, ]]) / pmax(dbh[i], dbh[which[i, ]]))
})
hegyi <- sapply(seq_len(n), function(i) sum(dbh[which[i, ]] / dbh[i] / distances[i, ]))
all_pairs <- pairdist(points)
hegyi6 <- sapply(seq_len(n), function(i) {
  near <- all_pairs[i, ] <= 6 & seq_len(n) != i
  sum(dbh[near] / dbh[i] / all_pairs[i, near])
})
# The same points on a torus: the rectangle around the window.
box <- owin(c(0, 60), c(0, 40))
periodic <- pairdist(ppp(points$x, points$y, window = box), periodic = TRUE)
torus <- t(apply(periodic, 1, function(row) sort(row)[2:(k + 1)]))
# Crowns: areas shared by two discs, as polygons of many corners.
overlap <- sapply(seq_len(n), function(i) {
  own <- disc(cw[i] / 2, c(points$x[i], points$y[i]), npoly = 2048)
  mean(sapply(which[i, ], function(j) {
    other <- disc(cw[j] / 2, c(points$x[j], points$y[j]), npoly = 2048)
    shared <- intersect.owin(own, other, fatal = FALSE)
    if (is.null(shared) || is.empty(shared)) 0 else area(shared) / area(own)
  }))
})
table <- data.frame(tree = seq_len(n), species, x = points$x, y = points$y, dbh, cw,
  which, distances, torus, boundary, eroded, keep = as.integer(keep), differentiation, hegyi, hegyi6,
  overlap)
names(table)[7:18] <- c(paste0("nn", 1:k), paste0("d", 1:k), paste0("torus", 1:k))
numbers <- sapply(table, is.numeric)
table[numbers] <- lapply(table[numbers], function(column) sprintf("%.12g", column))
write.csv(table, "pattern.csv", row.names = FALSE, quote = FALSE)

figures <- function(pattern) {
  index <- clarkevans(pattern, correction = c("none", "Donnelly"))
  test <- clarkevans.test(pattern, correction = "none")
  list(n = npoints(pattern), area = area(Window(pattern)), perimeter = perimeter(Window(pattern)),
    mean_nearest = mean(nndist(pattern)), R = index[["naive"]], R_donnelly = index[["Donnelly"]],
    p = test$p.value)
}
read_pattern <- function(name, xrange, yrange) {
  data <- read.csv(file.path(folder, name))
  ppp(data$x, data$y, window = owin(xrange, yrange))
}
hull <- convexhull(points)
result <- list(
  meta = list(R = R.version.string, spatstat.geom = as.character(packageVersion("spatstat.geom")),
    spatstat.explore = as.character(packageVersion("spatstat.explore"))),
  pattern = list(n = n, area = area(window), perimeter = perimeter(window),
    mean_nearest = mean(distances[, 1]),
    R = clarkevans(points, correction = "none"),
    hull_area = area(hull), hull_perimeter = perimeter(hull),
    hanisch_mean_dbh = sum(dbh[keep] / eroded[keep]) / sum(1 / eroded[keep])),
  longleaf = figures(read_pattern("longleaf.csv", c(0, 200), c(0, 200))),
  finpines = figures(read_pattern("finpines.csv", c(-5, 5), c(-8, 2)))
)
write_json(result, "patterns.json", auto_unbox = TRUE, digits = NA, pretty = TRUE)
