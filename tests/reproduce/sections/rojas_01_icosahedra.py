# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 1: two icosahedra with the same lengths; who finds which from where."""
from experiment import METHODS, distance, edges_of, lengths_of, markdown_table

TITLE = "Two icosahedra with the same edge lengths (Rojas 2014, Fig. 1)"


def make(experiment):
    experiment.shape("synth", "icosahedron", "-o", "ico")
    files = ["ico/icosahedron_convex.ply", "ico/icosahedron_pushed.ply"]
    (convex, faces), (pushed, _) = map(experiment.mesh, files)
    edges = edges_of(faces)
    assert abs(lengths_of(convex, edges) - lengths_of(pushed, edges)).max() < 1e-14
    picture = experiment.draw("icosahedra.png", files, "--columns", 2, "--cell", 170, "--view", "20,35")
    columns = []
    for method in METHODS:
        reports, frames = experiment.interpolate(method, files, "--frames", 11, "--method", method)
        cells = []
        for report, frame in zip(reports, frames):
            points = experiment.mesh(frame)[0]
            off, name = min((distance(points, convex), "convex"), (distance(points, pushed), "pushed in"))
            cells.append(f"{name}, {off:.3f}; {100 * report['edge_max']:.2f} %")
        columns.append(cells)
    rows = [[f"{t / 10:.1f}", *cells] for t, cells in enumerate(zip(*columns))]
    return f"""The regular icosahedron and the one with its top vertex pushed in. Their {len(edges)} lengths are the same up to
rounding, so every blend of their lengths is that one vector, which both satisfy. What differs are the companion angles
that a solver starts from: (1 - t) times those of the convex one plus t times those of the other.

{picture}

Which of the two comes out, the largest distance of a vertex to it after alignment, and the worst relative edge error:

{markdown_table(["t", *METHODS], rows)}
The paper expects that "the only nearby minima for intermediate frames … would be the two input meshes". So it is: `closure`
ends at one of the two, to the digits shown, and at which is decided by the start: the convex one up to t = 0.5, then the
other. `dihedral` decides in the same way; it wants the angles as well, which no mesh with these lengths has, and
ends a few per cent of the radius beside the same icosahedron. `multiscale` moves the vertex straight through the plane of its
neighbours: continuous, with lengths that are wrong there. A path that is both continuous and of the right
lengths does not exist. Started from either icosahedron itself (t = 0 and 1) all three give it back.
"""
