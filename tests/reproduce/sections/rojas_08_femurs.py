# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 8: femurs with equal ends and different shafts."""
import itertools

import numpy as np

from experiment import edges_of, lengths_of, markdown_table

TITLE = "Femur sketches (Rojas 2014, Fig. 8)"
NAMES = ["femur_short", "femur_long", "femur_stout_short", "femur_stout_long"]
METRICS = {"edge lengths, of one size": ["--metric", "edge-unit"],
           "the same, weighted by area": ["--metric", "edge-unit", "--area-weighted"],
           "edge lengths": ["--metric", "edge"],
           "aligned positions": ["--metric", "procrustes"]}


def four_way(experiment):
    """Distances of two kinds of ends on two shafts."""
    rows = []
    for title, options in METRICS.items():
        distances = experiment.distances(["bones"], *options)
        cells = [distances[pair] for pair in itertools.combinations(NAMES, 2)]
        shaft = (cells[0] + cells[5]) / 2  # of bones with the same ends
        ends = (cells[1] + cells[4]) / 2  # of bones with the same shaft
        rows.append([title, *(f"{cell / max(cells):.2f}" for cell in cells), f"**{shaft / ends:.2f}**"])
    return markdown_table(["distances, the largest as 1", "same ends (slender)", "same shaft (short)",
                           "neither", "neither", "same shaft (long)", "same ends (stout)",
                           "same ends over same shaft"], rows)


def aligned_bones(experiment, files):
    """Two bones as Procrustes space has them: aligned, of the same size."""
    experiment.shape("stats", *files, "-o", "model.h5", "--space", "procrustes")
    experiment.shape("project", "model.h5", *files, "-o", "scores.csv")
    scores = experiment.table("scores.csv")
    with open(experiment.folder / "aligned.csv", "w") as file:
        file.write("mesh,pc1\n" + "".join(f"{row['mesh']},{row['pc1']}\n" for row in scores))
    experiment.shape("generate", "model.h5", "--scores-file", "aligned.csv", "-o", "aligned")
    return [experiment.mesh(f"aligned/{name}.ply")[0] for name in NAMES[:2]]


def shares_of_ends(experiment):
    """The share of the squared distance of the first two bones that lies in their ends."""
    files = [f"bones/{name}.ply" for name in NAMES[:2]]
    (short, faces), (long, _) = map(experiment.mesh, files)
    edges = edges_of(faces)
    plain = lengths_of(short, edges), lengths_of(long, edges)
    same = abs(plain[0] - plain[1]) <= 1e-9 * plain[1]
    in_ends = np.ones(len(short), bool)
    in_ends[edges[~same]] = False

    def share(a, b, selected):
        changes = (a - b) ** 2
        return f"{100 * changes[selected].sum() / changes.sum():.0f} %"

    unit = [lengths / lengths.sum() for lengths in plain]
    rows = [["aligned positions, of one size", share(*aligned_bones(experiment, files), in_ends)],
            ["edge lengths, of one size", share(*unit, same)],
            ["edge lengths", share(*plain, same)]]
    return (f"{same.sum()} of {len(edges)} edges have the same length in both, {in_ends.sum()} of {len(short)} "
            "vertices have no\nother edge.", markdown_table(["space", "share in the ends"], rows))


def make(experiment):
    experiment.shape("synth", "femurs", "--count", 4, "-o", "bones")
    picture = experiment.draw("rojas_femurs.png", [f"bones/{name}.ply" for name in NAMES],
                              "--columns", 4, "--cell", 130, "--view", "0,0")
    counts, shares = shares_of_ends(experiment)
    return f"""The paper's two sketches, whose shafts differ and whose ends are the same, vertex by vertex up to a motion (`slender`, the first
two), and two with other ends on the same shafts (`stout`).

{picture}

The claim: aligned RMS distance "captures the gross difference in shape, but fails to capture the fact that the ends are nearly
identical". The share of the squared distance between the first two that lies in the ends, which do not differ.
{counts}

{shares}
By lengths as they are, the ends are recognised as identical. Division by the sum takes some of that away: where the
shaft grows, all else shrinks. All four bones:

{four_way(experiment)}
The last column is large where the shaft decides who is alike, below 1 where the ends do. How large depends on how different
these made-up ends are; between spaces it can be compared. In no space are bones with the same ends the nearest ones, but positions
see the shaft the most. As with the barbells, to positions the two long bones are more alike than the two short ones, since bringing
them to one size shrinks the ends; to lengths of one size less so.
"""
