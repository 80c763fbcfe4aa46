#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs closure_benchmark beside another implementation of Rojas 2014 and prints a table.

  closure.py BENCHMARK PEER PAIRS [--names a,b,...] [--repeat N]

BENCHMARK is the program closure_benchmark. PEER is a Python program that is called as
`PEER a.obj b.obj --t 0.5 --json report.json` and reports E, iterations, rms_over_mean, max_rel and
cpu_seconds_total. PAIRS is a folder of pairs NAME_a.obj, NAME_b.obj (or _A, _B); if there is a NAME_mid.obj, its
lengths are a second target. Both programs use one thread; times are CPU seconds without reading,
the median of N runs that alternate."""

import json
import os
import statistics
import subprocess
import sys
import tempfile

from common import call, pairs, parser, row, table

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def ours(benchmark, meshes, lengths):
    return call(benchmark, *meshes, *([lengths] if lengths else []), **ONE_THREAD)


def theirs(peer, meshes, lengths):
    with tempfile.TemporaryDirectory() as folder:
        report = os.path.join(folder, "report.json")
        command = [sys.executable, peer, *meshes, "--t", "0.5", "--json", report]
        subprocess.run(command + (["--lengths", lengths] if lengths else []), check=True,
                       env={**os.environ, **ONE_THREAD})
        with open(report) as file:
            return json.load(file)


def main():
    options = parser(__doc__, "benchmark", "peer")
    options.add_argument("--repeat", type=int, default=3)
    arguments = options.parse_args()
    table(["target", "vertices", "E, peer", "E, ours", "ratio", "steps, peer", "steps, ours",
           "edge RMS / worst, peer", "edge RMS / worst, ours", "CPU s, peer", "CPU s, ours", "times faster"])
    for name, meshes in pairs(arguments.pairs, arguments.names).items():
        middle = meshes[0].with_name(name + "_mid.obj")
        for label, lengths in [(name, None)] + ([(name + " mid", middle)] if middle.exists() else []):
            runs = [(theirs(arguments.peer, meshes, lengths), ours(arguments.benchmark, meshes, lengths))
                    for _ in range(arguments.repeat)]
            peer, own = runs[0]
            seconds = [statistics.median(run[side]["cpu_seconds_total"] for run in runs)
                       for side in (0, 1)]
            error = ["%.3f %% / %.2f %%" % (100 * r["rms_over_mean"], 100 * r["max_rel"])
                     for r in (peer, own)]
            row(label, peer["vertices"], f"{peer['E']:.3g}", f"{own['E']:.3g}", f"{own['E'] / peer['E']:.2f}",
                peer["iterations"], own["iterations"], *error, *(f"{time:.2f}" for time in seconds),
                f"{seconds[0] / seconds[1]:.1f}")


if __name__ == "__main__":
    main()
