# SPDX-License-Identifier: MIT
"""What the campaigns share: a folder with inputs, runs of the program, and the last line."""

import contextlib
import os
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PATIENCE = 120  # seconds after which a run counts as hanging, on a busy machine


def arguments(usage, count):
    """The program and the number of trials: `campaign PROGRAM [COUNT]`."""
    if len(sys.argv) not in (2, 3):
        sys.exit(f"usage: {usage} PROGRAM [COUNT]")
    return os.path.abspath(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) == 3 else count


@contextlib.contextmanager
def arena(program):
    """A folder with four meshes, a collection, a model and two single meshes; work goes on there."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        os.mkdir("out")
        made = [
            ["synth", "arm", "--count", "4", "-o", "meshes", "--vertices", "200"],
            ["collect", "meshes", "-o", "collection.h5"],
            ["stats", "collection.h5", "-o", "model.h5"],
        ]
        for command in made:
            subprocess.run([program, *command, "--quiet"], check=True, capture_output=True)
        yield sorted(str(path) for path in Path("meshes").glob("*.ply"))
        os.chdir("/")


def run(command, **options):
    """(exit code or minus the signal, last line of stderr); a run that hangs has the code 'hang'."""
    try:
        done = subprocess.run(command, capture_output=True, timeout=PATIENCE, **options)
    except subprocess.TimeoutExpired:
        return "hang", ""
    return done.returncode, (done.stderr.decode(errors="replace").strip().splitlines() or [""])[-1]


def left_over(folder="out"):
    """Files that a run should not have left."""
    return [str(p) for p in Path(folder).rglob("*") if p.name.startswith(".") or ".tmp" in p.name]


def finish(findings, summary):
    """Prints at most ten findings and the summary; the exit code tells whether there are any."""
    for finding in findings[:10]:
        print("finding:", finding)
    print(f"{summary}, {len(findings)} findings")
    sys.exit(1 if findings else 0)


__all__ = ["Path", "arena", "arguments", "finish", "left_over", "random", "run", "time"]
