#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the tables of docs/embedding.md on contact: single blends and frames with and without --avoid-contact.

  contact.py SHAPE DATA [--names arm,hand,...] [--frames 61]

SHAPE is the program, DATA the folder of the real datasets. Blends are those at 0.25, 0.5 and 0.75; with --frames the path itself.
Pairs of faces: those of both inputs; those of the meshes that no input has, before -> after, summed up. Errors are the largest of the
meshes; time is of the processor, with one thread, as a ratio.
"""
import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path

from common import row, table

PAIRS = {"arm": ("mh_arm", "elbow_000", "elbow_1000"), "arm 75": ("mh_arm", "elbow_000", "elbow_750"),
         "hand 1-3": ("mh_hand", "fist_1", "fist_3"), "hand 2-4": ("mh_hand", "fist_2", "fist_4"),
         "hand 3-5": ("mh_hand", "fist_3", "fist_5"), "thumb-hook": ("mh_hand", "thumb_in", "hook"),
         "point-victory": ("mh_hand", "point", "victory"),
         "lunge-squat": ("mh_body_poses", "lunge", "squat"), "kick": ("mh_body_poses", "squat", "kick"),
         "arms": ("mh_body_poses", "arms_down", "arms_up"), "twist": ("mh_body_poses", "arms_down", "twist"),
         "walk": ("mh_body_poses", "walk_03", "walk_09"),
         "face": ("ict_faces_full", "s000_neutral", "s000_happy"),
         "two faces": ("ict_faces_full", "s003_neutral", "s007_angry")}


def run(shape, meshes, choice, *options):
    """The JSON of `shape interpolate`, and its processor time."""
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen([shape, "interpolate", *meshes, *choice, "-o", Path(folder) / "out", "--json",
                                    "--threads", "1", *options], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        text = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            raise SystemExit(f"{' '.join(map(str, process.args))} failed")
        return json.loads(text), usage.ru_utime


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("shape")
    parser.add_argument("data", type=Path)
    parser.add_argument("--names")
    parser.add_argument("--frames", type=int)
    arguments = parser.parse_args()
    weights = [text for w in ("0.75,0.25", "0.5,0.5", "0.25,0.75") for text in ("--weights", w)]
    choice = ["--frames", str(arguments.frames)] if arguments.frames else weights
    table(["pair", "pairs in inputs", "new pairs", "meshes with some", "edge RMS", "worst edge", "jumps", "time"])
    for name in arguments.names.split(",") if arguments.names else PAIRS:
        folder, *names = PAIRS[name]
        meshes = [arguments.data / folder / f"{mesh}.ply" for mesh in names]
        (ends, _), plain, apart = (run(arguments.shape, meshes, ["--weights", "1,0", "--weights", "0,1"]),
                                   run(arguments.shape, meshes, choice),
                                   run(arguments.shape, meshes, choice, "--avoid-contact"))
        inputs = ", ".join(str(mesh["self_intersections"]) for mesh in ends["embeddings"])
        total = lambda made: sum(mesh["new_self_intersections"] for mesh in made[0]["embeddings"])
        worst = lambda made, field: max(mesh[field] for mesh in made[0]["embeddings"])
        having = lambda made: sum(mesh["new_self_intersections"] > 0 for mesh in made[0]["embeddings"])
        row(name, inputs, f"{total(plain)} → {total(apart)}", f"{having(plain)} → {having(apart)}",
            f"{worst(plain, 'edge_rms'):.3%} → {worst(apart, 'edge_rms'):.3%}",
            f"{worst(plain, 'edge_max'):.2%} → {worst(apart, 'edge_max'):.2%}",
            f"{len(plain[0].get('jumps', []))} → {len(apart[0].get('jumps', []))}", f"{apart[1] / plain[1]:.2f}")


if __name__ == "__main__":
    main()
