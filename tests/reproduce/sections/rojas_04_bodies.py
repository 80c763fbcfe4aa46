# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 4: a circle in the patch between four poses."""
import math

from experiment import worst

TITLE = "Four poses at the corners of a patch (Rojas 2014, Fig. 4)"
DATA = ["mh_body_poses"]
POSES = ("rest", "arms_up", "squat", "kick")


def make(experiment):
    poses = experiment.meshes("mh_body_poses", *POSES)
    places = []
    for step in range(8):
        angle = math.pi * (1.25 + step / 4)
        places += ["--at", f"{0.5 + 0.5 * math.cos(angle):.6f},{0.5 + 0.5 * math.sin(angle):.6f}"]
    reports, blends = experiment.interpolate("circle", poses, "--path", "bilinear", *places)
    picture = experiment.draw("rojas_bodies.png", [*poses, *blends], "--columns", 4, "--cell", 100,
                              "--view", "0,0")
    return f"""The paper has a centaur; here it is a body of 13,380 vertices. First row the corners ({', '.join(f'`{pose}`' for pose in POSES)}), below eight places on
the circle that touches the sides of the patch, counter-clockwise from nearest the first corner.

{picture}

Edge RMS at most {100 * worst(reports, 'edge_rms'):.2f} %, worst edge {100 * worst(reports, 'edge_max'):.1f} %; the paper gives E = 2.601, its largest, and no edge errors.
Limbs stay of one thickness and length in all places. The same with sixteen synthetic arms is in
[interpolation.md](interpolation.md#four-arms-as-a-patch-three-hands-along-a-spline).
"""
