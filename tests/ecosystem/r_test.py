# SPDX-License-Identifier: MIT
"""R reads `shape export --to csv` by the lines that come with it, and finds in it what we found."""
import shutil
import tempfile
from pathlib import Path

from ecosystem import command, shape, skip

if shutil.which("Rscript") is None:
    skip("Ecosystem.R", "R is not there (r-base-core)")
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    shape(folder, "synth", "faces", "-o", "faces", "--count", "4", "--vertices", "400")
    names = sorted(path.stem for path in (folder / "faces").glob("*.ply"))
    rows = [f"{mesh},{'TF'[i % 2] if i else 'NA'},{'NA' if i == 3 else i}" for i, mesh in enumerate(names)]
    (folder / "l.csv").write_text("\n".join(["mesh,flag,age"] + rows) + "\n", encoding="utf-8")
    shape(folder, "stats", "faces", "--labels", "l.csv", "--space", "procrustes", "--scale",
          "none", "-o", "model.h5")
    shape(folder, "export", "model.h5", "--to", "csv", "-o", "tables")
    shape(folder, "distance", "faces", "--space", "procrustes", "--scale", "none", "-o", "d.csv")
    (folder / "tables/test.R").write_text(
        """
source("read.R")
stopifnot(is.array(A), length(dim(A)) == 3, dim(A)[2] == 3, dim(A)[3] == 12)
stopifnot(identical(dimnames(A)[[3]], labels$mesh), identical(labels$mesh, position_scores$mesh))
first <- subset(landmarks, mesh == labels$mesh[5] & vertex == 7)
stopifnot(A[7, , 5] == unlist(first[c("x", "y", "z")]))
# Labels are as they are written, numbers numbers, what is missing NA.
at <- order(labels$mesh)
stopifnot(identical(labels$flag[at], c(NA, rep(c("F", "T"), 6)[1:11])))
stopifnot(identical(labels$age[at], c(0, 1, 2, NA, 4:11)))
stopifnot(min(faces) == 1, max(faces) == dim(A)[1])
# The principal components of the positions are ours, up to their signs.
flat <- t(apply(A, 3, c))
p <- prcomp(flat)
k <- ncol(position_scores) - 1
ours <- as.matrix(position_scores[, -1])
theirs <- p$x[, 1:k]
stopifnot(max(abs(abs(ours) - abs(theirs))) < 1e-6 * max(abs(ours)))
cat("k =", k, " largest difference of scores:", max(abs(abs(ours) - abs(theirs))), "\\n")
""",
        encoding="utf-8",
    )
    print(*command(folder / "tables", "Rscript", "--vanilla", "test.R"), sep="\n")
