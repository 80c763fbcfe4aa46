# SPDX-License-Identifier: MIT
"""The commands of the pages for users run, block by block in a folder for each page: those of the shell, and
those of R where it is installed.

A block of ```sh runs as a whole, one of ```r too; blocks without a language are for the eye.
"""
import csv
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from ecosystem import PROGRAM, SOURCE

PAGES = sys.argv[1:] or ["tutorial", "r", "slicer", "shapeworks", "blender"]


def run(folder, language, text):
    if language == "r":
        return subprocess.run(["Rscript", "--vanilla", "-"], input=text, cwd=folder, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return subprocess.run(["bash", "-euc", text], cwd=folder, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT,
                          env={**os.environ, "PATH": f"{Path(PROGRAM).parent}:{os.environ['PATH']}"})


for page in PAGES:
    text = (SOURCE / f"docs/{page}.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^```(sh|r)\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    assert blocks, f"docs/{page}.md has no commands"
    with tempfile.TemporaryDirectory() as name:
        count = 0
        r_lines = ""
        for language, lines in blocks:
            if language == "r":
                if shutil.which("Rscript") is None:
                    print(f"{page}.md: the lines of R did not run, R is not there")
                    continue
                # Blocks of R are one session.
                r_lines += lines
                done = run(name, language, r_lines)
            else:
                done = run(name, language, lines)
            assert done.returncode == 0, f"docs/{page}.md:\n{lines}\n{done.stdout}"
            count += len(lines.splitlines())
        if page == "r" and r_lines and shutil.which("Rscript"):  # one session, and no name is used for two things
            with open(Path(name) / "scores.csv", encoding="utf-8") as file:
                largest = max(float(row["pc2"]) for row in csv.DictReader(file))
            with open(Path(name) / "wanted.csv", encoding="utf-8") as file:
                (wanted,) = csv.DictReader(file)
            assert abs(float(wanted["pc2"]) - largest) <= 1e-12, (wanted, largest)
        if page == "tutorial":  # the figures that it promises
            for figure in ("fitted/fit.svg", "quality.svg", "scores.svg", "modes.svg", "distances.svg", "means.svg",
                           "smile.glb", "tables/read.R"):
                assert (Path(name) / figure).stat().st_size > 1000 or figure.endswith(".R"), figure
            assert (Path(name) / "fitted/fit.csv").read_text().count(",good,") >= 10
        print(f"docs/{page}.md: {len(blocks)} blocks, {count} lines")
