#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the table of docs/statistics.md: time and memory of every analysis of a collection.

memory_table.py SHAPE MESHES [COMMAND ...]

SHAPE is the program, MESHES a folder of meshes with labels.csv (columns subject, expression). Memory is
the largest resident set less that of `shape --version`; the size of the collection that of its positions,
edge lengths and dihedral angles. Needs /usr/bin/time.
"""
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

STATES = ["--pair-by", "subject", "--from", "expression=neutral", "--to", "expression=happy"]
COMMANDS = {
    "collect": ["collect", "MESHES", "--labels", "MESHES/labels.csv", "-o", "faces.h5"],
    "stats": ["stats", "faces.h5", "-o", "model.h5"],
    "stats, procrustes": ["stats", "faces.h5", "-o", "procrustes.h5", "--space", "procrustes"],
    "stats, bootstrap": ["stats", "faces.h5", "-o", "b.h5", "--modes", "10", "--bootstrap", "1000",
                         "--within", "subject"],
    "stats, dihedrals": ["stats", "faces.h5", "-o", "d.h5", "--with-dihedrals", "0.1"],
    "project": ["project", "model.h5", "faces.h5", "-o", "scores.csv"],
    "project, procrustes": ["project", "procrustes.h5", "faces.h5", "-o", "s.csv"],
    "generate": ["generate", "model.h5", "--mode", "1", "--sigma", "-2:2:5", "-o", "mode1/"],
    "distance": ["distance", "faces.h5", "-o", "d.csv", "--cluster", "c.csv", "--mds", "m.csv"],
    "distance, procrustes": ["distance", "faces.h5", "-o", "p.csv", "--metric", "procrustes"],
    "groups": ["groups", "faces.h5", "--by", "expression", "--within", "subject", "-o", "groups.csv",
               "--means", "means/"],
    "classify": ["classify", "faces.h5", "--by", "expression", "--leave-out", "subject", "-o", "t.csv"],
    "classify, procrustes": ["classify", "faces.h5", "--by", "expression", "--leave-out", "subject",
                             "-o", "u.csv", "--space", "procrustes"],
    "regress": ["regress", "faces.h5", "--on", "size", "-o", "size.csv"],
    "regress, corrected": ["regress", "faces.h5", "--on", "size", "-o", "size2.csv", "--corrected",
                           "corrected/", "--quality", "preview"],
    "remove": ["remove", "faces.h5", "--modes", "1", "-o", "removed/", "--quality", "preview"],
    "difference": ["difference", "faces.h5", *STATES, "-o", "difference.h5", "--effects", "effects.ply",
                   "--apply", "--mesh", "happy.ply"],
    "quality": ["quality", "faces.h5", "-o", "quality.csv", "--leave-out", "subject"],
}


def run(command, folder):
    """Seconds and the largest resident set [MB] of a run."""
    done = subprocess.run(["/usr/bin/time", "-v", *command], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(done.stderr)
    clock = re.search(r"Elapsed.*: (?:(\d+):)?(\d+):([\d.]+)", done.stderr)
    seconds = 3600 * int(clock[1] or 0) + 60 * int(clock[2]) + float(clock[3])
    return seconds, int(re.search(r"Maximum resident.*: (\d+)", done.stderr)[1]) / 1024


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    program, meshes = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        size = None
        _, program_alone = run([program, "--version"], folder)
        print("| command | seconds | MB | over the collection |\n|---|---|---|---|")
        for name, arguments in COMMANDS.items():
            if sys.argv[3:] and name not in ("collect", "stats", "stats, procrustes", *sys.argv[3:]):
                continue
            words = [word.replace("MESHES", str(meshes)) for word in arguments]
            seconds, memory = run([program, *words, "--force", "--quiet"], folder)
            memory -= program_alone
            if size is None:
                info = json.loads(subprocess.run([program, "info", "faces.h5", "--json"], cwd=folder,
                                                 check=True, capture_output=True).stdout)
                size = 8 * info["meshes"] * (3 * info["vertices"] + 2 * info["edges"]) / 2**20
            print(f"| `{name}` | {seconds:.1f} | {memory:.0f} | {memory / size:.2f} |", flush=True)
        print(f"\nThe collection: {size:.0f} MB.")


if __name__ == "__main__":
    main()
