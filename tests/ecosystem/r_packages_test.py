# SPDX-License-Identifier: MIT
"""R's own methods beside ours: procGPA (shapes), adonis2 (vegan) and lda (MASS); and hdf5r reads our files."""
import json
import shutil
import tempfile
from pathlib import Path

from ecosystem import command, shape, skip

NAME = "Ecosystem.RPackages"
if shutil.which("Rscript") is None:
    skip(NAME, "R is not there (r-base-core)")
PACKAGES = ("shapes", "vegan", "MASS", "hdf5r")
found = command(Path("/"), "Rscript", "--vanilla", "-e", 'cat(rownames(installed.packages()), sep = "\\n")')
missing = [package for package in PACKAGES if package not in found]
if missing:
    skip(NAME, f"R has no {', '.join(missing)} ({' '.join('r-cran-' + each.lower() for each in missing)})")

with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    labels = ["--labels", "faces/labels.csv"]
    shape(folder, "synth", "faces", "-o", "faces", "--count", "5", "--vertices", "400")
    shape(folder, "collect", "faces", *labels, "-o", "faces.h5", "--compress")
    # Procrustes: mean, variances and scores, without and with scaling.
    for scale in ("none", "unit"):
        shape(folder, "stats", "faces.h5", "--space", "procrustes", "--scale", scale, "-o", f"{scale}.h5")
        shape(folder, "project", f"{scale}.h5", "faces.h5", "-o", f"{scale}.csv")
    shape(folder, "distance", "faces.h5", "-o", "d.csv")
    groups = json.loads(shape(folder, "groups", "faces.h5", "--by", "expression", "--within", "subject", "-o",
                              "groups.csv", "--bootstrap", "10", "--json"))
    shape(folder, "classify", "faces.h5", "--by", "expression", "--leave-out", "subject", "--modes", "3", "-o",
          "confusion.csv", "--predictions", "predicted.csv", "--quiet")
    (folder / "test.R").write_text(
        f"""
options(rgl.useNULL = TRUE)
suppressPackageStartupMessages({{ library(shapes); library(vegan); library(MASS) }})
agree <- function(what, ours, theirs, tolerance) {{
    error <- max(abs(ours - theirs)) / max(abs(theirs))
    cat(sprintf("%s: largest relative difference %.1e\\n", what, error))
    stopifnot(is.finite(error), error < tolerance)
}}
f <- hdf5r::H5File$new("faces.h5", "r")
points <- f[["points"]]$read()                       # 3 x vertices x meshes
faces <- f[["topology/faces"]]$read() + 1L           # 3 x faces
meshes <- f[["names"]]$read()
expression <- f[["labels/expression"]]$read()
subject <- f[["labels/subject"]]$read()
f$close_all()
stopifnot(dim(points)[1] == 3, dim(points)[3] == 15, length(meshes) == 15, setequal(expression, c("neutral", "happy", "angry")))
A <- aperm(points, c(2, 1, 3))

scores_of <- function(file) {{
    table <- read.csv(file)
    stopifnot(identical(table$mesh, meshes))
    as.matrix(table[, grep("^pc", names(table))])
}}
for (scale in c("none", "unit")) {{
    ours <- scores_of(paste0(scale, ".csv"))
    gpa <- procGPA(A, scale = scale == "unit", tol1 = 1e-14, tol2 = 1e-14)
    k <- 5
    if (scale == "none") {{
        agree("procGPA without scaling, scores", abs(ours[, 1:k]), abs(gpa$rawscores[, 1:k]), 1e-5)
    }} else {{ # two habits of scaling: to unit size each, or optimally to the mean; they differ in second order
        share <- apply(ours, 2, var) / sum(apply(ours, 2, var))
        agree("procGPA with scaling, shares of variance", share[1:k], (gpa$percent / 100)[1:k], 0.02)
    }}
}}

D <- as.dist(as.matrix(read.csv("d.csv", row.names = 1, check.names = FALSE)))
labels <- data.frame(expression, subject)
set.seed(1)
ours <- list(f = {groups["overall"]["f"]!r}, r2 = {groups["overall"]["r_squared"]!r}, p = {groups["overall"]["p_value"]!r})
theirs <- adonis2(D ~ subject + expression, labels, by = "terms", strata = labels$subject, permutations = 999)
agree("adonis2, F", ours$f, theirs["expression", "F"], 1e-9)
cat("adonis2: p", theirs["expression", "Pr(>F)"], "ours", ours$p, "\\n")
stopifnot(abs(theirs["expression", "Pr(>F)"] - ours$p) < 0.02)

# lda on the leading scores of the meshes of the other subjects, as `shape classify` does it.
ends <- unique(do.call(rbind, lapply(list(1:2, 2:3, c(3, 1)), function(k) t(apply(faces[k, ], 2, sort)))))
lengths <- t(apply(points, 3, function(x) sqrt(colSums((x[, ends[, 1]] - x[, ends[, 2]])^2))))
lengths <- lengths / rowSums(lengths)
predicted <- character(15)
for (one in unique(subject)) {{
    out <- subject == one
    p <- prcomp(lengths[!out, ], rank. = 3)
    predicted[out] <- as.character(predict(lda(p$x, factor(expression[!out])), predict(p, lengths[out, ]))$class)
}}
ours <- read.csv("predicted.csv")
ours <- ours$predicted[match(meshes, ours$mesh)]
cat("lda:", sum(ours == predicted), "of 15 predictions are the same;", sum(ours == expression), "are right\\n")
stopifnot(ours == predicted)
""",
        encoding="utf-8",
    )
    print(*command(folder, "Rscript", "--vanilla", "test.R"), sep="\n")
