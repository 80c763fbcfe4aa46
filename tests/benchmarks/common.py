# SPDX-License-Identifier: MIT
"""What the scripts here share: pairs of meshes, and programs that print JSON."""
import argparse
import json
import os
import subprocess
from pathlib import Path


def call(*command, **environment):
    """The JSON that a program prints, and `peak_bytes`, the most memory that it held."""
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE,
                               env={**os.environ, **environment})
    text = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise subprocess.CalledProcessError(process.returncode, command)
    return {**json.loads(text), "peak_bytes": 1024 * usage.ru_maxrss}


def parser(description, *programs):
    """Options of a script that runs `programs` on a folder of pairs."""
    options = argparse.ArgumentParser(description=description,
                                      formatter_class=argparse.RawDescriptionHelpFormatter)
    for program in programs:
        options.add_argument(program)
    options.add_argument("pairs", type=Path)
    options.add_argument("--names")
    return options


def pairs(folder, names=None):
    """{name: [first file, second file]} of the pairs NAME_A.obj, NAME_B.obj (or _a, _b), small ones
    first; `names`, comma-separated, chooses some in that order."""
    found = {path.name[:-6]: [path, path.with_name(path.name[:-5] + chr(ord(path.name[-5]) + 1) + ".obj")]
             for path in sorted(Path(folder).glob("*_[Aa].obj"), key=lambda path: path.stat().st_size)}
    return {name: found[name] for name in names.split(",")} if names else found


def table(columns, rows=()):
    """Prints the head of a table, or all of it."""
    print(f"| {' | '.join(columns)} |\n|{'---|' * len(columns)}", flush=True)
    for cells in rows:
        row(*cells)


def row(*cells):
    print(f"| {' | '.join(map(str, cells))} |", flush=True)
