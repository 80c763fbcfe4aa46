#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the tables of docs/scale.md and draws its picture.

scale.py SHAPE WORK [--large] [--planted PROGRAM] [--picture FILE.svg]

SHAPE is the program, WORK a folder for the collections, which are made there and removed: up to 0.5 GB,
with --large 5 GB. Needs a Python with h5py. CPU seconds are user and system together, memory is the largest
resident set; numpy measures lengths and angles of the same meshes in the same run, one coordinate of all
vertices at a time, reading not counted. PROGRAM is planted_benchmark, whose collections are made as they are
read: with it the largest ones are run too, which takes ten minutes of two cores.
"""
import argparse
import json
import math
import os
import subprocess
import threading
import time
from pathlib import Path

import h5py
import numpy as np

from common import table, row

MODES = 20


def watch_memory(process, largest):
    """Appends its largest resident set as it grows [kB]. What wait4() says begins with that of this process."""
    try:
        while process.returncode is None:
            status = Path(f"/proc/{process.pid}/status").read_text()
            largest.append(int(status.split("VmHWM:")[1].split()[0]))
            time.sleep(0.01)
    except (OSError, IndexError):
        return  # it has ended


def run(*command):
    """The JSON that the program prints, CPU seconds, and the largest resident set [MB]."""
    process = subprocess.Popen([*map(str, command), "--json", "--quiet"], stdout=subprocess.PIPE)
    largest = [0]
    watch = threading.Thread(target=watch_memory, args=(process, largest))
    watch.start()
    text = process.stdout.read()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    watch.join()
    if process.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, command))}: {text.decode()}")
    return json.loads(text), usage.ru_utime + usage.ru_stime, 1.024e-3 * max(largest)


def make(shape, work, name, meshes, vertices):
    """A collection of `meshes` heads: 60 smooth random changes of one, of falling size, and noise."""
    folder = work / "base"
    subprocess.run([shape, "synth", "faces", "-o", folder, "--count", "1", "--vertices", str(vertices),
                    "--force", "--quiet"], check=True)
    base = work / "base.h5"
    subprocess.run([shape, "collect", folder, "-o", base, "--force", "--quiet"], check=True)
    target = work / f"{name}.h5"
    random = np.random.default_rng(1)
    with h5py.File(base) as old, h5py.File(target, "w", libver="latest") as new:
        mean = old["points"][0]
        count = len(mean)
        for key, value in old.attrs.items():
            new.attrs.create(key, value)
        old.copy("topology", new)
        new.create_dataset("names", data=np.array([f"m{i}".encode() for i in range(meshes)]),
                           fletcher32=True, chunks=(min(meshes, 65536),))
        size = np.ptp(mean, axis=0).max()
        waves = random.normal(size=(60, 3)) * 6 / size
        phases = random.uniform(0, 2 * math.pi, 60)
        ways = random.normal(size=(60, 3))
        sizes = 0.02 * size * 0.93 ** np.arange(60)
        changes = np.stack([s * np.sin(mean @ w + p)[:, None] * d
                            for w, p, d, s in zip(waves, phases, ways, sizes)]).reshape(60, -1)
        # Chunks as `shape collect` makes them: of at most 1 MiB, a power of two of rows or equal parts of one.
        rows = max(1, 2 ** int(math.log2(max(1, 2 ** 20 // (24 * count)))))
        parts = -(-count // 43690)
        points = new.create_dataset("points", (meshes, count, 3), "f8", fletcher32=True,
                                    chunks=(min(rows, meshes), -(-count // parts), 3))
        step = max(1, 2 ** 24 // (24 * count))
        for first in range(0, meshes, step):
            n = min(step, meshes - first)
            block = mean.reshape(-1) + random.normal(size=(n, 60)) @ changes
            points[first:first + n] = block.reshape(n, count, 3)
    edges = h5py.File(base)["topology/edges"].shape[0]
    return target, count, edges


def numpy_seconds(file, most=40):
    """CPU seconds of lengths and angles of all meshes, from those of some."""
    with h5py.File(file) as f:
        faces, edges, points = f["topology/faces"][...], f["topology/edges"][...], f["points"]
        meshes = points.shape[0]
        some = [points[i] for i in range(min(meshes, most))]
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    owner = np.tile(np.arange(len(faces)), 3)
    count = int(faces.max()) + 1
    low, high = sides.min(axis=1).astype(np.int64), sides.max(axis=1)
    place = np.searchsorted(edges[:, 0].astype(np.int64) * count + edges[:, 1], low * count + high)
    forward = sides[:, 0] < sides[:, 1]
    left, right = np.full(len(edges), -1), np.full(len(edges), -1)
    left[place[forward]], right[place[~forward]] = owner[forward], owner[~forward]
    inner = np.flatnonzero((left >= 0) & (right >= 0))
    left, right = left[inner], right[inner]
    a, b = edges[:, 0].copy(), edges[:, 1].copy()
    t = [np.ascontiguousarray(faces[:, k]) for k in range(3)]

    def cross(u, v):
        return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]

    begin = time.process_time()
    for mesh in some:
        x = [np.ascontiguousarray(mesh[:, k]) for k in range(3)]
        d = [c[b] - c[a] for c in x]
        length = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        n = cross([c[t[1]] - c[t[0]] for c in x], [c[t[2]] - c[t[0]] for c in x])
        p, q = [c[left] for c in n], [c[right] for c in n]
        r = cross(p, q)
        angle = np.zeros(len(edges))
        angle[inner] = np.arctan2(sum(d[k][inner] * r[k] for k in range(3)),
                                  length[inner] * sum(p[k] * q[k] for k in range(3)))
    return (time.process_time() - begin) * meshes / len(some)


def stats(shape, work, file, *options):
    model = work / "model.h5"
    found = run(shape, "stats", file, "-o", model, "--force", *options)
    model.unlink()
    return found


def one_size(shape, work, name, meshes, vertices, picture):
    """A row for every way of one collection."""
    file, count, edges = make(shape, work, name, meshes, vertices)
    numpy = numpy_seconds(file)
    reference = None
    for algorithm in ["gram", "krylov"]:
        figures, seconds, memory = stats(shape, work, file, "--modes", MODES, "--algorithm", algorithm)
        variances = np.array([mode["variance"] for mode in figures["modes"]])
        if reference is None:
            reference = variances
        error = np.abs(variances / reference - 1).max()
        row(meshes, count, edges, algorithm, figures["passes"], f"{seconds:.1f}", f"{numpy:.1f}",
            f"{memory:.0f}", f"{figures['variance_error']:.1e}", f"{error:.1e}")
        picture.append((algorithm, meshes, edges, seconds, memory))
    file.unlink()


def others(shape, work):
    """CPU seconds and memory of the other commands that go in passes."""
    table(["meshes", "vertices", "command", "CPU s", "MB"])
    for meshes, vertices in [(1000, 2000), (4000, 2000), (300, 20000)]:
        file, count, _ = make(shape, work, "others", meshes, vertices)
        labels = work / "labels.csv"
        labels.write_text("mesh,side\n" + "".join(f"m{i},{'ab'[i * 7 % 5 < 2]}\n" for i in range(meshes)))
        output = work / "output.csv"
        for title, command in [
                ("groups, 999 permutations, 1000 replicates",
                 ["groups", file, "--labels", labels, "--by", "side", "-o", output]),
                ("distance, the plane", ["distance", file, "--mds", output]),
                ("distance, the matrix", ["distance", file, "-o", output])]:
            _, seconds, memory = run(shape, *command, "--memory", "500M", "--force")
            row(meshes, count, title, f"{seconds:.1f}", f"{memory:.0f}")
            output.unlink()
        file.unlink()


def many(shape, work):
    """A model of 100,000 meshes and their scores, in 800 MiB."""
    table(["meshes", "vertices", "command", "CPU s", "numpy, lengths and angles", "MB"])
    file, count, _ = make(shape, work, "many", 100000, 2000)
    numpy = numpy_seconds(file)
    model, scores = work / "model.h5", work / "scores.csv"
    for title, command in [("stats", ["stats", file, "-o", model, "--modes", MODES, "--memory", "800M"]),
                           ("project", ["project", model, file, "-o", scores])]:
        _, seconds, memory = run(shape, *command, "--force")
        row(100000, count, title, f"{seconds:.1f}", f"{numpy:.1f}", f"{memory:.0f}")
    for path in (file, model, scores):
        path.unlink()


def series(points):
    """[(title, index of what grows, points)]: along the meshes of the fewest edges, and along the edges of
    the fewest meshes."""
    fewest = [min(p[k] for p in points) for k in (1, 2)]
    return [(f"meshes, of {fewest[1]} edges", 1, [p for p in points if p[2] == fewest[1]]),
            (f"edges, of {fewest[0]} meshes", 2, [p for p in points if p[1] == fewest[0]])]


def draw(points, path):
    """CPU seconds and memory against meshes and against edges, all axes logarithmic, as SVG."""
    width, height, bottom = 900, 400, 60
    values = [p[k] for p in points for k in (3, 4)]
    floor, top = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))

    def y(value):
        return height - bottom - (math.log10(value) - floor) / (top - floor) * (height - bottom - 20)

    looks = [("gram", 3, "CPU s, gram", "#c0392b"), ("krylov", 3, "CPU s, krylov", "#2471a3"),
             ("gram", 4, "MB, gram", "#e59866"), ("krylov", 4, "MB, krylov", "#85c1e9")]
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
             'font-family="sans-serif" font-size="12"><rect width="100%" height="100%" fill="white"/>']
    for panel, (title, index, some) in enumerate(series(points)):
        left, right = 60 + 380 * panel, 390 + 380 * panel
        low = math.floor(math.log10(min(p[index] for p in some)))
        high = math.ceil(math.log10(max(p[index] for p in some)))

        def x(size):
            return left + (math.log10(size) - low) / (high - low) * (right - left)

        for k in range(low, high + 1):
            parts.append(f'<path d="M{x(10 ** k):.1f} 20V{height - bottom}" stroke="#ddd"/>'
                         f'<text x="{x(10 ** k):.1f}" y="{height - bottom + 18}" text-anchor="middle">'
                         f'1e{k}</text>')
        for k in range(floor, top + 1):
            parts.append(f'<path d="M{left} {y(10 ** k):.1f}H{right}" stroke="#ddd"/>'
                         f'<text x="{left - 6}" y="{y(10 ** k) + 4:.1f}" text-anchor="end">{10.0 ** k:g}</text>')
        for algorithm, field, _, colour in looks:
            line = sorted((p[index], p[field]) for p in some if p[0] == algorithm)
            steps = " ".join(f"{'M' if k == 0 else 'L'}{x(w):.1f} {y(v):.1f}" for k, (w, v) in enumerate(line))
            parts.append(f'<path d="{steps}" fill="none" stroke="{colour}" stroke-width="2"/>')
            parts += [f'<circle cx="{x(w):.1f}" cy="{y(v):.1f}" r="3.5" fill="{colour}"/>' for w, v in line]
        parts.append(f'<text x="{(left + right) / 2}" y="{height - 15}" text-anchor="middle">{title}</text>')
    for i, (_, _, label, colour) in enumerate(looks):
        parts.append(f'<text x="{width - 110}" y="{40 + 20 * i}" fill="{colour}">{label}</text>')
    parts.append("</svg>")
    Path(path).write_text("\n".join(parts) + "\n")


def slopes(points):
    """How CPU seconds grow as powers, and the range of the memory."""
    for title, index, all_points in series(points):
        for algorithm in ["gram", "krylov"]:
            some = [p for p in all_points if p[0] == algorithm]
            power = np.polyfit(np.log([p[index] for p in some]), np.log([p[3] for p in some]), 1)[0]
            print(f"* Along the {title}, {algorithm}: CPU time grows as the power {power:.2f}; memory from "
                  f"{min(p[4] for p in some):.0f} to {max(p[4] for p in some):.0f} MB.")


def main():
    options = argparse.ArgumentParser(description=__doc__,
                                      formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("shape", type=Path)
    options.add_argument("work", type=Path)
    options.add_argument("--large", action="store_true")
    options.add_argument("--planted", type=Path)
    options.add_argument("--picture")
    chosen = options.parse_args()
    shape, work = chosen.shape.resolve(), chosen.work.resolve()
    work.mkdir(parents=True, exist_ok=True)
    sizes = [(300, 2000), (1000, 2000), (4000, 2000), (300, 8000), (300, 20000), (300, 57969)]
    if chosen.large:
        sizes += [(8000, 2000), (4000, 20000)]
    points = []
    table(["meshes", "vertices", "edges", "algorithm", "passes", "CPU s", "numpy, lengths and angles",
           "MB", "error, estimated", "error against gram"])
    for k, (meshes, vertices) in enumerate(sizes):
        one_size(shape, work, f"s{k}", meshes, vertices, points)
    print()
    slopes(points)
    print()
    others(shape, work)
    if chosen.large:
        print()
        many(shape, work)
    if chosen.planted:
        print()
        for arguments in (["stats", 10000, 259, 50, 900], ["groups", 100000, 45, 999, 800]):
            run_text = subprocess.run([chosen.planted, *map(str, arguments)], check=True,
                                      capture_output=True, text=True).stdout
            print("*", run_text.strip())
    if chosen.picture:
        draw(points, chosen.picture)


if __name__ == "__main__":
    main()
