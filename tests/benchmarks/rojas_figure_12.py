#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws Figure 12 of Rojas et al. (2014): errors of every frame between two meshes, by method.

rojas_figure_12.py SHAPE BENT STRAIGHT OUT.png [--frames N] [--work FOLDER]

Left the RMS edge error over the mean length, right the worst relative edge error, per cent, over N
frames (100). Runs that were interrupted go on. Prints the maxima, the largest step from frame to frame
over the diagonal of the bounding box, and at how many frames `dihedral` is below the others.
"""
import argparse
import json
import subprocess
from pathlib import Path

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from interpolation_figures import steps

COLOURS = {"closure": "black", "multiscale": "tab:red", "dihedral": "tab:blue"}


def errors(shape, meshes, method, frames, work):
    report = work / f"{method}_{frames}.json"
    if not report.exists():
        command = [shape, "interpolate", *meshes, "-o", work / f"{method}_{frames}", "--frames", frames,
                   "--method", method, "--json", "--resume"]
        text = subprocess.run(list(map(str, command)), check=True, stdout=subprocess.PIPE, text=True).stdout
        report.write_text(text)
    embeddings = json.loads(report.read_text())["embeddings"]
    return 100 * np.array([[mesh["edge_rms"], mesh["edge_max"]] for mesh in embeddings])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("shape", "bent", "straight", "out"):
        parser.add_argument(name)
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--work", type=Path, default=Path("rojas_figure_12"))
    options = parser.parse_args()
    options.work.mkdir(exist_ok=True)

    t = np.linspace(0, 1, options.frames)
    meshes = [options.bent, options.straight]
    results = {method: errors(options.shape, meshes, method, options.frames, options.work)
               for method in COLOURS}
    print("| method | edge RMS | worst edge | step | frames above dihedral, RMS | worst edge |")
    print("|---|---|---|---|---|---|")
    for method, found in results.items():
        above = (found > results["dihedral"])[1:-1].sum(axis=0)
        beside = ["", ""] if method == "dihedral" else [f"{count} of {options.frames - 2}" for count in above]
        step = steps(sorted((options.work / f"{method}_{options.frames}").glob("*.ply"))).max()
        print(f"| {method} | {found[:, 0].max():.2f} % | {found[:, 1].max():.1f} % | {100 * step:.1f} % "
              f"| {beside[0]} | {beside[1]} |")

    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), constrained_layout=True)
    for column, (axis, title) in enumerate(zip(axes, ("edge RMS / mean length [%]", "worst edge [%]"))):
        for method, found in results.items():
            axis.plot(t, found[:, column], color=COLOURS[method], label=method, linewidth=1.2)
        axis.set(title=title, xlabel="t, bent to straight", yscale="log", xlim=(0, 1))
        axis.grid(alpha=0.3)
        floor = min(found[1:-1, column].min() for found in results.values())
        axis.set_ylim(bottom=0.5 * floor)
    axes[0].legend()
    figure.savefig(options.out, dpi=110)


if __name__ == "__main__":
    main()
