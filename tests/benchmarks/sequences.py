#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the table of docs/embedding.md on sequences: jumps, largest steps and errors along paths, and along modes of models.

  sequences.py SHAPE DATA [--frames 61,121] [--names 'arm;hand, mode 1;...'] [--beside OTHER]

SHAPE is the program, DATA the folder of the real datasets; OTHER is another build of the program, whose figures go before
those of SHAPE. Steps are those of libshape/embedding/sequence_jumps.h, each over the median of the up to eight around it (at
least 0.0002 and 0.02 degrees); seconds are of the processor, with one thread.
"""
import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path

import numpy

from common import row, table
from interpolation_figures import aligned, diagonal, read_ply

GESTURES = ["fist_0", "point", "victory", "hook", "thumb_in", "flat_bend", "fist_5"]
PATHS = {"arm": ("mh_arm", ["elbow_000", "elbow_1000"]), "hand": ("mh_hand", ["fist_0", "fist_5"]),
         "body": ("mh_body_poses", ["rest", "lunge"]), "walk": ("mh_body_poses", ["walk_00", "walk_06"]),
         "face": ("ict_faces_full", ["s000_neutral", "s000_happy"]), "gestures": ("mh_hand", GESTURES),
         "arm 100-25": ("mh_arm", ["elbow_1000", "elbow_250"]), "kick": ("mh_body_poses", ["squat", "kick"]),
         "twist": ("mh_body_poses", ["twist", "tpose"]), "bow": ("mh_body_poses", ["bow", "arms_up"])}

MODES = {"arm, mode 1": ("mh_arm", 1), "arm, mode 2": ("mh_arm", 2), "hand, mode 1": ("mh_hand", 1),
         "hand, mode 2": ("mh_hand", 2), "bodies, mode 1": ("mh_body_poses", 1),
         "hand with positions, mode 2": ("mh_hand", 2, "--with-positions", "5"),
         "faces with positions, mode 1": ("ict_faces600", 1, "--with-positions", "5")}


def hinges(faces):
    """Corners a, b, c, d of the hinge of every interior edge, and its two faces."""
    opposite = {(f[k], f[(k + 1) % 3]): (f[(k + 2) % 3], i) for i, f in enumerate(faces) for k in range(3)}
    found = [(a, b, c, opposite[b, a][0], i, opposite[b, a][1]) for (a, b), (c, i) in opposite.items()
             if a < b and (b, a) in opposite]
    return numpy.array(found).T


def angles(points, corners):
    a, b, c, d = (points[corner] for corner in corners[:4])
    left, right = numpy.cross(b - a, c - a), numpy.cross(d - a, b - a)
    sine = numpy.einsum("ij,ij->i", b - a, numpy.cross(left, right))
    return numpy.arctan2(sine, numpy.linalg.norm(b - a, axis=1) * numpy.einsum("ij,ij->i", left, right))


def step(before, after, faces, corners):
    """Displacement over the diagonal after the best rigid motion, and bending."""
    way = numpy.linalg.norm(aligned(after, before) - before, axis=1).max() / diagonal(before)
    f = before[faces]
    area = numpy.linalg.norm(numpy.cross(f[:, 1] - f[:, 0], f[:, 2] - f[:, 0]), axis=1)
    weight = area[corners[4]] + area[corners[5]]
    change = numpy.angle(numpy.exp(1j * (angles(after, corners) - angles(before, corners))))
    return way, numpy.sqrt(weight @ change**2 / weight.sum())


def ratio(steps, least):
    """The largest step over the median of those nearby."""
    around = lambda k: [steps[j] for j in range(max(0, k - 4), min(len(steps), k + 5)) if j != k]
    return max(s / max(numpy.median(around(k)), least) for k, s in enumerate(steps))


def figures(shape, make, order):
    """make: arguments of a run; order: sorts its files."""
    with tempfile.TemporaryDirectory() as folder:
        start = os.times()
        text = subprocess.run([shape, *make, "-o", f"{folder}/", "--threads", "1", "--json"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=True).stdout
        seconds = os.times().children_user - start.children_user
        report = json.loads(text)
        made = [read_ply(file) for file in sorted(Path(folder).glob("*.ply"), key=order)]
    corners = hinges(made[0][1])
    steps = [step(a, b, faces, corners) for (a, faces), (b, _) in zip(made, made[1:])]
    embedded = report["embeddings"]
    return (f"{len(report['jumps'])}", f"{ratio([s[0] for s in steps], 2e-4):.1f}, {ratio([s[1] for s in steps], 4e-4):.1f}",
            f"{100 * max(e['edge_rms'] for e in embedded):.4f} %", f"{100 * max(e['edge_max'] for e in embedded):.2f} %",
            f"{max(e['dihedral_rms_deg'] for e in embedded):.2f}°", f"{seconds:.1f}")


def runs(name, frames, data, shape, work):
    """Arguments of the run, and the key that sorts its files; models are made in the folder `work`."""
    if name in PATHS:
        folder, files = PATHS[name]
        return ["interpolate", *(str(data / folder / f"{file}.ply") for file in files), "--frames", str(frames)], None
    folder, mode, *space = MODES[name]
    model = Path(work) / f"{folder}{len(space)}.h5"
    if not model.exists():
        subprocess.run([shape, "stats", str(data / folder), *space, "-o", str(model), "--quiet"], check=True)
    sigma = lambda file: float(file.stem.split("_")[1])
    return ["generate", str(model), "--mode", str(mode), "--sigma", f"-1:1:{frames}"], sigma


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("shape")
    options.add_argument("data", type=Path)
    options.add_argument("--frames", default="61,121")
    options.add_argument("--names", default=";".join([*PATHS, *MODES]))
    options.add_argument("--beside")
    chosen = options.parse_args()
    table(["path", "frames", "jumps", "largest step: displacement, bending", "edge RMS", "worst edge", "drift RMS", "seconds"])
    with tempfile.TemporaryDirectory() as work:
        for name in chosen.names.split(";"):
            for frames in map(int, chosen.frames.split(",")):
                run = runs(name, frames, chosen.data, chosen.shape, work)
                found = [figures(program, *run) for program in (chosen.beside, chosen.shape) if program]
                row(name, frames, *(" → ".join(pair) for pair in zip(*found)))


if __name__ == "__main__":
    main()
