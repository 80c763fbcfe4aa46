# SPDX-License-Identifier: MIT
"""`shape export --to statismo` and `slicermorph`, `shapeworks`, read by the layouts of docs/ecosystem.md."""
import csv
import json
import tempfile
from pathlib import Path

from ecosystem import needs, shape

h5py, np = needs("Ecosystem.Statismo", "h5py", "numpy")


def check_statismo(folder: Path, space: str) -> None:
    with h5py.File(folder / "model.h5") as f:
        vertices = f["points" if "points" in f else "reference_points"].shape[0]
        faces = f["topology/faces"][...]
        names = [name for name in f["names"].asstr()[...]]
        sizes = f["sizes"][...]
    # The oldest form of HDF5, which readers that are not the HDF Group's know best; and nothing but the layout.
    assert (folder / "statismo.h5").read_bytes()[:9] == b"\x89HDF\r\n\x1a\n\0"
    with h5py.File(folder / "statismo.h5") as f:
        found = set()
        f.visititems(lambda path, item: found.add(path) if isinstance(item, h5py.Dataset) else None)
        builder = "modelinfo/modelBuilder-0"
        assert found == {
            "version/majorVersion", "version/minorVersion", "model/mean", "model/pcaBasis", "model/pcaVariance",
            "model/noiseVariance", "representer/points", "representer/cells", "modelinfo/scores",
            "modelinfo/build-time", f"{builder}/builderName", f"{builder}/buildTime", f"{builder}/parameters/basis",
        } | {f"{builder}/dataInfo/URI_{i}" for i in range(len(names))}, found
        version = [f["version/majorVersion"], f["version/minorVersion"]]
        assert [(v.shape, v.dtype, int(v[()])) for v in version] == [((), "<i4", 0), ((), "<i4", 9)]
        mean, basis, variance = f["model/mean"], f["model/pcaBasis"], f["model/pcaVariance"]
        n, k = vertices, variance.shape[0]
        assert mean.shape == (3 * n,) and basis.shape == (3 * n, k) and k > 0
        for item in (mean, basis, variance, f["model/noiseVariance"], f["representer/points"],
                     f["modelinfo/scores"]):
            assert item.dtype == "<f4", item
            assert item.chunks is None and item.compression is None and not item.fletcher32
        assert f["model/noiseVariance"].shape == () and f["model/noiseVariance"][()] == 0
        assert np.all(np.diff(variance[...]) <= 0) and np.all(variance[...] > 0)
        U = basis[...].astype(float)
        assert np.abs(U.T @ U - np.eye(k)).max() < 1e-5
        representer = f["representer"]
        for name, value in (("name", "itkStandardMeshRepresenter"), ("version", "0.1"),
                            ("datasetType", "POLYGON_MESH")):
            text = representer.attrs.get_id(name)
            assert text.shape == () and text.get_type().get_strpad() == h5py.h5t.STR_NULLTERM
            assert text.get_type().get_cset() == h5py.h5t.CSET_ASCII
            assert representer.attrs[name] in (value, value.encode())
        assert representer["points"].shape == (3, n)
        assert np.array_equal(representer["points"][...].T.ravel(), mean[...])
        assert representer["cells"].dtype == "<i4"
        assert np.array_equal(representer["cells"][...].T, faces)
        scores = f["modelinfo/scores"][...].astype(float)
        assert scores.shape == (k, len(names))
        builder = f["modelinfo/modelBuilder-0"]
        found = [builder[f"dataInfo/URI_{i}"][()].decode() for i in range(len(names))]
        assert found == names
        assert (b"linearised" in builder["parameters/basis"][()]) == (space != "procrustes")
        # As Statismo has them: coefficients of U sqrt(variance), about 1 where no mode was linearised.
        if space == "procrustes":
            assert np.abs((scores**2).sum(1) / (len(names) - 1) - 1).max() < 1e-3
        scores *= np.sqrt(variance[...].astype(float))[:, None]
        average = mean[...].astype(float).reshape(n, 3)
    # Scores explain what they are scores of: near the mean the model gives its meshes back.
    shape(folder, "generate", "model.h5", "--scores-file", "scores.csv", "-o", space, "--format", "ply",
          "--ascii")
    for i, name in enumerate(names[:4]):
        wanted = read_ply(folder / space / f"{name}.ply", n) * (sizes.mean() / sizes[i])
        linear = (U @ scores[:, i]).reshape(n, 3) + average
        error = np.abs(aligned(linear, wanted) - centred(wanted)).max() / np.ptp(wanted, axis=0).max()
        print(f"{space}: {name} from its linearised scores: {100 * error:.2f} % of its extent")
        assert error < (1e-5 if space == "procrustes" else 0.05), error


def mean_of(points):
    return points.mean(axis=0)


def centred(points):
    return points - mean_of(points)


def aligned(moving, fixed):
    u, _, v = np.linalg.svd(centred(moving).T @ centred(fixed))
    turn = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ v))]) @ v
    return centred(moving) @ turn


def read_ply(path: Path, count: int):
    lines = path.read_text().split("end_header\n")[1].splitlines()
    return np.array([[float(x) for x in line.split()] for line in lines[:count]])


with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    shape(folder, "synth", "faces", "-o", "faces", "--count", "5", "--vertices", "400")
    for space in ("edge", "procrustes"):
        shape(folder, "stats", "faces", "--labels", "faces/labels.csv", "--space", space, "-o", "model.h5",
              "--force")
        shape(folder, "project", "model.h5", "faces", "-o", "scores.csv", "--force")
        shape(folder, "export", "model.h5", "--to", "statismo", "-o", "statismo.h5", "--force")
        first = (folder / "statismo.h5").read_bytes()
        shape(folder, "export", "model.h5", "--to", "statismo", "-o", "statismo.h5", "--force")
        assert (folder / "statismo.h5").read_bytes() == first, "equal models give equal bytes"
        check_statismo(folder, space)

    # SlicerMorph
    shape(folder, "export", "model.h5", "--to", "slicermorph", "-o", "slicer", "--modes", "4")
    with open(folder / "slicer/pcScores.csv", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["Sample_name", "PC 1", "PC 2", "PC 3", "PC 4"] and len(rows) == 16
    with open(folder / "slicer/outputData.csv", encoding="utf-8") as file:
        data = list(csv.reader(file))
    assert data[0][:6] == ["Sample_name", "proc_dist", "centroid", "LM 1_X", "LM 1_Y", "LM 1_Z"]
    points = np.array([[float(x) for x in row[3:]] for row in data[1:]]).reshape(15, -1, 3)
    with open(folder / "slicer/meanShape.csv", encoding="utf-8") as file:
        mean = np.array([[float(x) for x in row[1:]] for row in list(csv.reader(file))[1:]])
    with h5py.File(folder / "model.h5") as f: # meshes at the mean size, and the sizes that they had
        sizes = f["sizes"][...]
    for row, mesh, size in zip(data[1:], points, sizes):
        assert abs(float(row[2]) - np.linalg.norm(centred(mesh)) * size / sizes.mean()) < 1e-9 * float(row[2])
        assert abs(float(row[1]) - np.linalg.norm(mesh - mean)) < 1e-9 * float(row[2])
    # As SlicerMorph reads its results: eigenvalues without headings, columns whose names hold "PC " or are X, Y, Z.
    with open(folder / "slicer/eigenvalues.csv", encoding="utf-8") as file:
        values = list(csv.reader(file))
    assert [row[0] for row in values] == ["PC 1", "PC 2", "PC 3", "PC 4"]
    variances = np.array([float(row[1]) for row in values])
    with open(folder / "slicer/eigenvector.csv", encoding="utf-8") as file:
        vectors = list(csv.reader(file))
    assert vectors[0] == ["", "PC 1", "PC 2", "PC 3", "PC 4"] and vectors[1][0] == "LM 1_X" and vectors[6][0] == "LM 2_Z"
    basis = np.array([[float(x) for x in row[1:]] for row in vectors[1:]])
    assert np.abs(basis.T @ basis - np.eye(4)).max() < 1e-9
    scores = np.array([[float(x) for x in row[1:]] for row in rows[1:]])
    assert np.allclose((scores**2).sum(0) / 14, variances, rtol=0.5)  # linearised: not the same
    assert (np.diff(variances) <= 0).all() and variances[-1] > 0
    with open(folder / "slicer/meanShape.csv", encoding="utf-8") as file:
        assert next(csv.reader(file)) == ["", "X", "Y", "Z"]
    (log,) = json.loads((folder / "slicer/analysis.json").read_text())["GPALog"]
    assert log["Boas"] is False and log["ExcludedLM"] == [] and log["NumberLM"] == len(mean)
    for key in ("MeanShape", "Eigenvalues", "Eigenvectors", "OutputData", "PCScores"):
        assert (folder / "slicer" / log[key]).is_file(), key
    assert {"InputPath", "OutputPath", "Files", "LMFormat", "SemiLandmarks", "Covariates"} <= set(log)

    # ShapeWorks
    shape(folder, "export", "model.h5", "--to", "shapeworks", "-o", "works", "--modes", "2")
    project = json.loads((folder / "works/model.swproj").read_text())
    assert len(project["data"]) == 15
    for subject in project["data"]:
        assert all(isinstance(value, str) for value in subject.values())
        assert subject["group_expression"] in ("neutral", "happy", "angry")
        particles = np.loadtxt(folder / "works" / subject["world_particles_1"])
        head = (folder / "works" / subject["shape_1"]).read_bytes()[:200]
        assert b"DATASET POLYDATA" in head and f"POINTS {len(particles)} double".encode() in head
    shape(folder, "collect", "works/meshes", "-o", "back.h5")
