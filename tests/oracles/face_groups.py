#!/usr/bin/python3
"""face_groups.py FOLDER_OF_ICT_FACES600

Prints the figures of 600 real faces (three expressions of 200 people) in tests/statistics: F and R^2 of
group_comparison_test.cpp, expressions crossed with people and alone, and the confusion of
cross_validation_test.cpp, where each person in turn is left out and five components and linear discriminants
are learnt anew from the others. Reads the meshes itself; needs numpy."""
import csv
import sys
from pathlib import Path

import numpy as np


def read_ply(path):
    content = path.read_bytes()
    header, body = content.split(b"end_header\n", 1)
    words = [line.split() for line in header.decode().splitlines()]
    assert ["format", "binary_little_endian", "1.0"] in words, path
    count = {w[1]: int(w[2]) for w in words if w[0] == "element"}
    kinds = [w[1] for w in words if w[0] == "property" and w[1] != "list"]
    number = np.dtype({"float": "<f4", "double": "<f8"}[kinds[0]])
    assert kinds == [kinds[0]] * 3, path
    points = np.frombuffer(body, number, 3 * count["vertex"]).reshape(-1, 3).astype(float)
    face = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
    faces = np.frombuffer(body, face, count["face"], offset=points.size * number.itemsize)
    assert (faces["count"] == 3).all(), path
    return points, faces["corners"]


folder = Path(sys.argv[1])
labels = {row["mesh"]: row for row in csv.DictReader(open(folder / "labels.csv"))}
names = sorted(labels)
edges = None
rows = []
for name in names:
    points, faces = read_ply(folder / f"{Path(name).stem}.ply")
    if edges is None:
        sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        edges = np.unique(sides, axis=0)
    lengths = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    rows.append(lengths / lengths.sum())
X = np.array(rows) - np.mean(rows, axis=0)
expressions = np.array([labels[n]["expression"] for n in names])
subjects = np.array([labels[n]["subject"] for n in names])
kinds, people = np.unique(expressions), np.unique(subjects)


def indicators(values):
    return (values[:, None] == np.unique(values)[None, :]).astype(float)


def explained(design):
    """Sum of squares of the least squares fit."""
    q, r = np.linalg.qr(design)
    return ((q.T @ X) ** 2).sum()


n, total = len(names), (X**2).sum()
of_expressions = explained(indicators(expressions))
freedom = len(kinds) - 1
print("alone: F", of_expressions / freedom / ((total - of_expressions) / (n - len(kinds))),
      "R^2", of_expressions / total)
of_people = explained(indicators(subjects))
both = of_people + of_expressions  # every person has every expression once: orthogonal
print("crossed with people: F", of_expressions / freedom / ((total - both) / (n - len(people) - freedom)))

u, s, _ = np.linalg.svd(X, full_matrices=False)
Y = u * s  # all components: the same distances in fewer coordinates
confusion = np.zeros((3, 3), int)
for person in people:
    out = subjects == person
    mean = Y[~out].mean(0)
    _, _, axes = np.linalg.svd(Y[~out] - mean, full_matrices=False)
    train, test = (Y[~out] - mean) @ axes[:5].T, (Y[out] - mean) @ axes[:5].T
    group = expressions[~out]
    centres = np.array([train[group == k].mean(0) for k in kinds])
    within = train - centres[np.searchsorted(kinds, group)]
    inverse = np.linalg.inv(within.T @ within / (len(train) - len(kinds)))
    prior = np.log([np.mean(group == k) for k in kinds])
    for x, true in zip(test, expressions[out]):
        score = [prior[k] - 0.5 * (x - c) @ inverse @ (x - c) for k, c in enumerate(centres)]
        confusion[np.searchsorted(kinds, true), int(np.argmax(score))] += 1
print(*kinds)
print(confusion)
