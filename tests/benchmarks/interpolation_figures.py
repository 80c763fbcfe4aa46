#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes the figures and pictures of docs/interpolation.md.

interpolation_figures.py SHAPE DATA OUT [CASE ...]

SHAPE is the program, DATA the folder of the real datasets, OUT a folder for meshes and pictures; what is
there already is not made again, and interrupted sequences go on. Cases: all by default.
"""
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

METHODS = ["dihedral", "multiscale"]


class Study:
    def __init__(self, shape, data, out):
        self.program, self.data, self.out = (Path(path).resolve() for path in (shape, data, out))
        self.out.mkdir(exist_ok=True)

    def shape(self, *arguments):
        command = [self.program, *map(str, arguments)]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, cwd=self.out).stdout

    def synth(self, name, *arguments, folder=None):
        folder = folder or name
        if not (self.out / folder).exists():
            self.shape("synth", name, "-o", folder, "--quiet", *arguments)
        return sorted((self.out / folder).glob("*.ply"))

    def arms(self):
        """Four poses, straight to bent."""
        meshes = {mesh.stem: mesh for mesh in self.synth("arm", "--count", 4)}
        return [meshes[name] for name in ("arm_straight", "arm_0001", "arm_0002", "arm_bent")]

    def interpolate(self, name, meshes, *arguments):
        """Figures of the run and its frames; the output is the folder `name`."""
        report = self.out / f"{name}.json"
        if not report.exists():
            text = self.shape("interpolate", *meshes, "-o", f"{name}/", "--json", "--resume", *arguments)
            report.write_text(text)
        return json.loads(report.read_text()), sorted((self.out / name).glob("*.ply"))

    def draw(self, picture, meshes, *arguments):
        self.shape("draw", *meshes, "-o", picture, "--sequence", "--force", "--quiet", *arguments)


def read_ply(path):
    content = Path(path).read_bytes()
    start = content.index(b"end_header\n") + 11
    lines = [line.split() for line in content[:start].decode().splitlines()]
    counts = {line[1]: int(line[2]) for line in lines if line[0] == "element"}
    real = {"double": "<f8", "float": "<f4"}[next(line[1] for line in lines if line[0] == "property")]
    points = np.frombuffer(content, real, 3 * counts["vertex"], start).reshape(-1, 3)
    face = np.dtype([("count", "u1"), ("corners", "<i4", 3)])
    faces = np.frombuffer(content, face, counts["face"], start + points.nbytes)["corners"]
    return points.astype(float), faces


def diagonal(points):
    return np.linalg.norm(points.max(axis=0) - points.min(axis=0))


def aligned(points, onto):
    a, b = points - points.mean(axis=0), onto - onto.mean(axis=0)
    u, _, vt = np.linalg.svd(a.T @ b)
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt))])
    return a @ (u @ flip @ vt) + onto.mean(axis=0)


def distance(frame, mesh):
    """Largest distance after rigid alignment, over the diagonal of the bounding box."""
    x, y = read_ply(frame)[0], read_ply(mesh)[0]
    return np.linalg.norm(aligned(x, y) - y, axis=1).max() / diagonal(y)


def volume(points, faces):
    a, b, c = (points[faces[:, i]] for i in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6


def steps(frames):
    """Largest way of a vertex from frame to frame, over the diagonal of the first."""
    points = [read_ply(frame)[0] for frame in frames]
    ways = [np.linalg.norm(b - a, axis=1).max() for a, b in zip(points, points[1:])]
    return np.array(ways) / diagonal(points[0])


def bends(frames):
    """Largest change of that way, as a vector, over the diagonal: a kink would be as large as a step."""
    points = [read_ply(frame)[0] for frame in frames]
    changes = [np.linalg.norm(a - 2 * b + c, axis=1).max() for a, b, c in zip(points, points[1:], points[2:])]
    return np.array(changes) / diagonal(points[0])


def volume_deviation(frames):
    """Largest deviation from the volume interpolated linearly."""
    volumes = np.array([volume(*read_ply(frame)) for frame in frames])
    return np.abs(volumes / np.linspace(volumes[0], volumes[-1], len(volumes)) - 1).max()


def worst(figures, field):
    return max(embedding[field] for embedding in figures["embeddings"])


def print_errors(name, method, figures):
    print(f"| {name} | {method} | {100 * worst(figures, 'edge_rms'):.3f} % "
          f"| {100 * worst(figures, 'edge_max'):.2f} % | {worst(figures, 'dihedral_p99_deg'):.2f} |")


def ends(study):
    """How exactly paths meet their inputs."""
    print("| path | method | largest distance to an input, over the diagonal |\n|---|---|---|")
    arm = study.arms()
    hand = [study.data / "mh_hand" / f"{pose}.ply" for pose in ("point", "victory", "fist_5")]
    cases = {
        "line": (arm[:2], ["--frames", 2], {0: 0, 1: 1}),
        "line, squared": (arm[:2], ["--frames", 2, "--lengths", "squared"], {0: 0, 1: 1}),
        "line through 4": (arm, ["--frames", 4], {0: 0, 1: 1, 2: 2, 3: 3}),
        "bilinear": (arm, ["--path", "bilinear", "--grid", "2,2"], {0: 0, 1: 1, 2: 2, 3: 3}),
        "polygon": (arm, ["--path", "polygon", "--frames", 5], {0: 0, 1: 1, 2: 2, 3: 3, 4: 0}),
        "Catmull-Rom, hand": (hand, ["--path", "spline", "--frames", 3], {0: 0, 1: 1, 2: 2}),
        "B-spline, hand": (hand, ["--path", "spline", "--spline", "b-spline", "--frames", 2],
                           {0: 0, 1: 2}),
    }
    for name, (meshes, arguments, meets) in cases.items():
        for method in METHODS + ["closure"]:
            folder = f"ends_{name.translate({32: '_', 44: None})}_{method}"
            _, frames = study.interpolate(folder, meshes, "--method", method, *arguments)
            largest = max(distance(frames[i], meshes[k]) for i, k in meets.items())
            print(f"| {name} | {method} | {largest:.1e} |")


def helix(study):
    """Cylinder to helix: no kinks, and the volume (Winkler, Fig. 6 and 9)."""
    print("| turn | method | edge RMS | worst edge | volume | largest step / median | largest bend / step |")
    print("|---|---|---|---|---|---|---|")
    for turns, vertices in ((2, 1200), (5, 2500)):
        meshes = study.synth("helix", "--count", turns, "--vertices", vertices, folder=f"helix{turns}")
        for method in METHODS:
            figures, frames = study.interpolate(f"helix{turns}_{method}", meshes, "--frames", 61,
                                                "--method", method)
            ways = steps(frames)
            print(f"| {360 * turns} deg | {method} | {100 * worst(figures, 'edge_rms'):.3f} % "
                  f"| {100 * worst(figures, 'edge_max'):.2f} % | {100 * volume_deviation(frames):.2f} % "
                  f"| {ways.max() / np.median(ways):.2f} | {bends(frames).max() / ways.max():.2f} |")
        frames = sorted((study.out / f"helix{turns}_dihedral").glob("*.ply"))
        study.draw(f"helix{turns}.png", frames[::10], "--columns", 7, "--cell", 150, "--view", "35,25")


def noise_and_thin(study):
    """Winkler, Fig. 13 and 14."""
    print("| set | method | edge RMS | worst edge | drift 99 % [deg] |\n|---|---|---|---|---|")
    for name, options, view in (("noisy_helix", ["--count", 2], "35,25"), ("thin_cylinder", [], "0,0")):
        meshes = study.synth(name, *options)
        meshes = sorted(meshes, key=lambda mesh: mesh.stem in ("noisy_helix", "thin_bent"))
        for method in METHODS + ["closure"]:
            figures, frames = study.interpolate(f"{name}_{method}", meshes, "--frames", 5,
                                                "--method", method)
            print_errors(name, method, figures)
            if method == "dihedral":
                study.draw(f"{name}.png", frames, "--columns", 5, "--cell", 200, "--view", view)


def torus(study):
    """Plain and squared lengths (Rojas, section 6)."""
    print("| lengths | method | edge RMS | worst edge | drift 99 % [deg] |\n|---|---|---|---|---|")
    meshes = sorted(study.synth("torus"), key=lambda mesh: mesh.name, reverse=True)
    for lengths in ("plain", "squared"):
        for method in METHODS:
            figures, frames = study.interpolate(f"torus_{lengths}_{method}", meshes, "--frames", 5,
                                                "--method", method, "--lengths", lengths)
            print_errors(lengths, method, figures)
            if method == "dihedral":
                study.draw(f"torus_{lengths}.png", frames, "--columns", 5, "--cell", 160, "--view", "30,20")


def patch(study):
    """Four arm poses at the corners of a bilinear patch."""
    figures, frames = study.interpolate("patch", study.arms(), "--path", "bilinear",
                                        "--grid", "4,4")
    print("bilinear patch, 16 arms:")
    print_errors("patch", "dihedral", figures)
    study.draw("patch.png", frames, "--columns", 4, "--cell", 150)


def hand(study):
    """Three hand poses along a spline."""
    meshes = [study.data / "mh_hand" / f"{pose}.ply" for pose in ("point", "victory", "fist_5")]
    figures, frames = study.interpolate("hand", meshes, "--path", "spline", "--frames", 9)
    print("three hands along a Catmull-Rom spline, 9 frames:")
    print_errors("hand", "dihedral", figures)
    study.draw("hand.png", frames, "--columns", 5, "--cell", 135)


def growing_hand(study):
    """Constrained interpolation (Winkler, Fig. 12): the hand of the arm grows to twice its size."""
    arm = study.arms()[::3]
    points, _ = read_ply(arm[0])
    (study.out / "hand.txt").write_text("\n".join(map(str, np.flatnonzero(points[:, 0] > 48))))
    tags = ["--scale-vertices", "hand.txt", "--scale-factors", "1,2", "--scale-border"]
    print("| border | method | edge RMS | worst edge | drift 99 % [deg] |\n|---|---|---|---|---|")
    for border in (1, 4):
        for method in METHODS:
            figures, frames = study.interpolate(f"growing{border}_{method}", arm, "--frames", 5,
                                                "--method", method, *tags, border)
            print_errors(border, method, figures)
            study.draw(f"growing{border}_{method}.png", frames, "--columns", 5, "--cell", 160)


def beyond(study):
    """Extrapolation within the safe range."""
    arm = study.arms()[::3]
    for lengths in ("plain", "squared"):
        common = ["--extrapolate", "--lengths", lengths]
        figures, _ = study.interpolate(f"range_{lengths}", arm, "--frames", 2, *common)
        print(f"safe range of the arm, {lengths}: {figures['safe_range']}")
    figures, frames = study.interpolate("beyond", arm, "--frames", 5, "--range", "-0.5:1.2", "--extrapolate")
    print_errors("arm, t = -0.5 to 1.2", "dihedral", figures)
    study.draw("beyond.png", frames, "--columns", 5, "--cell", 200)


def keyframes(study):
    """All frames embedded, or every tenth and the rest filled in."""
    meshes = [study.data / "mh_arm" / f"elbow_{bend}.ply" for bend in ("000", "1000")]
    print("| in between | seconds | edge RMS | worst edge | largest step across a keyframe / elsewhere |")
    print("|---|---|---|---|---|")
    for between in (None, "multiscale", "dihedral", "linear", "spline"):
        extra = ["--keyframes", 10, "--between", between] if between else []
        figures, frames = study.interpolate(f"keys_{between}", meshes, "--frames", 61, *extra)
        ways = steps(frames)
        across = np.array([i % 10 in (0, 9) for i in range(len(ways))])
        seconds = sum(embedding["seconds"] for embedding in figures["embeddings"])
        print(f"| {between or '(all embedded)'} | {seconds:.1f} | {100 * worst(figures, 'edge_rms'):.3f} % "
              f"| {100 * worst(figures, 'edge_max'):.2f} % "
              f"| {ways[across].max() / ways[~across].max():.2f} |")


CASES = [ends, helix, noise_and_thin, torus, patch, hand, growing_hand, beyond, keyframes]


def run_cases(cases, make_study, usage):
    """The arguments SHAPE DATA OUT [CASE ...] of a script that makes figures by cases."""
    if len(sys.argv) < 4:
        sys.exit(usage)
    wanted = sys.argv[4:] or [case.__name__ for case in cases]
    study = make_study(*sys.argv[1:4])
    for case in cases:
        if case.__name__ in wanted:
            print(f"\n{case.__doc__}\n", flush=True)
            case(study)


if __name__ == "__main__":
    run_cases(CASES, Study, __doc__)
