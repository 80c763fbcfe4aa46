# SPDX-License-Identifier: MIT
"""assimp counts the vertices and faces of what we write, and we read what it exports."""
import re
import shutil
import tempfile
from pathlib import Path

from ecosystem import command, shape, skip

if shutil.which("assimp") is None:
    skip("Ecosystem.Assimp", "assimp is not there (assimp-utils)")
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    shape(folder, "synth", "helix", "-o", "helix", "--count", "1", "--vertices", "300")
    file = str(sorted((folder / "helix").glob("*.ply"))[0])
    surface = shape(folder, "check", file)
    vertices = int(re.search(r"([\d,]+) vert", surface).group(1).replace(",", ""))
    faces = int(re.search(r"([\d,]+) faces", surface).group(1).replace(",", ""))
    for ending in ("ply", "obj", "off", "stl", "glb"):
        shape(folder, "interpolate", file, file, "--weights", "1,0", "-o", f"x.{ending}", "--quiet")
        told = "\n".join(command(folder, "assimp", "info", f"x.{ending}"))
        assert int(re.search(r"Faces:\s+(\d+)", told).group(1)) == faces, told
        count = int(re.search(r"Vertices:\s+(\d+)", told).group(1))
        assert count in (vertices, 3 * faces), told  # assimp may split corners
    for ending in ("stl", "glb", "ply"):
        command(folder, "assimp", "export", "x.off", f"theirs.{ending}")
        told = shape(folder, "check", f"theirs.{ending}")
        print(ending, told.splitlines()[0])
