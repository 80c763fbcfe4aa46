# SPDX-License-Identifier: MIT
"""MeshLab reads our PLY, OBJ, OFF and STL files, values and colours of PLY too, and we read what it writes."""
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

from ecosystem import needs, read_ascii_ply, shape, skip

NAME = "Ecosystem.Meshlab"
np, h5py = needs(NAME, "numpy", "h5py")
if shutil.which("meshlabserver") is None:
    skip(NAME, "MeshLab is not there (meshlab)")
if shutil.which("xvfb-run") is None:
    skip(NAME, "MeshLab needs a display (xvfb and xauth)")


def run_meshlab(folder: Path, source: str, target: str, *options: str) -> str:
    """What it says; the target is there if it succeeded."""
    done = subprocess.run(
        ["xvfb-run", "-a", "meshlabserver", "-i", source, "-o", target, *options], cwd=folder,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300,
        env={**os.environ, "XDG_RUNTIME_DIR": str(folder), "HOME": str(folder)})
    if "GLEW initialization failed" in done.stdout:
        skip(NAME, "MeshLab found no OpenGL (libgl1-mesa-dri)")
    return str(done.stdout)


def through_meshlab(folder: Path, source: str, target: str, *options: str) -> None:
    said = run_meshlab(folder, source, target, *options)
    assert (folder / target).exists(), said


def read_meshlab_ply(path: Path):
    """Columns of the vertices by name, and faces, of its binary PLY."""
    data = path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    lines = head.decode().splitlines()
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex"))
    kinds = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4"}
    fields = [(line.split()[2], kinds[line.split()[1]]) for line in lines
              if line.startswith("property") and "list" not in line]
    vertices = np.frombuffer(body, np.dtype(fields), count)
    faces = np.frombuffer(body[vertices.nbytes :], np.dtype([("n", "u1"), ("v", "<i4", 3)]))
    return vertices, faces["v"]


with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    shape(folder, "synth", "arm", "-o", "arm", "--vertices", "300")
    common = ["interpolate", "arm", "--frames", "3", "--quiet"]
    shape(folder, *common, "-o", "text", "--ascii", "--residuals", "--colors")
    V, F = read_ascii_ply(folder / "text/frame_0001.ply")
    extent = np.ptp(V)
    # Debian 12's MeshLab is built with assertions, of which its OBJ reader breaks one on any file.
    (folder / "triangle.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    said = run_meshlab(folder, "triangle.obj", "triangle.ply")
    reads_obj = (folder / "triangle.ply").exists()
    if not reads_obj:
        assert "import_obj.h" in said, said
        print("MeshLab's OBJ reader aborts on a single triangle: OBJ is not compared")
    for ending in ("ply", "obj", "off", "stl") if reads_obj else ("ply", "off", "stl"):
        shape(folder, *common, "-o", ending, "--format", ending)
        through_meshlab(folder, f"{ending}/frame_0001.{ending}", f"from_{ending}.ply")
        vertices, faces = read_meshlab_ply(folder / f"from_{ending}.ply")
        points = np.stack([vertices[axis] for axis in "xyz"], axis=1)
        assert faces.shape == F.shape, ending
        if ending == "stl":
            assert np.abs(points[faces] - V[F]).max() < 1e-6 * extent
        else:
            assert np.array_equal(faces, F) and np.abs(points - V).max() < 1e-6 * extent, ending
        # And back: what it writes in that format.
        through_meshlab(folder, "ply/frame_0001.ply", f"back.{ending}")
        shape(folder, "collect", f"back.{ending}", "-o", f"{ending}.h5", "--quiet")
        with h5py.File(folder / f"{ending}.h5") as file:
            assert np.abs(file["points"][0] - V).max() < 1e-5 * extent or ending == "stl", ending
            assert file["topology/faces"].shape == F.shape
        print(f"MeshLab reads .{ending}: {len(points)} vertices, {len(faces)} faces; and we read its")
    through_meshlab(folder, "text/residuals/frame_0001_residuals.ply", "values.ply", "-m", "vq", "vc")
    lines = (folder / "text/residuals/frame_0001_residuals.ply").read_text().split("end_header\n")
    names = [line.split()[2] for line in lines[0].splitlines() if line.startswith("property") and "list" not in line]
    ours = np.array([[float(x) for x in line.split()] for line in lines[1].splitlines()[: len(V)]])
    shown, _ = read_meshlab_ply(folder / "values.ply")
    quality = ours[:, names.index("quality")]
    assert np.ptp(quality) > 0 and np.allclose(shown["quality"], quality, rtol=1e-5)
    for colour in ("red", "green", "blue"):
        assert np.array_equal(shown[colour], ours[:, names.index(colour)]), colour
    print("MeshLab shows our values (quality) and colours")
