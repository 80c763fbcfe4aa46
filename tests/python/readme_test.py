# SPDX-License-Identifier: MIT
"""The Python lines of the README and of docs/python.md run, in a folder with the meshes that they name."""
import re
import tempfile
from pathlib import Path

from ecosystem import SOURCE, python, shape

for page in ("README.md", "docs/python.md"):
    text = (SOURCE / page).read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    blocks = [block for block in blocks if "libshape" in block]
    assert blocks, f"{page} has no Python lines"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        shape(folder, "synth", "faces", "-o", "faces", "--count", "12", "--vertices", "400")
        (folder / "faces/labels.csv").rename(folder / "labels.csv")
        shape(folder, "synth", "faces", "-o", "scans", "--count", "1", "--vertices", "700", "--seed", "5")
        (folder / "scans/s000_happy.ply").rename(folder / "scan.ply")
        # A build without the page is a build: its line alone may fail, and says why.
        program = "\n".join(blocks).replace(
            'm.explorer("page.html")',
            'try:\n    m.explorer("page.html")\nexcept ValueError as error:\n'
            '    assert "without the page" in str(error), error\n',
        )
        (folder / "lines.py").write_text(program, encoding="utf-8")
        done = python(folder, "-W", "error", "lines.py")
        assert done.returncode == 0, f"{page}: {done.stdout}"
        print(f"{page}: {len(blocks)} blocks ran")
