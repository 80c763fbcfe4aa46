#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws Figure 12 of Rojas et al. (2014): errors of every frame between two meshes, by method.

rojas_figure_12.py SHAPE BENT STRAIGHT OUT.png [--frames N] [--closure-frames N] [--work FOLDER]

Left the RMS edge error over the mean length, right the worst relative edge error, per cent, over N
frames (100). The method closure takes seconds to minutes a frame, so it may have fewer, equally spaced.
Runs that were interrupted go on. Prints the maxima, and where `dihedral` is not below the others.
"""
import argparse
import json
import subprocess
from pathlib import Path

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

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
    parser.add_argument("--closure-frames", type=int)
    parser.add_argument("--work", type=Path, default=Path("rojas_figure_12"))
    options = parser.parse_args()
    options.work.mkdir(exist_ok=True)

    results = {}
    for method in ("multiscale", "dihedral", "closure"):
        count = (options.closure_frames if method == "closure" else None) or options.frames
        found = errors(options.shape, [options.bent, options.straight], method, count, options.work)
        results[method] = np.linspace(0, 1, count), found
        print(f"{method}: {count} frames, largest edge RMS {found[:, 0].max():.3f} %, "
              f"largest worst edge {found[:, 1].max():.2f} %")

    t, ours = results["dihedral"]
    for method in ("multiscale", "closure"):
        places, found = results[method]
        inner = (places > 0) & (places < 1)
        for column, name in enumerate(("edge RMS", "worst edge")):
            above = inner & (np.interp(places, t, ours[:, column]) >= found[:, column])
            print(f"{name} of dihedral not below {method} at {above.sum()} of {inner.sum()} frames: "
                  f"t = {np.round(places[above], 2).tolist()}")

    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), constrained_layout=True)
    for column, (axis, title) in enumerate(zip(axes, ("edge RMS / mean length [%]", "worst edge [%]"))):
        for method, (places, found) in results.items():
            axis.plot(places, found[:, column], color=COLOURS[method], label=method, linewidth=1.2)
        axis.set(title=title, xlabel="t, bent to straight", yscale="log", xlim=(0, 1))
        axis.grid(alpha=0.3)
        floor = min(found[1:-1, column].min() for _, found in results.values())
        axis.set_ylim(bottom=0.5 * floor)
    axes[0].legend()
    figure.savefig(options.out, dpi=110)


if __name__ == "__main__":
    main()
