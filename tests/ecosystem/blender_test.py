# SPDX-License-Identifier: MIT
"""Blender: the add-on's shape keys, and what Blender's own importers read, evaluated against our meshes."""
import os
import shutil
import tempfile
from pathlib import Path

from ecosystem import SOURCE, command, shape, skip

if shutil.which("blender") is None:
    skip("Ecosystem.Blender", "Blender is not there (blender, 300 MB with what it needs; .ci/run does without)")
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    os.environ["HOME"] = os.environ["XDG_RUNTIME_DIR"] = str(folder)
    shape(folder, "synth", "faces", "-o", "faces", "--count", "4", "--vertices", "400")
    shape(folder, "stats", "faces", "-o", "model.h5", "--quiet")
    shape(folder, "collect", "faces", "-o", "faces.h5", "--quiet")
    shape(folder, "synth", "arm", "-o", "arm", "--vertices", "300", "--quiet")
    arms = [str(file) for file in sorted((folder / "arm").glob("*.ply"))]
    common = ["interpolate", *arms, "--frames", "26", "--quiet"]
    shape(folder, *common, "-o", "morph.glb", "--glb-tolerance", "1e-4", "--fps", "24")
    shape(folder, *common, "-o", "frames")
    for ending in ("ply", "obj", "stl"):
        shape(folder, *common[:-3], "--frames", "2", "--quiet", "-o", ending, "--format", ending)
    lines = command(
        folder, "blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python",
        str(SOURCE / "tests/ecosystem/blender_inside.py"), "--", str(SOURCE / "tools/blender"),
    )
    reason = [line for line in lines if line.startswith("SKIP ")]
    if reason:
        skip("Ecosystem.Blender", reason[0][5:])
    found = [line for line in lines if line.startswith("Blender: ")]
    print(*found, sep="\n")
    assert found and found[-1] == "Blender: all done", lines
    # The script from a shell, as its first lines say.
    lines = command(
        folder, "blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python",
        str(SOURCE / "tools/blender/import_libshape.py"), "--", "morph.glb",
    )
    assert any(line.startswith("morph: ") and "shape keys" in line for line in lines), lines
