#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs closure_benchmark beside another implementation of Rojas 2014 and prints a table.

  closure.py BENCHMARK PEER PAIRS [--repeat N]

BENCHMARK is the program closure_benchmark. PEER is a Python program that is called as
`PEER a.obj b.obj --t 0.5 --json report.json` and reports E, iterations, rms_over_mean, max_rel and
cpu_seconds_total. PAIRS is a folder of pairs NAME_a.obj, NAME_b.obj; if there is a NAME_mid.obj, its
lengths are a second target. Both programs use one thread; times are CPU seconds without reading,
the median of N runs that alternate."""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile


ONE_THREAD = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")


def ours(benchmark, meshes, lengths):
    command = [benchmark, *meshes] + ([lengths] if lengths else [])
    return json.loads(subprocess.run(command, check=True, capture_output=True,
                                     env=ONE_THREAD).stdout)


def theirs(peer, meshes, lengths):
    with tempfile.TemporaryDirectory() as folder:
        report = os.path.join(folder, "report.json")
        command = [sys.executable, peer, *meshes, "--t", "0.5", "--json", report]
        subprocess.run(command + (["--lengths", lengths] if lengths else []), check=True,
                       env=ONE_THREAD)
        with open(report) as file:
            return json.load(file)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("benchmark")
    parser.add_argument("peer")
    parser.add_argument("pairs", type=pathlib.Path)
    parser.add_argument("--repeat", type=int, default=3)
    arguments = parser.parse_args()
    print("| target | vertices | E, peer | E, ours | ratio | steps, peer | steps, ours "
          "| edge RMS / worst, peer | edge RMS / worst, ours | CPU s, peer | CPU s, ours | times faster |")
    print("|" + "---|" * 12)
    for first in sorted(arguments.pairs.glob("*_a.obj"), key=lambda path: path.stat().st_size):
        name = first.name.removesuffix("_a.obj")
        meshes = [str(first), str(first.with_name(name + "_b.obj"))]
        middle = first.with_name(name + "_mid.obj")
        for label, lengths in [(name, None)] + ([(name + " mid", str(middle))] * middle.exists()):
            runs = [(theirs(arguments.peer, meshes, lengths), ours(arguments.benchmark, meshes, lengths))
                    for _ in range(arguments.repeat)]
            peer, own = runs[0]
            seconds = [statistics.median(run[side]["cpu_seconds_total"] for run in runs)
                       for side in (0, 1)]
            error = ["%.3f %% / %.2f %%" % (100 * r["rms_over_mean"], 100 * r["max_rel"])
                     for r in (peer, own)]
            print("| %s | %d | %.3g | %.3g | %.2f | %d | %d | %s | %s | %.2f | %.2f | %.1f |" % (
                label, peer["vertices"], peer["E"], own["E"], own["E"] / peer["E"],
                peer["iterations"], own["iterations"], *error, *seconds, seconds[0] / seconds[1]),
                flush=True)


if __name__ == "__main__":
    main()
