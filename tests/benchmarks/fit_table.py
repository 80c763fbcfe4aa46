#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""fit_table.py BUILD SCANS WORK: fits the scans with known answers, prints a table of errors.

SCANS holds a folder for each case with template.ply, scan.ply, truth.ply and landmarks.csv (columns name, vertex,
x, y, z). Needs python3-numpy.
"""

import json
import pathlib
import re
import resource
import subprocess
import sys

import numpy


def read_ply(path):
    """Vertices and faces of a binary little-endian PLY file of triangles."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode()
    count = {name: int(n) for name, n in re.findall(r"element (\w+) (\d+)", header)}
    names = {"double": "<f8", "float": "<f4", "float64": "<f8", "float32": "<f4"}
    vertex = re.search(r"element vertex.*?(?=element face)", header, re.S).group()
    fields = [(n, names[t]) for t, n in re.findall(r"property (\w+) (\w+)\n", vertex)]
    vertices = numpy.frombuffer(data, fields, count["vertex"], end)
    face = [("n", "u1"), ("corners", "<i4", 3)]
    faces = numpy.frombuffer(data, face, count["face"], end + vertices.nbytes)["corners"]
    return numpy.stack([vertices[a].astype(float) for a in "xyz"], 1), faces


def errors(fit, truth, faces):
    diagonal = numpy.linalg.norm(numpy.ptp(truth, axis=0))
    rms = numpy.sqrt(((fit - truth) ** 2).sum(1).mean()) / diagonal
    edges = numpy.unique(numpy.sort(numpy.concatenate([faces[:, [0, 1]], faces[:, [1, 2]],
                                                       faces[:, [2, 0]]]), 1), axis=0)
    length = lambda x: numpy.linalg.norm(x[edges[:, 0]] - x[edges[:, 1]], axis=1)
    edge = numpy.sqrt(((length(fit) - length(truth)) ** 2).mean()) / length(truth).mean()
    normal = lambda x: numpy.cross(x[faces[:, 1]] - x[faces[:, 0]], x[faces[:, 2]] - x[faces[:, 0]])
    flips = int(((normal(fit) * normal(truth)).sum(1) < 0).sum())
    return 100 * rms, 100 * edge, flips


def main():
    build, scans, work = map(pathlib.Path, sys.argv[1:4])
    print("| case | landmarks | RMS | edges | flipped | status | seconds |")
    print("|---|---|---|---|---|---|---|")
    for case in sorted(p for p in scans.iterdir() if p.is_dir()):
        truth, faces = read_ply(case / "truth.ply")
        for marks in ([], ["--landmarks", case / "landmarks.csv"]):
            out = work / (case.name + ("_landmarks" if marks else ""))
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
            run = subprocess.run([build / "tools/shape", "fit", case / "template.ply",
                                  case / "scan.ply", "-o", out, "--force", "--json",
                                  "--keep-failed", "--threads", "1", *marks],
                                 check=True, capture_output=True)
            seconds = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
            status = json.loads(run.stdout)["scans"][0]["status"]
            rms, edge, flips = errors(read_ply(out / "scan.ply")[0], truth, faces)
            print(f"| {case.name} | {8 if marks else 0} | {rms:.2f} | {edge:.1f} | {flips} | {status} "
                  f"| {seconds:.1f} |", flush=True)


if __name__ == "__main__":
    main()
