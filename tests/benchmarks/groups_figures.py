#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes the figures and pictures of docs/groups.md, and some of the 600 faces in other pages.

groups_figures.py SHAPE DATA OUT [CASE ...]

SHAPE is the program, DATA the folder of the real datasets, OUT a folder for meshes and pictures. Cases:
tests, transfer, walk, modes, quality; all by default.
"""
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from interpolation_figures import aligned, diagonal, read_ply, run_cases

LEARNT = [f"s{i:03d}" for i in range(7)]
UNSEEN = [f"s{i:03d}" for i in range(7, 12)]
NEUTRAL_TO_HAPPY = ["--pair-by", "subject", "--from", "expression=neutral", "--to", "expression=happy"]


class Study:
    def __init__(self, program, data, out):
        self.program, self.data, self.out = (Path(path).resolve() for path in (program, data, out))
        self.out.mkdir(exist_ok=True)

    def shape(self, *arguments):
        command = [self.program, *map(str, arguments), "--json", "--force", "--quiet"]
        done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=self.out)
        return json.loads(done.stdout)

    def draw(self, picture, meshes, *options):
        self.shape("draw", *meshes, "-o", picture, *options)

    def renamed(self, folder, names, suffix):
        """Meshes of a folder under names that differ from those of the inputs, as a picture needs."""
        return [(self.out / folder / f"{name}.ply").replace(self.out / folder / f"{name}{suffix}.ply")
                for name in names]

    def faces(self):
        """The 600 faces as a collection."""
        folder = self.data / "ict_faces600"
        self.shape("collect", folder, "--labels", folder / "labels.csv", "-o", "faces.h5")
        return "faces.h5"


def rms(a, b):
    """RMS distance of corresponding vertices after rigid alignment."""
    return np.sqrt(np.square(aligned(a, b) - b).sum(axis=1).mean())


def percent(values, digits=2):
    return " | ".join(f"{100 * value:.{digits}f}" for value in values)


def rotation_onto(points, onto):
    """The rotation of rows that fits points to others, both about their centroids."""
    u, _, vt = np.linalg.svd((points - points.mean(axis=0)).T @ (onto - onto.mean(axis=0)))
    return u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))]) @ vt


def step_length(points, rest):
    """How far one foot is before the other, over the height, with the trunk turned as in `rest` (+z is ahead)."""
    height = np.ptp(rest[:, 1])
    share = (rest[:, 1] - rest[:, 1].min()) / height
    trunk = (share > 0.55) & (share < 0.75) & (abs(rest[:, 0]) < 0.12 * height)
    turned = points @ rotation_onto(points[trunk], rest[trunk])
    feet = [turned[(share < 0.04) & (side * rest[:, 0] > 0)].mean(axis=0) for side in (1, -1)]
    return abs(feet[0][2] - feet[1][2]) / height


def unit_sum_sides(points, faces):
    """The sides of every triangle, over the sum of all edge lengths."""
    ends = np.stack([faces, np.roll(faces, 1, axis=1)], axis=2)
    sides = np.linalg.norm(points[ends[:, :, 0]] - points[ends[:, :, 1]], axis=2)
    _, once = np.unique(np.sort(ends.reshape(-1, 2), axis=1), axis=0, return_index=True)
    return sides / sides.reshape(-1)[once].sum()


def tests(study):
    """Groups, classification, size."""
    faces = study.faces()
    for within in ([], ["--within", "subject"]):
        made = study.shape("groups", faces, "--by", "expression", *within, "-o", "groups.csv")
        print(f"groups {within}: F {made['overall']['f']:.3f}, R2 {made['overall']['r_squared']:.3f}, "
              f"p {made['overall']['p_value']:.3f}")
        for pair in made["pairs"]:
            print(f"  {pair['first']} - {pair['second']}: {1e3 * pair['distance']:.3f} "
                  f"± {1e3 * pair['radius']:.3f}")
    print("| modes | edge | Procrustes |\n|---|---|---|")
    for modes in (5, 10, 20, 40):
        right = []
        for space in ("edge", "procrustes"):
            study.shape("classify", faces, "--by", "expression", "--leave-out", "subject", "--modes", modes,
                        "--space", space, "-o", f"confusion_{space}_{modes}.csv")
            rows = [line.split(",") for line in
                    (study.out / f"confusion_{space}_{modes}.csv").read_text().splitlines()]
            right.append(sum(int(row[i + 1]) for i, row in enumerate(rows[1:])))
        print(f"| {modes} | {right[0]} | {right[1]} |")
    for space in ("edge", "procrustes"):
        print(space, (study.out / f"confusion_{space}_5.csv").read_text(), sep="\n")
    test = study.shape("regress", faces, "--on", "size", "-o", "size.csv")["covariates"][0]
    print(f"size: R2 {test['r_squared']:.3f}, F {test['f']:.3f}, p {test['p_value']:.3f}")


def broken_faces(study):
    """How many triangle inequalities break, by the coordinates in which the difference is taken."""
    meshes = {}
    for subject in LEARNT + UNSEEN:
        for state in ("neutral", "happy"):
            file = study.data / "ict_faces_full" / f"{subject}_{state}.ply"
            meshes[subject, state] = unit_sum_sides(*read_ply(file))
    maps = {"plain": (lambda x: x, lambda y: y), "squared": (np.square, lambda y: np.sqrt(np.maximum(y, 0))),
            "log": (np.log, np.exp)}
    slack = {s: 1 - 2 * meshes[s, "neutral"].max(axis=1) / meshes[s, "neutral"].sum(axis=1) for s in UNSEEN}
    for name, (forward, back) in maps.items():
        smile = np.mean([forward(meshes[s, "happy"]) - forward(meshes[s, "neutral"]) for s in LEARNT], axis=0)
        targets = [back(forward(meshes[s, "neutral"]) + smile) for s in UNSEEN]
        broken = [2 * t.max(axis=1) >= t.sum(axis=1) for t in targets]
        print(f"| faces that break, {name} lengths | {' | '.join(str(b.sum()) for b in broken)} |")
        before = np.concatenate([slack[s][b] for s, b in zip(UNSEEN, broken)])
        print(f"  slack of their inequality in the neutral face, median: {np.median(before):.3f}; of all faces: "
              f"{np.median(np.concatenate(list(slack.values()))):.3f}")


def transfer(study):
    """The mean smile of seven people, laid onto five others."""
    folder = study.data / "ict_faces_full"
    only = [word for s in LEARNT for word in ("--only", f"subject={s}")]
    study.shape("difference", folder, "--labels", folder / "labels.csv", *only, *NEUTRAL_TO_HAPPY, "-o",
                "smile.h5")
    neutral = [folder / f"{s}_neutral.ply" for s in UNSEEN]
    happy = [folder / f"{s}_happy.ply" for s in UNSEEN]
    made = study.shape("difference", "--load", "smile.h5", "--onto", *neutral, "--mesh", "happy/")
    ours = study.renamed("happy", [f"{s}_neutral" for s in UNSEEN], "_transferred")
    study.draw("groups_transfer.png", [*neutral, *ours, *happy], "--columns", 5, "--cell", 80, "--view", "0,0")
    own = [read_ply(mesh)[0] for mesh in happy]
    print(f"| | {' | '.join(UNSEEN)} |\n|{'---|' * 6}")
    for name, meshes in (("neutral", neutral), ("transferred", ours)):
        print(f"| {name} | {percent(rms(read_ply(m)[0], o) / diagonal(o) for m, o in zip(meshes, own))} |")
    reports = made["embeddings"]
    print(f"| edge RMS [%] | {percent(r['edge_rms'] for r in reports)} |")
    for field, name in (("edge_max", "worst edge"), ("edge_p999", "99.9 % of the edges within")):
        print(f"| {name} [%] | {percent((r[field] for r in reports), 1)} |")
    broken_faces(study)


def walk(study):
    """A walk without its pose."""
    folder = study.data / "mh_body_poses"
    common = [folder, "--labels", folder / "labels.csv"]
    names = [f"walk_{i:02d}" for i in range(12)]
    frames = [folder / f"{name}.ply" for name in names]
    study.shape("remove", *common, "--only", "pose=walk", "--modes", 4, "-o", "standing/")
    model = study.shape("stats", *frames, "-o", "walk.h5")
    report = study.shape("generate", "walk.h5", "--mean", "-o", "mean.ply")["embeddings"][0]
    mean = read_ply(study.out / "mean.ply")[0]
    height = np.ptp(mean, axis=0).max()
    before = [rms(read_ply(frame)[0], mean) / height for frame in frames]
    standing = study.renamed("standing", names, "_standing")
    after = [rms(read_ply(mesh)[0], mean) / height for mesh in standing]
    print(f"variance of 4 modes {100 * model['modes'][3]['cumulative']:.2f} %; RMS to the mean, of the height: "
          f"{100 * min(before):.1f} to {100 * max(before):.1f} % before, {100 * min(after):.2f} to "
          f"{100 * max(after):.2f} % after; mean: edge RMS {100 * report['edge_rms']:.2f} %, "
          f"worst {100 * report['edge_max']:.1f} %")
    study.draw("groups_walk.png", [*frames[::3], *standing[::3], "mean.ply"], "--columns", 4, "--cell", 110, "--view", "60,5")
    study.shape("stats", *common, "-o", "poses.h5")
    rest = read_ply(folder / "rest.ply")[0]
    for modes in (20, 6):
        study.shape("remove", *frames, "--model", "poses.h5", "--modes", modes, "--like", folder / "rest.ply",
                    "-o", f"like_{modes}/")
        off = [rms(read_ply(study.out / f"like_{modes}" / f"{name}.ply")[0], rest) / height for name in names]
        print(f"like rest, {modes} modes: {100 * min(off):.2f} to {100 * max(off):.2f} % of the height")
    was = [rms(read_ply(frame)[0], rest) / height for frame in frames]
    print(f"before: {100 * min(was):.1f} to {100 * max(was):.1f} %")
    steps = [step_length(read_ply(frame)[0], rest) for frame in frames]
    print(f"step: {100 * min(steps):.0f} to {100 * max(steps):.0f} % of the height; of the mean: "
          f"{100 * step_length(mean, rest):.1f} %")


def modes(study):
    """The first modes of 600 faces, from -2 to 2 standard deviations."""
    study.shape("stats", study.faces(), "-o", "model.h5", "--modes", 20)
    meshes = []
    for mode in (1, 2, 3):
        reports = study.shape("generate", "model.h5", "--mode", mode, "--sigma", "-2:2:5", "-o",
                              f"mode{mode}/")["embeddings"]
        meshes += [f"mode{mode}/{report['name']}.ply" for report in reports]
        for report in reports:
            print(f"{report['name']}: {report['status']}, edge RMS {100 * report['edge_rms']:.3f} %, worst "
                  f"{100 * report['edge_max']:.2f} %, {report['seconds']:.2f} s")
    study.draw("faces600.png", meshes, "--columns", 5, "--cell", 75, "--view", "0,0")


def quality(study):
    """What models of the 600 faces are worth (docs/statistics.md)."""
    faces = study.faces()
    made = {space: study.shape("quality", faces, "--leave-out", "subject", "--space", space, "-o", "q.csv")
            for space in ("edge", "procrustes")}
    for space, figures in made.items():
        print(f"{space}: {figures['infeasible']} of {figures['decoded']} infeasible")
    for i, count in enumerate(made["edge"]["modes"]):
        for space, q in made.items():
            print(f"| {count} | {space} | {100 * q['compactness'][i]:.1f} % | {q['generalisation_vertex'][i]:.3f} | "
                  f"{100 * q['generalisation_edge'][i]:.1f} % | {q['specificity_vertex'][i]:.3f} | "
                  f"{100 * q['specificity_edge'][i]:.1f} % |")


CASES = [tests, transfer, walk, modes, quality]


if __name__ == "__main__":
    run_cases(CASES, Study, __doc__)
