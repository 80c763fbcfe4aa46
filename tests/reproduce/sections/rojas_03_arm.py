# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 3: from a straight arm to a bent one in four steps."""
from experiment import METHODS, markdown_table, worst

TITLE = "A bending arm (Rojas 2014, Fig. 3)"
DATA = ["mh_arm"]


def make(experiment):
    arms = experiment.meshes("mh_arm", "elbow_000", "elbow_1000")
    rows = []
    for method in METHODS:
        reports, frames = experiment.interpolate(method, arms, "--frames", 6, "--method", method)
        rows.append([method, f"{100 * worst(reports, 'edge_rms'):.2f} %",
                     f"{100 * worst(reports, 'edge_max'):.1f} %",
                     f"{worst(reports, 'dihedral_rms_deg'):.1f}"])
        if method == "dihedral":
            picture = experiment.draw("rojas_arm.png", frames, "--columns", 6, "--cell", 100)
    return f"""A real arm of 2,120 vertices with the elbow bent by 0 and by 100 degrees (the paper's has 2,502), and four steps between, by
`dihedral`. Both ends come from a skeleton; the paper's bent arm was then cleaned of self-intersections by hand, of which there is
nothing in these data.

{picture}

Largest errors of the four steps:

{markdown_table(["method", "edge RMS", "worst edge", "drift RMS [deg]"], rows)}
By `dihedral` all of the arm follows the bend and keeps its form, as in the paper. The elbow does not bend evenly with t: lengths are
blended, not angles. `closure`, the paper's method, does worse here than the paper reports for its own arm (worst edge 15 %, Fig. 12):
it ends in local minima, and what is left of E adds up along the arm.
"""
