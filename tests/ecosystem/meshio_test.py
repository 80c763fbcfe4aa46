# SPDX-License-Identifier: MIT
"""meshio reads what we write, with the order of vertices and faces and every scalar, and the other way round."""
import tempfile
from pathlib import Path

from ecosystem import needs, read_ascii_ply, shape

meshio, np = needs("Ecosystem.Meshio", "meshio", "numpy")
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    shape(folder, "synth", "helix", "-o", "helix", "--count", "1", "--vertices", "300")
    files = sorted((folder / "helix").glob("*.ply"))[:2]
    ours = {}
    for ending in ("ply", "obj", "off", "stl"):
        shape(folder, "interpolate", *map(str, files), "--frames", "2", "-o", ending, "--format", ending,
              "--residuals", "--quiet", *(["--ascii"] if ending == "ply" else []))
        ours[ending] = folder / ending / f"frame_0001.{ending}"
    V, F = read_ascii_ply(ours["ply"])
    for ending, path in ours.items():
        mesh = meshio.read(path)
        if ending == "stl":
            assert np.allclose(mesh.points[mesh.cells_dict["triangle"]], V[F], atol=1e-6)
        else:
            assert np.array_equal(mesh.points, V), ending
            assert np.array_equal(mesh.cells_dict["triangle"], F), ending
    shown = meshio.read(folder / "ply/residuals/frame_0001_residuals.ply")
    assert {"edge_error", "dihedral_drift", "quality"} <= set(shown.point_data), shown.point_data
    # And back.
    for ending, options in (("ply", {}), ("ply", {"binary": False}), ("obj", {}), ("off", {}), ("stl", {})):
        written = folder / f"meshio.{ending}"
        try:
            meshio.write(written, meshio.Mesh(V, [("triangle", F)]), **options)
        except Exception as error:  # a form that this meshio does not have
            print("not written:", ending, options, error)
            continue
        shape(folder, "draw", str(written), "-o", "x.svg", "--force")
        if ending != "stl":
            shape(folder, "interpolate", str(written), str(ours["ply"]), "--weights", "1,0", "-o", "back.ply",
                  "--ascii", "--force", "--quiet")
            points, faces = read_ascii_ply(folder / "back.ply")
            assert np.array_equal(faces, F) and np.abs(points - V).max() < 1e-5 * np.ptp(V)
