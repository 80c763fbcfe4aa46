#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the table of docs/performance.md: half-way blends of pairs of meshes, embedded by `shape`.

embedding_table.py SHAPE PAIRS [--peer PROGRAM] [--names a,b,...] [--repeat N]

SHAPE is the program; PAIRS a folder of NAME_A.obj and NAME_B.obj. PROGRAM is another implementation
of Winkler 2010, called as `PROGRAM A B --t 0.5 --repeat N` on one thread; times are given as multiples
of its median pose. Ours use two threads; each time is the least of N runs of the program, without
set-up, errors are those of the written positions.
"""
import argparse
import json
import subprocess
import tempfile
from pathlib import Path

METHODS = {"fine": [], "preview": ["--quality", "preview"], "multiscale": ["--method", "multiscale"]}


def call(*command):
    return json.loads(subprocess.run(list(map(str, command)), check=True, capture_output=True).stdout)


def embed(program, pair, options, repeat):
    with tempfile.TemporaryDirectory() as folder:
        runs = [call(program, "interpolate", *pair, "--weights", "0.5,0.5", "-o",
                     Path(folder, f"{i}.ply"), "--json", "--threads", 2, *options)["embeddings"][0]
                for i in range(repeat)]
    return min(runs, key=lambda run: run["seconds"])


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shape")
    parser.add_argument("pairs", type=Path)
    parser.add_argument("--peer")
    parser.add_argument("--names")
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    names = options.names.split(",") if options.names else sorted(
        path.name[:-6] for path in options.pairs.glob("*_A.obj"))
    print("| pair | vertices | method | edge RMS | worst edge | drift RMS | steps | ms | x peer |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name in names:
        pair = [options.pairs / f"{name}_{side}.obj" for side in "AB"]
        unit = None
        if options.peer:
            pose = call(options.peer, *pair, "--t", 0.5, "--repeat", 9)["poses"][0]
            unit = pose["total_ms"]
            print(f"| {name} | | peer | | {100 * pose['edge_rel_error']['max']:.2f} % | | "
                  f"| {unit:.1f} | 1 |")
        for method, arguments in METHODS.items():
            run = embed(options.shape, pair, arguments, options.repeat)
            milliseconds = 1e3 * run["seconds"]
            ratio = f"{milliseconds / unit:.2f}" if unit else ""
            print(f"| {name} | {run['vertices']} | {method} | {100 * run['edge_rms']:.4f} % "
                  f"| {100 * run['edge_max']:.2f} % | {run['dihedral_rms_deg']:.3f}° "
                  f"| {run['iterations']} | {milliseconds:.1f} | {ratio} |", flush=True)


if __name__ == "__main__":
    main()
