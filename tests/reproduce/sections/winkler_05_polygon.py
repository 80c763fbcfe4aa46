# SPDX-License-Identifier: MIT
"""Winkler 2010, Fig. 5: a point moves in a polygon of meshes."""
from experiment import markdown_table, worst

TITLE = "A polygon of poses (Winkler 2010, Fig. 5)"
DATA = ["mh_hand"]
POSES = ("fist_0", "point", "victory", "hook", "thumb_in")


def make(experiment):
    hands = experiment.meshes("mh_hand", *POSES)
    track = ["--path", "polygon", "--track", "0.4,0:0.12,0.38:-0.32,0.23:-0.32,-0.23:0.12,-0.38", "--frames", 5]
    rows = []
    for method in ("multiscale", "dihedral"):
        reports, frames = experiment.interpolate(method, hands, *track, "--method", method)
        rows.append([method, f"{100 * worst(reports, 'edge_rms'):.2f} %",
                     f"{100 * worst(reports, 'edge_max'):.1f} %", f"{worst(reports, 'dihedral_p99_deg'):.1f}"])
        if method == "multiscale":
            picture = experiment.draw("winkler_polygon.png", [*hands, *frames], "--columns", 5,
                                      "--cell", 100)
    return f"""Five poses of a hand at the corners of a regular pentagon
({', '.join(f'`{pose}`' for pose in POSES)}; first row) and five places on a way
around its middle, 0.4 from it (second row), by `multiscale`. Weights are mean value coordinates, as in the paper, which shows its user interface and no figures.

{picture}

{markdown_table(["method", "edge RMS", "worst edge", "drift 99 % [deg]"], rows)}"""
