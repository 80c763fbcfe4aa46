# SPDX-License-Identifier: MIT
"""What is measured of meshes, of pairs of them and of groups."""
from __future__ import annotations

from . import _arrays, _core
from ._collection import Collection, core_of
from ._errors import InvalidInput, warn
from ._mesh import MeshLike
from ._options import space_options
from ._results import Distances, Edges, Groups, PairTest, Test


def edges(mesh: MeshLike) -> Edges:
    """Edges of a mesh, their lengths and dihedral angles."""
    return Edges(*_core.measure(*_arrays.mesh(mesh, "mesh")))


def distance(meshes: Collection, metric: str = "edge-unit") -> Distances:
    """Distances between all meshes, as `shape distance --metric`.

    metric: "edge" (of edge lengths [length]), "edge-unit" (of edge lengths divided by their sum) or "procrustes"
    (root of the mean squared distance of corresponding vertices after generalised alignment of meshes of one size
    [length]). Raises InvalidInput if it is another.
    """
    spaces = {
        "edge": ("edge", "none"),
        "edge-unit": ("edge", "unit"),
        "procrustes": ("procrustes", "unit"),
    }
    core = core_of(meshes)
    if _arrays.text(metric, "metric") not in spaces:
        raise InvalidInput(f"metric: {metric!r} must be one of {', '.join(spaces)}")
    space, scale = spaces[metric]
    options = space_options(space, scale, "plain", False, 0.0, 0.0)
    matrix, warned = _core.distances(core, options)
    warn(warned)
    return Distances(meshes.names, matrix)


def groups(
    meshes: Collection,
    by: str,
    *,
    within: str = "",
    permutations: int = 999,
    replicates: int = 1000,
    seed: int = 1,
    space: str = "edge",
    scale: str = "unit",
    coordinates: str = "plain",
    area_weighted: bool = False,
    with_dihedrals: float = 0.0,
    with_positions: float = 0.0,
) -> Groups:
    """Do the mean shapes of groups differ? By permutation, as `shape groups`.

    by: label whose values are the groups, at least two. within: label of blocks, such as subjects, within which
    labels are permuted; where each block lies in one group, their means are compared. Distances and radii are of
    what is compared: each block counts once, and those of one group not at all where others have several. A mesh
    without a value of either is refused.
    permutations: of each test, at random, >= 0; the smallest p-value is 1 / (permutations + 1), or what the design
    allows (Test.smallest_p).
    replicates: draws of the bootstrap behind the radii of differences, >= 1; radii take 39 at the least.
    seed: of both, in [0, 2**64 - 1].
    space: "edge" (edge lengths) or "procrustes" (vertex positions after generalised Procrustes alignment), where
    what follows scale stays as it is.
    scale: "unit" (every mesh is brought to one size) or "none" (size is part of the shape).
    coordinates: "plain", "squared" or "log", the function of the edge lengths that is the coordinate.
    area_weighted: lengths are weighted by the share of the mean's area around their edges.
    with_dihedrals: > 0: dihedral angles are coordinates too, and 1 rad counts as much as a relative change of
    length by this; at most 1e6.
    with_positions: > 0: aligned positions are coordinates too, and moving all vertices by 1 % of the diagonal
    counts as much as changing all lengths by this number of percent; at most 1e6.
    Warns of meshes that look like repeated measurements, and of a slip that leaves most of them out, as the program
    does. Raises InvalidInput if a rule is broken, or there are no more meshes (or blocks, if their means are compared)
    than groups.
    """
    chosen = space_options(space, scale, coordinates, area_weighted, with_dihedrals, with_positions)
    names, counts, overall, pairs, is_crossed, left_out, warned = _core.groups(
        core_of(meshes),
        _arrays.text(by, "by"),
        _arrays.text(within, "within"),
        chosen,
        _arrays.integer(permutations, "permutations", 0),
        _arrays.integer(replicates, "replicates", 1),
        _arrays.seed(seed),
    )
    warn(warned)
    return Groups(
        tuple(names),
        tuple(counts),
        "crossed" if is_crossed else "nested",
        left_out,
        Test(**overall),
        tuple(
            PairTest(
                first, second, apart, radius, "crossed" if is_within else "nested", Test(**test), adjusted
            )
            for first, second, apart, radius, test, adjusted, is_within in pairs
        ),
    )
