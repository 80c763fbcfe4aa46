# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 10: the mean neutral face, and with mean differences added."""
from experiment import markdown_table

TITLE = "The mean face and mean differences (Rojas 2014, Fig. 10)"
DATA = ["ict_faces600"]


def make(experiment):
    faces = experiment.data / "ict_faces600"
    rows = []
    for expression in ("angry", "happy"):
        common = [faces, "--labels", faces / "labels.csv", "--pair-by", "subject", "--from",
                  "expression=neutral", "--to", f"expression={expression}", "-o", f"{expression}.h5"]
        for amount, name in ((0, "neutral"), (1, expression)):
            made = experiment.shape("difference", *common, "--apply", "--amount", amount, "--mesh",
                                    f"{name}.ply")
            if expression == "angry" or name == "happy":
                report = made["embeddings"][0]
                rows.append([name, report["status"], f"{100 * report['edge_rms']:.2f} %",
                             f"{100 * report['edge_max']:.1f} %", f"{report['dihedral_p99_deg']:.1f}"])
    picture = experiment.draw("rojas_new_faces.png", ["angry.ply", "neutral.ply", "happy.ply"],
                              "--columns", 3, "--cell", 220, "--view", "0,0")
    return f"""In the middle the mean of 200 neutral faces, beside it that plus the mean difference to angry and to happy: `shape difference
--apply`. None of them is a face of the data.

{picture}

{markdown_table(["mesh", "status", "edge RMS", "worst edge", "drift 99 % [deg]"], rows)}
The paper gives the picture alone.
"""
