# SPDX-License-Identifier: MIT
"""What is measured of meshes, of pairs of them and of groups."""
from __future__ import annotations

from . import _arrays, _core
from ._collection import Collection, core_of
from ._errors import InvalidInput
from ._mesh import MeshLike
from ._options import space_options
from ._results import Distances, Edges, Groups, PairTest, Test


def edges(mesh: MeshLike) -> Edges:
    """Edges of a mesh, their lengths and dihedral angles."""
    return Edges(*_core.measure(*_arrays.mesh(mesh, "mesh")))


def distance(meshes: Collection, metric: str = "edge-unit") -> Distances:
    """Distances between all meshes, as `shape distance --metric`: edge, edge-unit or procrustes."""
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
    return Distances(meshes.names, _core.distances(core, options))


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

    by: label whose values are the groups. within: label of blocks, such as subjects, within which labels
    are permuted. A mesh without a value of either is refused. replicates: draws of the bootstrap behind
    the radii of differences.
    """
    chosen = space_options(space, scale, coordinates, area_weighted, with_dihedrals, with_positions)
    names, counts, overall, pairs = _core.groups(
        core_of(meshes),
        _arrays.text(by, "by"),
        _arrays.text(within, "within"),
        chosen,
        _arrays.integer(permutations, "permutations", 0),
        _arrays.integer(replicates, "replicates", 1),
        _arrays.seed(seed),
    )
    return Groups(
        tuple(names),
        tuple(counts),
        Test(**overall),
        tuple(
            PairTest(first, second, apart, radius, Test(**test), adjusted)
            for first, second, apart, radius, test, adjusted in pairs
        ),
    )
