# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 6: from one expression to another."""
from experiment import worst

TITLE = "A change of expression (Rojas 2014, Fig. 6)"
DATA = ["ict_faces_full"]


def make(experiment):
    faces = experiment.meshes("ict_faces_full", "s008_neutral", "s008_happy")
    reports, frames = experiment.interpolate("smile", faces, "--frames", 5)
    picture = experiment.draw("rojas_smile.png", frames, "--columns", 5, "--cell", 100, "--view", "0,0")
    return f"""Neutral to happy, a face of 9,409 vertices that comes in correspondence (the paper fits its scans first).

{picture}

Edge RMS at most {100 * worst(reports, 'edge_rms'):.2f} %, worst edge {100 * worst(reports, 'edge_max'):.1f} %.
"""
