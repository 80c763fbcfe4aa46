# SPDX-License-Identifier: MIT
"""What the tests in Python share."""
import importlib
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, List, NoReturn, Tuple

SOURCE = Path(os.environ["SHAPE_SOURCE"])
PROGRAM = os.environ["SHAPE_PROGRAM"]


def skip(test: str, reason: str) -> NoReturn:
    """Ends the test as skipped, in the words that tests/list_skipped reads."""
    print(f"{test}: Skipped\n{reason}\n")
    sys.exit(77)


def needs(test: str, *modules: str) -> List[Any]:
    """The modules; the test ends as skipped if one is not there."""
    found = []
    for module in modules:
        try:
            found.append(importlib.import_module(module))
        except ImportError:
            skip(test, f"Python has no {module} (python3-{'vtk9' if module == 'vtk' else module})")
    return found


def read_ascii_ply(path: Path) -> Tuple[Any, Any]:
    """(V, F) of a PLY file of libshape as text."""
    import numpy as np

    head, _, body = path.read_text().partition("end_header\n")
    count = int(head.split("element vertex ")[1].split()[0])
    lines = body.splitlines()
    points = np.array([[float(x) for x in line.split()[:3]] for line in lines[:count]])
    return points, np.array([[int(x) for x in line.split()[1:4]] for line in lines[count:]])


def shape(folder: Path, *arguments: str) -> str:
    """What the program prints."""
    done = subprocess.run(
        [PROGRAM, *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def python(folder: Path, *arguments: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [sys.executable, *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def command(folder: Path, *arguments: str) -> List[str]:
    """Lines that a command prints; what it says stands in the failure."""
    done = subprocess.run(
        arguments, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    assert done.returncode == 0, done.stdout
    return done.stdout.splitlines()
