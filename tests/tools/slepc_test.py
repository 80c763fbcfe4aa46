# SPDX-License-Identifier: MIT
"""The variances of `shape stats --algorithm krylov` beside those that SLEPc finds (its thick-restart Lanczos method
for singular values) in edge lengths that numpy measures."""
import glob
import sys
import tempfile
from pathlib import Path

import numpy as np

from ecosystem import needs, shape

# Debian keeps the modules beside the libraries.
sys.path += glob.glob("/usr/lib/slepcdir/slepc*/*-real/lib/python3/dist-packages")
sys.path += glob.glob("/usr/lib/petscdir/petsc*/*-real/lib/python3/dist-packages")
h5py, slepc4py = needs("Program.Slepc", "h5py", "slepc4py")
MODES, TOLERANCE = 12, 1e-6


def shape_vectors(file):
    """Edge lengths over their sum, a mesh a row."""
    with h5py.File(file) as collection:
        points = collection["points"][:]
        faces = collection["topology/faces"][:].astype(int)
    edges = np.unique(np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1), axis=0)
    lengths = np.linalg.norm(points[:, edges[:, 0]] - points[:, edges[:, 1]], axis=2)
    return lengths / lengths.sum(axis=1, keepdims=True)


def variances_by_slepc(rows):
    from petsc4py import PETSc
    from slepc4py import SLEPc

    centred = rows - rows.mean(axis=0)
    matrix = PETSc.Mat().createDense(centred.shape, array=centred)
    matrix.assemble()
    solver = SLEPc.SVD().create()
    solver.setOperator(matrix)
    solver.setType(SLEPc.SVD.Type.TRLANCZOS)
    solver.setDimensions(MODES)
    solver.setTolerances(1e-12, 1000)
    solver.solve()
    assert solver.getConverged() >= MODES
    return np.array([solver.getValue(k) for k in range(MODES)]) ** 2 / (len(rows) - 1)


def main():
    slepc4py.init([])
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        shape(folder, "synth", "faces", "-o", "faces", "--count", "60", "--vertices", "600")
        shape(folder, "collect", "faces", "-o", "c.h5")
        expected = variances_by_slepc(shape_vectors(folder / "c.h5"))
        for algorithm in ("krylov", "gram"):
            shape(folder, "stats", "c.h5", "--modes", str(MODES), "--algorithm", algorithm, "-o", f"{algorithm}.h5")
            with h5py.File(folder / f"{algorithm}.h5") as model:
                found = model["variances"][:]
            assert found.shape == expected.shape, (found, expected)
            worst = np.abs(found / expected - 1).max()
            print(f"{algorithm}: variances within {worst:.1e} of SLEPc's")
            assert worst <= TOLERANCE, (algorithm, found, expected)


if __name__ == "__main__":
    main()
