#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""space_table.py PROGRAM DATA [WEIGHT...]: how well models of four spaces generalise, as a table.

For each collection of real meshes in DATA: mean distance of meshes left out from their reconstructions, vertices after
alignment [unit of the data] and, in brackets, RMS of edge lengths, by `shape quality` with 25 meshes left out. WEIGHT:
those of --with-positions; 5 if there is none.
"""

import csv
import pathlib
import subprocess
import sys
import tempfile

COLLECTIONS = {"mh_hand": 13, "mh_body_poses": 19, "vertebrae": 7, "ict_faces_full": 20, "ict_faces600": 50}


def main():
    program, data = sys.argv[1], pathlib.Path(sys.argv[2])
    spaces = {"edge": [], **{f"edge, positions {w}": ["--with-positions", w] for w in sys.argv[3:] or ["5"]},
              "procrustes": ["--space", "procrustes"]}
    print("| collection | modes | " + " | ".join(spaces) + " |\n|---|---|" + "---|" * len(spaces))
    with tempfile.TemporaryDirectory() as work:
        table = pathlib.Path(work) / "quality.csv"
        for name, modes in COLLECTIONS.items():
            cells = []
            for options in spaces.values():
                subprocess.run([program, "quality", data / name, "--modes", str(modes), "--samples", "1", "--quiet",
                                "--force", "-o", table, *options], check=True, stdout=subprocess.DEVNULL)
                row = next(csv.DictReader(table.open()))
                cells.append(f"{float(row['generalisation_vertex']):.4g} ({100 * float(row['generalisation_edge']):.3g} %)")
            print(f"| {name} | {modes} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
