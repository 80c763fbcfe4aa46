#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""False alarms and detections of `shape groups --within` and `shape regress --within` where people were scanned several
times: 200 made-up collections for each design. Prints the table of docs/groups.md.

Usage: repeated_scans.py SHAPE [SETS]      (SHAPE: the program; about 5 minutes)
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

SHAPE = sys.argv[1]
SETS = int(sys.argv[2]) if len(sys.argv) > 2 else 200


def sphere():
    """An octahedron, divided twice: 66 vertices."""
    vertices = [np.array(v, float) for v in ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1))]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    for _ in range(2):
        middles = {}

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(vertices)
                m = vertices[a] + vertices[b]
                vertices.append(m / np.linalg.norm(m))
            return middles[key]

        faces = [t for a, b, c in faces for ab, bc, ca in [(middle(a, b), middle(b, c), middle(c, a))]
                 for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))]
    return np.array(vertices), faces


VERTICES, FACES = sphere()
HEAD = (f"ply\nformat ascii 1.0\nelement vertex {len(VERTICES)}\nproperty double x\nproperty double y\nproperty double z\n"
        f"element face {len(FACES)}\nproperty list uchar int vertex_indices\nend_header\n")
TAIL = "".join("3 %d %d %d\n" % f for f in FACES)


def change(rng, amount):
    """A smooth change of the radius, of mean 0."""
    radius = np.zeros(len(VERTICES))
    for _ in range(5):
        centre = rng.normal(size=3)
        centre /= np.linalg.norm(centre)
        radius += rng.normal() * amount * np.exp(-3 * ((VERTICES - centre) ** 2).sum(1))
    return 50 * VERTICES * radius[:, None]


def p_value(folder, rows, arguments):
    """rows: name, vertices, cells of the table behind it."""
    meshes = folder / "meshes"
    meshes.mkdir(exist_ok=True)
    for old in meshes.iterdir():
        old.unlink()
    lines = ["mesh,person,state,age"]
    for name, points, cells in rows:
        body = "".join("%.9g %.9g %.9g\n" % tuple(p) for p in points)
        (meshes / f"{name}.ply").write_text(HEAD + body + TAIL)
        lines.append(",".join([name, *map(str, cells)]))
    (folder / "labels.csv").write_text("\n".join(lines) + "\n")
    run = subprocess.run([SHAPE, *arguments, str(meshes), "--labels", str(folder / "labels.csv"), "--within", "person",
                          "-o", str(folder / "out.csv"), "--force", "--permutations", "199", "--json"],
                         capture_output=True, text=True, check=True)
    figures = json.loads(run.stdout)
    return figures.get("overall", figures.get("together"))["p_value"]


def states(rng, people, scans, own, common):
    effect = change(np.random.default_rng(1), common)
    rows = []
    for p in range(people):
        self = 50 * VERTICES * [1, 1.2, .8] + change(rng, .05)
        for s, state in enumerate("ab"):
            shape = self + change(rng, own) + s * effect
            rows += [(f"p{p}{state}{k}", shape + rng.normal(size=shape.shape) * .3, (p, state, s)) for k in range(scans)]
    return rows


def visits(rng, people, ages, scans, own, common):
    effect = change(np.random.default_rng(1), common)
    rows = []
    for p in range(people):
        self = 50 * VERTICES * [1, 1.2, .8] + change(rng, .05)
        growth = change(rng, own) + effect
        first = rng.integers(20, 60)
        for a in range(ages):
            shape = self + growth * (2 * a / (ages - 1) - 1)
            rows += [(f"p{p}v{a}k{k}", shape + rng.normal(size=shape.shape) * .3, (p, a, first + a)) for k in range(scans)]
    return rows


GROUPS = ["groups", "--by", "state", "--bootstrap", "39"]
REGRESS = ["regress", "--on", "age"]
DESIGNS = [
    ("`groups`: 8 people, 2 states, 5 scans, own changes", GROUPS, lambda r: states(r, 8, 5, .02, 0)),
    ("15 people, 2 states, 3 scans, own changes", GROUPS, lambda r: states(r, 15, 3, .02, 0)),
    ("8 people, 2 states, 1 scan, own changes", GROUPS, lambda r: states(r, 8, 1, .02, 0)),
    ("8 people, 2 states, 5 scans, own and a common change", GROUPS, lambda r: states(r, 8, 5, .02, .03)),
    ("8 people, 2 states, 1 scan, a common change alone", GROUPS, lambda r: states(r, 8, 1, 0, .015)),
    ("8 people, 2 states, 5 scans, a common change alone", GROUPS, lambda r: states(r, 8, 5, 0, .015)),
    ("`regress`: 10 people, 5 visits, own growth", REGRESS, lambda r: visits(r, 10, 5, 1, .02, 0)),
    ("8 people, 2 ages, 5 scans, own growth", REGRESS, lambda r: visits(r, 8, 2, 5, .02, 0)),
    ("10 people, 5 visits, no growth", REGRESS, lambda r: visits(r, 10, 5, 1, 0, 0)),
    ("10 people, 2 visits, common growth alone", REGRESS, lambda r: visits(r, 10, 2, 1, 0, .006)),
    ("10 people, 5 visits, common growth alone", REGRESS, lambda r: visits(r, 10, 5, 1, 0, .006)),
]

with tempfile.TemporaryDirectory() as name:
    for words, arguments, make in DESIGNS:
        found = [p_value(Path(name), make(np.random.default_rng(k)), arguments) <= .05 for k in range(SETS)]
        print(f"| {words} | {100 * np.mean(found):.0f} |", flush=True)
