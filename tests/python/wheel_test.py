# SPDX-License-Identifier: MIT
"""The wheel is built without a network, and installs without one into a fresh venv.

The module is taken from this build (SHAPE_PYTHON_MODULE); SHAPE_BUILD_WHEEL_ALONE=1 lets the wheel's own
build compile it.
"""
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

from ecosystem import SOURCE, command, skip

for module in ("build", "wheel", "setuptools", "ensurepip"):
    if importlib.util.find_spec(module) is None:
        skip("Python.Wheel", f"Python has no {module}")
if os.environ.get("SHAPE_BUILD_WHEEL_ALONE"):
    del os.environ["SHAPE_PYTHON_MODULE"]
del os.environ["PYTHONPATH"]  # the package of the build
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    source = folder / "source"
    source.mkdir()
    for part in ("pyproject.toml", "setup.py", "README.md", "LICENSE", "CMakeLists.txt", "cmake", "libshape",
                 "tools"):
        (shutil.copytree if (SOURCE / part).is_dir() else shutil.copy)(SOURCE / part, source / part)
    command(source, sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", name)
    (wheel,) = folder.glob("libshape-*.whl")
    venv.create(folder / "venv", system_site_packages=True, with_pip=True)
    python = str(folder / "venv/bin/python")
    command(folder, python, "-m", "pip", "install", "--no-index", "--no-deps", "--quiet", str(wheel))
    lines = command(
        folder, python, "-c",
        "import libshape as ls, os; print(ls.__file__); print(ls.__version__);"
        "print(os.path.exists(os.path.dirname(ls.__file__) + '/py.typed'));"
        "print(ls.synthetic('arm', vertices=200).model().decode([0])[0].name)",
    )
    assert str(folder / "venv") in lines[0], lines
    assert lines[1:] == [wheel.name.split("-")[1], "True", "scores"], lines
    print(f"{wheel.name}: {wheel.stat().st_size / 1e6:.1f} MB")
