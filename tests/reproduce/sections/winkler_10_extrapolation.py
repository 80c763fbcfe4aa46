# SPDX-License-Identifier: MIT
"""Winkler 2010, Fig. 10 and 11: beyond the inputs."""
from experiment import markdown_table, worst

TITLE = "Extrapolation (Winkler 2010, Fig. 10, 11)"
DATA = ["mh_body_poses"]


def make(experiment):
    experiment.shape("synth", "arm", "--count", 7, "-o", "arm")
    pairs = {"tube": (["arm/arm_straight.ply", "arm/arm_0001.ply"], (0, 1, 2, 3, 4)),
             "body": (experiment.meshes("mh_body_poses", "rest", "twist"), (-0.25, 0, 0.5, 1, 1.25))}
    rows, pictures = [], []
    for name, (meshes, places) in pairs.items():
        weights = [word for t in places for word in ("--weights", f"{1 - t},{t}")]
        for method in ("multiscale", "dihedral"):
            made = experiment.shape("interpolate", *meshes, "-o", f"{name}_{method}/", "--extrapolate",
                                    "--method", method, *weights)
            reports = made["embeddings"]
            rows.append([name, method, f"{100 * worst(reports, 'edge_rms'):.2f} %",
                         f"{100 * worst(reports, 'edge_max'):.1f} %", f"{worst(reports, 'dihedral_p99_deg'):.1f}"])
            if method == "multiscale":
                frames = sorted((experiment.folder / f"{name}_{method}").glob("*.ply"))
                pictures.append(experiment.draw(f"winkler_beyond_{name}.png", frames, "--columns", 5,
                                                "--cell", 100))
    newline = "\n"
    return f"""Above, a straight arm and one bent by 15 degrees (both inputs, on the left), and t = 2, 3, 4. Below, a body at rest and twisted:
t = -0.25, 0, 0.5, 1, 1.25. By `multiscale`.

{newline.join(pictures)}

{markdown_table(["meshes", "method", "edge RMS", "worst edge", "drift 99 % [deg]"], rows)}
The paper goes beyond until triangles or angles break; here the program says before how far that is (`safe_range`,
[interpolation.md](interpolation.md#beyond-the-inputs)) and refuses to go on unless told to.
"""
