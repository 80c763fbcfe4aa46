#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the tables of docs/multiscale.md.

multiscale_table.py BENCHMARK PAIRS [--peer PROGRAM] [--names a,b,...] [--seeds N] [--repeat N]

BENCHMARK is the program multiscale_benchmark; PAIRS a folder of NAME_A.obj and NAME_B.obj. PROGRAM is
another implementation, called as `PROGRAM A B --t 0.5 --repeat N --seed S`, with the benchmark's key
names in its JSON. Medians over the seeds; one thread, and two for the last column.
"""
import statistics

from common import call, pairs, parser, table

PAPER = [("cylinder", 312, 2.94, 59.71, 1.17, 18.78, 5.21, 25.16),
         ("helix", 1212, 12.75, 243.76, 3.98, 84.11, 24.66, 112.75),
         ("lion", 5000, 127.55, 1248.22, 16.05, 365.99, 122.45, 504.49),
         ("horse", 8431, 300.41, 2140.96, 72.45, 544.01, 205.93, 822.39),
         ("elephant", 39969, 5975.31, 11954.33, 126.15, 2632.40, 1327.28, 4085.83),
         ("armadillo", 165954, 90106.71, 54339.12, 570.07, 11273.22, 7105.04, 18948.33)]
PHASES = ["splitting_ms", "factorizing_ms", "interpolation_ms", "registration_ms", "blending_ms",
          "total_ms"]


def peer_runs(program, pair, options):
    for seed in range(1, options.seeds + 1):
        report = call(program, *pair, "--t", 0.5, "--repeat", options.repeat, "--seed", seed)
        yield {**report, **report["poses"][0]}


def median(runs, *keys):
    def value(run):
        for key in keys:
            run = run[key]
        return run
    return statistics.median(map(value, runs))


def main():
    arguments = parser(__doc__, "benchmark")
    arguments.add_argument("--peer")
    arguments.add_argument("--seeds", type=int, default=5)
    arguments.add_argument("--repeat", type=int, default=15, help="poses a seed")
    options = arguments.parse_args()

    times, errors = [], []
    for name, pair in pairs(options.pairs, options.names).items():
        ours = [options.benchmark, *pair, "--seeds", options.seeds, "--repeat", options.repeat]
        report = call(*ours)
        two = call(*ours, "--threads", 2)
        sources = {"ours": report["runs"]}
        if options.peer:
            sources["peer"] = list(peer_runs(options.peer, pair, options))
        for source, runs in sources.items():
            own = source == "ours"
            fastest = min(run["fastest_total_ms"] for run in runs)
            speed_up = fastest / min(run["fastest_total_ms"] for run in two["runs"])
            times.append([f"{name}, {source}", report["vertices"], *(f"{median(runs, key):.2f}" for key in PHASES),
                          f"{fastest:.2f}", f"{speed_up:.2f}" if own else ""])
            drift = [median(runs, "dihedral_dev_deg", key) for key in ("q50", "q99", "q999")]
            errors.append([f"{name}, {source}",
                           *(f"{median(runs, 'edge_rel_error', key):.2e}" for key in ("rms", "q99", "q999")),
                           " / ".join(f"{angle:.2g}" for angle in drift),
                           f"{max(max(run['ends']) for run in runs):.1e}" if own else ""])

    columns = ["splitting", "factorising", "interpolation", "registration", "blending", "pose"]
    table(["mesh", "vertices", *columns], PAPER)
    print()
    table(["pair", "vertices", *columns, "fastest", "x with 2 threads"], times)
    print()
    table(["pair", "edge rms", "99 %", "99.9 %", "dihedral 50 / 99 / 99.9 %, deg", "inputs"], errors)


if __name__ == "__main__":
    main()
