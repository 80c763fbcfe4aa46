# SPDX-License-Identifier: MIT
"""What the sections of docs/reproduction.md are made with."""
import csv
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/benchmarks"))

import matplotlib  # noqa: E402
import numpy as np  # noqa: E402
from interpolation_figures import aligned, read_ply  # noqa: E402

matplotlib.use("Agg")
matplotlib.rcParams.update({"axes.grid": True, "grid.alpha": 0.3, "figure.constrained_layout.use": True})

METHODS = ("dihedral", "closure", "multiscale")


class Experiment:
    """Runs the program in a folder of its own, for one section."""

    def __init__(self, program, folder):
        self.program = program
        self.folder = pathlib.Path(folder)
        self.images = ROOT / "docs/images"
        self.data = pathlib.Path(os.environ.get("SHAPE_DATA_DIR", ROOT.parent / "shared/data"))

    def shape(self, *arguments):
        """Runs one command; gives back the JSON that it prints."""
        command = [str(self.program), *map(str, arguments), "--json", "--force", "--quiet"]
        done = subprocess.run(command, cwd=self.folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{' '.join(command)}\n{done.stderr}")
        return json.loads(done.stdout)

    def meshes(self, folder, *names):
        """The PLY files of these meshes, of the real data."""
        return [self.data / folder / f"{name}.ply" for name in names]

    def interpolate(self, output, meshes, *options):
        """The report of every blend, and the files in the folder `output`."""
        report = self.shape("interpolate", *meshes, "-o", f"{output}/", *options)
        return report["embeddings"], sorted((self.folder / output).glob("*.ply"))

    def draw(self, picture, meshes, *options):
        """Draws meshes into docs/images; gives back the Markdown that shows it."""
        self.shape("draw", *meshes, "-o", self.images / picture, *options)
        return show(picture)

    def save(self, figure, picture):
        """Puts a plot into docs/images; gives back the Markdown that shows it."""
        figure.savefig(self.images / picture, dpi=100, metadata={"Software": None})
        return show(picture)

    def table(self, name):
        """The rows of a CSV file as dictionaries."""
        with open(self.folder / name, newline="") as file:
            return list(csv.DictReader(file))

    def distances(self, meshes, *options):
        """The distance between any two of the meshes, by their names."""
        self.shape("distance", *meshes, "-o", "distances.csv", *options)
        return {(row["mesh"], other): float(value)
                for row in self.table("distances.csv")
                for other, value in row.items() if other != "mesh"}

    def mesh(self, name):
        """Vertices and faces of a PLY file that the program wrote."""
        return read_ply(self.folder / name)


def show(picture):
    """Markdown for a picture of docs/images."""
    return f"![{pathlib.Path(picture).stem.replace('_', ' ')}](images/{picture})"


def distance(a, b):
    """Largest distance of corresponding points after rigid alignment."""
    return np.linalg.norm(aligned(a, b) - b, axis=1).max()


def edges_of(faces):
    """Every edge once, as two vertices in ascending order."""
    return np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)


def lengths_of(points, edges):
    return np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)


def worst(embeddings, field):
    return max(embedding[field] for embedding in embeddings)


def markdown_table(header, rows):
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"
