#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints the tables of docs/performance.md: half-way blends of pairs of meshes.

performance.py BUILD DATA WORK [--tables a,b,...] [--peer PROGRAM] [--closure] [--names a,b,...]

BUILD is a build folder with benchmarks, DATA the folder of the real datasets, WORK a folder for the pairs
that are made of them and of `shape synth`; what is there is not made again. PROGRAM is another
implementation of Winkler 2010, called as `PROGRAM A B --t 0.5 --repeat N --out MESH` on one thread. Ours use
two threads. --closure adds that method (minutes), --names chooses pairs. Tables: all but `smoothness` by default.

  pairs       real pairs: errors and times of every method beside the peers
  arm         the same on the synthetic arm from 2,500 to 640,000 vertices, and how times grow
  shape       blends beside the poses that lie between: how far off in the large
  helix       the same on helices of four and of ten turns
  rate        embeddings a second at about 5,000 vertices
  memory      peak memory of the program on the largest real pair
  minima      the energy reached beside that of other methods
  density     the same shapes with more vertices, at the same mu and at one that grows with them
  units       pairs in units a thousand times smaller
  bits        whether one and two threads, and two runs, give the same file
  faces       a model of 600 faces: mean, mean difference and modes
  smoothness  errors against drift along mu; needs matplotlib, draws WORK/smoothness.svg
"""
import argparse
import math
import struct
from pathlib import Path

from common import call, row, table

REAL = {"arm": ("mh_arm", "elbow_000", "elbow_1000"), "hand": ("mh_hand", "fist_0", "fist_5"),
        "body": ("mh_body_poses", "rest", "lunge"), "walk": ("mh_body_poses", "walk_00", "walk_06"),
        "face": ("ict_faces_full", "s000_neutral", "s000_happy"), "large": ("large_body", "rest", "lunge")}
# Pairs of poses, and the pose that lies half-way.
BETWEEN = {"arm 0, 100 -> 50": ("mh_arm", "elbow_000", "elbow_1000", "elbow_500"),
           "hand 1, 3 -> 2": ("mh_hand", "fist_1", "fist_3", "fist_2"),
           "hand 3, 5 -> 4": ("mh_hand", "fist_3", "fist_5", "fist_4")}
ARMS = [2500, 10_000, 40_000, 160_000, 640_000]
HELICES = {"helix, 4 turns": (4, 1200), "helix, 10 turns": (10, 3000)}
RATED = {"arm": ("arm", 5000), "head": ("heads", 5000)}

# An independent SciPy implementation of Rojas 2014, as measured once: edge RMS, worst edge, drift, seconds.
ROJAS = {"arm": ("1.8 %", "10 %", "10°", 18), "hand": ("13.6 %", "183 %", "23°", 107),
         "body": ("12.9 %", "88 %", "14°", 170), "walk": ("0.25 %", "1.7 %", "0.9°", 28),
         "face": ("3.2 %", "46 %", "6.3°", 109)}


def obj_of_ply(source, target):
    """Writes one of the datasets' files (binary, float coordinates, triangles) as OBJ, exactly."""
    data = source.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    vertices, faces = (int(line.split()[2]) for line in head.decode().splitlines()
                       if line.startswith("element"))
    with open(target, "w") as file:
        for point in struct.iter_unpack("<3f", body[:12 * vertices]):
            file.write("v %r %r %r\n" % point)
        for _, a, b, c in struct.iter_unpack("<B3i", body[12 * vertices:12 * vertices + 13 * faces]):
            file.write(f"f {a + 1} {b + 1} {c + 1}\n")


class Bench:
    def __init__(self, options):
        self.options = options
        self.program = options.build / "tools" / "shape"
        self.work = options.work
        self.work.mkdir(exist_ok=True, parents=True)

    def benchmark(self, topic, *arguments):
        return call(self.options.build / "tests" / "benchmarks" / f"{topic}_benchmark", *arguments)

    def chosen(self, names):
        return [name for name in names if not self.options.names or name in self.options.names.split(",")]

    def real(self, *excluded):
        """(name, files) of the real pairs."""
        for name in self.chosen(REAL):
            if name not in excluded:
                folder, *meshes = REAL[name]
                files = [self.work / f"{name}_{side}.obj" for side in "AB"]
                for mesh, file in zip(meshes, files):
                    if not file.exists():
                        obj_of_ply(self.options.data / folder / f"{mesh}.ply", file)
                yield name, files

    def synthetic(self, name, count, vertices):
        folder = self.work / f"{name}_{count}_{vertices}"
        if not folder.exists():
            self.run("synth", name, "-o", folder, "--format", "obj", "--count", count, "--vertices", vertices)
        return sorted(folder.glob("*.obj"))[:2]

    def run(self, *arguments):
        return call(self.program, *arguments, "--json", "--quiet", "--force")

    def interpolate(self, files, *arguments, threads=2):
        """Figures of the half-way blend, and the file."""
        mesh = self.work / "half.ply"
        report = self.run("interpolate", *files, "--weights", "0.5,0.5", "-o", mesh, "--threads", threads, *arguments)
        return {**report["embeddings"][0], "peak_bytes": report["peak_bytes"]}, mesh

    # Tables of methods

    def methods(self, pairs_of_files):
        """One row per pair and method; gives back {method: [(vertices, ms)]}."""
        table(["pair", "vertices", "method", "edge RMS", "worst edge", "drift RMS", "bad faces", "steps", "ms",
               "x peer", "x solve"])
        times = {}
        for name, files in pairs_of_files:
            arguments = ["--methods", "fine,preview,multiscale" + (",closure" if self.options.closure else "")]
            repeats = 9 if vertex_count(files[0]) < 100_000 else 3
            peer = None
            if self.options.peer:
                mesh = self.work / "peer.obj"
                peer = call(self.options.peer, *files, "--t", 0.5, "--repeat", repeats, "--out", mesh)["poses"][0]
                arguments += ["--measure", mesh]
            report = self.benchmark("embedding", *files, "--repeat", repeats, *arguments)
            solve = report["back_substitution_ms"]
            unit = peer["total_ms"] if peer else math.nan
            if peer:
                report["methods"]["peer"] = {**report["measured"], "ms": unit, "iterations": "", "converged": True}
            for method in ["fine", "preview", "multiscale", "closure", "peer"]:
                found = report["methods"].get(method)
                if not found:
                    continue
                times.setdefault(method, []).append((report["vertices"], found["ms"]))
                row(name, report["vertices"], method, f"{100 * found['edge_rms']:.4f} %",
                    f"{100 * found['edge_max']:.2f} %", f"{found['dihedral_rms_deg']:.3f}°",
                    found["bad_faces"], f"{found['iterations']}{'' if found['converged'] else '*'}",
                    f"{found['ms']:.1f}", f"{found['ms'] / unit:.2f}" if peer else "", f"{found['ms'] / solve:.0f}")
            if name in ROJAS:
                *errors, seconds = ROJAS[name]
                row(name, report["vertices"], "Rojas, SciPy", *errors, "", "", f"{1e3 * seconds:.0f}", "", "")
        return times

    def pairs(self):
        self.methods(self.real())

    def shape(self):
        table(["blend", "quality", "from the true pose", "from the companion", "edge RMS", "worst edge", "drift RMS",
               "new crossings", "ms"])
        for name, (folder, *meshes) in BETWEEN.items():
            *pair, truth = [self.options.data / folder / f"{mesh}.ply" for mesh in meshes]
            report = self.benchmark("embedding", *pair, "--truth", truth, "--methods", "fine,preview")
            for method in ("fine", "preview"):
                found = report["methods"][method]
                row(name, method, f"{100 * found['distance']:.3f} %", f"{found['companion_rms']:.3f} %",
                    f"{100 * found['edge_rms']:.4f} %", f"{100 * found['edge_max']:.2f} %",
                    f"{found['dihedral_rms_deg']:.3f}°", found["new_self_intersections"], f"{found['ms']:.1f}")

    def helix(self):
        self.methods((name, self.synthetic("helix", *HELICES[name])) for name in self.chosen(HELICES))

    def arm(self):
        times = self.methods((f"arm {size}", self.synthetic("arm", 2, size)) for size in ARMS)
        print("\nTimes grow as the power of the number of vertices:",
              ", ".join(f"{method} {exponent(points):.2f}" for method, points in times.items()))

    # Other tables

    def rate(self):
        """Walks through 60 blends, one after the other."""
        sources = {f"{name} (synth)": self.synthetic(set_name, 2 if set_name == "arm" else 1, vertices)
                   for name, (set_name, vertices) in RATED.items()}
        sources.update(self.real("large"))
        table(["pair", "vertices", "preview, embeddings a second", "fine"])
        for name, files in sources.items():
            report = self.benchmark("embedding", *files, "--repeat", 1, "--frames", 60, "--methods", "preview,fine")
            row(name, report["vertices"], *(f"{report['methods'][method]['frames_per_second']:.1f}"
                                            for method in ("preview", "fine")))

    def memory(self):
        table(["pair", "vertices", "quality", "peak memory"])
        files = dict(self.real())["large"]
        for quality in ("fine", "preview"):
            report, _ = self.interpolate(files, "--quality", quality)
            row("large", report["vertices"], quality, f"{report['peak_bytes'] / 1e9:.2f} GB")

    def minima(self):
        table(["pair", "fine", "preview", "Gauss-Newton from fine", "from preview", "walk from A",
               "walk from B", "fine / least"])
        for name, files in self.real("large"):
            found = self.benchmark("minima", *files)
            energies = [found[key] for key in ("fine", "preview", "from_fine", "from_preview", "walk_from_a",
                                               "walk_from_b")]
            row(name, *(f"{energy:.5g}" for energy in energies), f"{energies[0] / min(energies):.4f}")

    def density(self):
        """The same mu, and one that grows with the number of vertices, on two shapes; drift is given as
        the angle per length, in units of the coarsest mesh of the shape."""
        shapes = {"arm": [self.synthetic("arm", 2, size) for size in (2500, 10_000, 40_000, 160_000)],
                  "body": [files for name, files in self.real() if name in ("body", "large")]}
        table(["shape", "vertices", "mu", "edge RMS", "worst edge", "drift RMS per length", "steps"])
        for name, meshes in shapes.items():
            vertices = [vertex_count(files[0]) for files in meshes]
            for grows in (False, True):
                for count, files in list(zip(vertices, meshes))[grows:]:
                    refined = count / vertices[0]
                    mu = 5e-3 * (refined if grows else 1)
                    found, _ = self.interpolate(files, "--smoothness", mu)
                    row(name, count, f"{mu:.4g}", f"{100 * found['edge_rms']:.4f} %",
                        f"{100 * found['edge_max']:.3f} %",
                        f"{found['dihedral_rms_deg'] * math.sqrt(refined):.3f}°", found["iterations"])

    def units(self):
        table(["pair", "edge RMS", "in small units", "worst edge", "in small units"])
        for name, files in self.real("large"):
            small = [file.with_name(f"{file.stem}_small.obj") for file in files]
            for file, scaled in zip(files, small):
                scaled.write_text("".join(map(thousandfold, file.open())))
            found = [self.interpolate(pair)[0] for pair in (files, small)]
            row(name, *(f"{100 * report[key]:.6f} %" for key in ("edge_rms", "edge_max") for report in found))

    def bits(self):
        table(["pair", "quality", "2 threads, 2 threads again, 1 thread"])
        for name, files in self.real():
            for quality in ("fine", "preview"):
                meshes = {self.interpolate(files, "--quality", quality, threads=threads)[1].read_bytes()
                          for threads in (2, 2, 1)}
                row(name, quality, "the same" if len(meshes) == 1 else "DIFFER")

    def faces(self):
        """What docs/embedding.md shows."""
        data = self.options.data / "ict_faces600"
        faces, model, out = self.work / "faces.h5", self.work / "model.h5", self.work / "faces"
        out.mkdir(exist_ok=True)
        self.run("collect", data, "--labels", data / "labels.csv", "-o", faces)
        self.run("stats", faces, "--modes", 20, "-o", model)
        runs = [self.run("generate", model, "--mean", "-o", out / "mean.ply"),
                self.run("difference", faces, "--pair-by", "subject", "--from", "expression=neutral", "--to",
                         "expression=happy", "-o", self.work / "happy.h5", "--apply", "--mesh", out / "happy.ply")]
        runs += [self.run("generate", model, "--mode", mode, "--sigma", "-2:2:5", "-o", out / f"mode{mode}/")
                 for mode in (1, 2, 3)]
        table(["mesh", "status", "edge RMS", "worst edge", "drift RMS", "ms"])
        for report in runs:
            for found in report["embeddings"]:
                row(found["name"], found["status"], f"{100 * found['edge_rms']:.3f} %",
                    f"{100 * found['edge_max']:.2f} %", f"{found['dihedral_rms_deg']:.3f}°",
                    f"{1e3 * found['seconds']:.0f}")

    def smoothness(self):
        """Last column: how far a point of the curve is from the least edge error and the least drift at
        once, each over its range on the curve. The knee is where that is smallest."""
        import matplotlib
        matplotlib.use("svg")
        import matplotlib.pyplot as plt
        plt.rcParams["svg.hashsalt"] = "smoothness"
        figure, axes = plt.subplots(1, 3, figsize=(9, 3), constrained_layout=True)
        table(["pair", "mu", "edge RMS", "worst edge", "drift RMS", "steps", "from the corner"])
        smoothness = [5e-3 * 2.0 ** power for power in range(-4, 5)]
        for axis, (name, files) in zip(axes, self.real("arm", "large", "walk")):
            found = [self.interpolate(files, "--smoothness", mu)[0] for mu in smoothness]
            errors = [100 * report["edge_rms"] for report in found]
            drifts = [report["dihedral_rms_deg"] for report in found]
            for mu, report, *corner in zip(smoothness, found, share(errors), share(drifts)):
                row(name, f"{mu:g}", f"{100 * report['edge_rms']:.4f} %", f"{100 * report['edge_max']:.2f} %",
                    f"{report['dihedral_rms_deg']:.3f}°", report["iterations"], f"{math.hypot(*corner):.2f}")
            axis.plot(drifts, errors, ".-", linewidth=1)
            axis.plot(drifts[4], errors[4], "o", color="tab:red")
            for i in (0, 2, 4, 6, 8):
                axis.annotate(f"{smoothness[i]:.2g}", (drifts[i], errors[i]), textcoords="offset points",
                              xytext=(4, 4), fontsize=7)
            axis.set(title=name, xlabel="drift RMS [deg]", ylabel="edge RMS [%]",
                     xlim=(0, 1.25 * max(drifts)), ylim=(0, 1.1 * max(errors))) # room for the numbers
            axis.grid(alpha=0.3)
        figure.savefig(self.work / "smoothness.svg", metadata={"Date": None})


def share(values):
    """Where values lie between their least (0) and their greatest (1)."""
    return [(value - min(values)) / (max(values) - min(values)) for value in values]


def exponent(points):
    """Slope of the least-squares line through (log vertices, log time)."""
    logs = [(math.log(vertices), math.log(time)) for vertices, time in points]
    x, y = (sum(values) / len(logs) for values in zip(*logs))
    return sum((u - x) * (v - y) for u, v in logs) / sum((u - x) ** 2 for u, _ in logs)


def vertex_count(file):
    with open(file) as lines:
        return sum(line.startswith("v ") for line in lines)


def thousandfold(line):
    """A line of an OBJ file with coordinates in a unit a thousand times smaller."""
    if not line.startswith("v "):
        return line
    return "v %r %r %r\n" % tuple(1e3 * float(value) for value in line.split()[1:])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for folder in ("build", "data", "work"):
        parser.add_argument(folder, type=Path)
    parser.add_argument("--tables",
                        default="pairs,shape,arm,helix,rate,memory,minima,density,units,bits,faces")
    parser.add_argument("--peer")
    parser.add_argument("--closure", action="store_true")
    parser.add_argument("--names")
    bench = Bench(parser.parse_args())
    for name in bench.options.tables.split(","):
        print(f"\n### {name}\n")
        getattr(bench, name)()


if __name__ == "__main__":
    main()
