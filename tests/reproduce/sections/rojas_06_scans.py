# SPDX-License-Identifier: MIT
"""Rojas 2014, section 4 and Fig. 6: from raw scans with eight landmarks to a smile."""
from experiment import edges_of, lengths_of, markdown_table, np

TITLE = "From raw scans to a smile (Rojas 2014, section 4 and Fig. 6)"
PEOPLE = 5


def edge_errors(experiment, folder, names):
    """RMS of edge lengths against the truth, over the mean length, of every fit."""
    errors = []
    for name in names:
        truth, faces = experiment.mesh(f"raw/truth/{name}.ply")
        fit, _ = experiment.mesh(f"{folder}/{name}.ply")
        edges = edges_of(faces)
        length = lengths_of(truth, edges)
        errors.append(np.sqrt(((lengths_of(fit, edges) - length) ** 2).mean()) / length.mean())
    return errors


def smile(experiment, collection, model):
    """Shares of the first three modes; the mean of the neutral faces with the mean smile becomes MODEL_smile.ply."""
    experiment.shape("stats", collection, "-o", f"{model}.h5")
    shares = [mode["share"] for mode in experiment.shape("info", f"{model}.h5")["modes"][:3]]
    experiment.shape("difference", collection, "--pair-by", "subject", "--from", "expression=neutral", "--to",
                     "expression=happy", "-o", f"{model}_smile.h5", "--apply", "--mesh", f"{model}_smile.ply")
    return shares


def make(experiment):
    experiment.shape("synth", "scans", "--count", PEOPLE, "--noise", 0.15, "--holes", 3, "-o", "raw")
    names = [row["mesh"] for row in experiment.table("raw/labels.csv")]
    rows = []
    for title, folder, rounds in (("fits", "first", 0), ("fits after two rounds", "again", 2)):
        report = experiment.shape("fit", "raw/template.ply", "raw/scans", "--landmarks", "raw/landmarks.csv",
                                  "-o", folder, "--rounds", rounds)
        done = [scan["scan"] for scan in report["scans"] if scan["status"] != "failed"]
        error = np.mean(edge_errors(experiment, folder, done))
        experiment.shape("collect", folder, "--labels", "raw/labels.csv", "-o", f"{folder}.h5")
        shares = smile(experiment, f"{folder}.h5", folder)
        rows.append([title, report["good"], report["check"], report["failed"], f"{100 * error:.1f} %",
                     *(f"{100 * share:.1f} %" for share in shares)])
    experiment.shape("collect", "raw/truth", "--labels", "raw/labels.csv", "-o", "truth.h5")
    shares = smile(experiment, "truth.h5", "truth")
    rows.append(["true correspondence", "", "", "", "", *(f"{100 * share:.1f} %" for share in shares)])
    picture = experiment.draw("rojas_scans.png", ["raw/template.ply", "truth_smile.ply", "first_smile.ply",
                                                  "again_smile.ply"], "--columns", 4, "--cell", 160, "--view", "0,0")
    table = markdown_table(["", "good", "to check", "failed", "edges against the truth, RMS", "mode 1", "mode 2",
                            "mode 3"], rows)
    return f"""{len(names)} synthetic faces of {PEOPLE} people, each remeshed, with noise of 0.15 edges and three holes
(`shape synth scans`), fitted with eight landmarks; the mean smile of each collection put on the mean of its neutral faces. By one command:
`tests/reproduce/run rojas_06_scans`.

{table}
{picture}

From the left: the template; its smile from the true correspondence, from the fits, from the fits after two rounds.
"""
