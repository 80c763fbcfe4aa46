# SPDX-License-Identifier: MIT
"""mypy passes the package, strictly, and the examples; and the stubs name what the module has."""
import importlib.util
import subprocess
import sys
import tempfile
from pathlib import Path

from ecosystem import SOURCE, skip

from libshape import _core

stubs = (SOURCE / "tools/python/libshape/_core.pyi").read_text(encoding="utf-8")
for name in vars(_core):
    if not name.startswith("_") and name != "OtherError":
        assert f"class {name}" in stubs or f"def {name}(" in stubs, f"_core.pyi lacks {name}"

if importlib.util.find_spec("mypy") is None:
    skip("Python.Types", "mypy is not there")
with tempfile.TemporaryDirectory() as cache:
    for paths in ([SOURCE / "tools/python/libshape"], sorted((SOURCE / "docs/examples").glob("*.py"))):
        for path in paths:
            done = subprocess.run(
                [sys.executable, "-m", "mypy", "--config-file", str(SOURCE / "pyproject.toml"), "--cache-dir", cache,
                 str(path)],
                cwd=SOURCE / "tools/python", stdout=subprocess.PIPE, text=True,
            )
            assert done.returncode == 0, done.stdout
