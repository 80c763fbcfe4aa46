# SPDX-License-Identifier: MIT
"""The scripts in docs/examples run and write what they say."""
import tempfile
from pathlib import Path

from ecosystem import SOURCE, python

WRITTEN = {
    "morphometrics_study.py": ["scores.csv", "mode1_-2.ply", "mode1_2.ply"],
    "expression_transfer.py": ["smile_0.5.ply", "smile_1.5.ply"],
    "blender_animation.py": ["morph.glb"],
}
scripts = sorted((SOURCE / "docs/examples").glob("*.py"))
assert [script.name for script in scripts] == sorted(WRITTEN), scripts
for script in scripts:
    with tempfile.TemporaryDirectory() as name:
        done = python(Path(name), "-W", "error", str(script))
        assert done.returncode == 0, f"{script.name}: {done.stdout}"
        for file in WRITTEN[script.name]:
            assert (Path(name) / file).stat().st_size > 0, file
        print(f"{script.name}:\n{done.stdout}")
