# SPDX-License-Identifier: MIT
"""Differences between two groups."""
from __future__ import annotations

import warnings
from functools import cached_property
from typing import Any, List, Optional, Tuple

import numpy as np

from . import _arrays, _core, _files, _labels
from ._arrays import Array, Indices, Path
from ._collection import Collection, core_of
from ._errors import warn
from ._mesh import Mesh, MeshLike, name_of, read_only
from ._options import embedding_options, space_options
from ._results import Report


class Difference:
    """The mean difference between two groups. ``difference()`` and ``read_difference()`` make one."""

    def __init__(self, core: _core.Difference) -> None:
        self._core = core

    @cached_property
    def F(self) -> Indices:
        """(m, 3) faces; read-only."""
        return read_only(self._core.faces())

    def __reduce__(self) -> Tuple[Any, ...]:
        return _difference_of_bytes, (_files.bytes_of(self._core.write),)

    @cached_property
    def pairs(self) -> Tuple[str, ...]:
        """Values of the label that pairs; none if the groups are not paired."""
        return tuple(self._core.pairs)

    @property
    def lengths(self) -> Array:
        """(#E,) mean of `to` minus mean of `from`; a view."""
        return self._core.edge_lengths

    @property
    def dihedral_angles(self) -> Array:
        """(#E,) the same of dihedral angles [rad]; a view."""
        return self._core.dihedral_angles

    def apply(
        self,
        onto: Optional[MeshLike] = None,
        amount: float = 1.0,
        *,
        method: str = "dihedral",
        quality: str = "",
        smoothness: Optional[float] = None,
        avoid_contact: bool = False,
        seed: int = 1,
    ) -> Tuple[Mesh, Report]:
        """A mesh with so much of the difference added, as `shape difference --apply`, to the same bits.

        onto: where it starts, a mesh with the faces F, whose size (scale "unit") and place are kept; default: the
        mean of `from`. A mirror image of the meshes of the difference is warned of, and with scale "none" one far larger
        or smaller. amount: how much of the difference, any finite number.
        method: how lengths and angles become a mesh: "dihedral" (both together), "closure" (Rojas 2014,
        section 2) or "multiscale" (Winkler 2010, section 3).
        quality: of the method dihedral: "preview" (a few steps) or "fine" (to convergence, the default).
        smoothness: of the method dihedral: weight of the dihedral angles [rad] against the relative lengths, > 0;
        default 0.005.
        avoid_contact: bend the mesh a little where faces cross that cross in no input, until they no longer do.
        seed: in [0, 2**64 - 1], by which the method multiscale draws its patches; the others draw nothing.
        Where no mesh has the lengths the nearest comes out, and the report says so. Raises InvalidInput if a rule is
        broken, an option is of another method or faces differ; NumericalError if a factorisation breaks down.
        """
        share = _arrays.finite_number(amount, "amount")
        starts: List[Array] = []
        name = "applied"
        if onto is not None:
            vertices, corners = _arrays.mesh(onto, "onto")
            if not np.array_equal(corners, self.F):
                known = self._core.reference_points()
                _core.check_same_faces(vertices, corners, "onto", known, self.F, "the difference")
            starts = [_arrays.finite(vertices, "onto.V")]
            name = name_of(onto, name)
        ((points, figures),), warned = _core.apply(
            self._core,
            starts,
            [name] if starts else [],
            share,
            embedding_options(method, quality, smoothness, avoid_contact, seed),
            None,
        )
        for text in warned:
            warnings.warn(text, stacklevel=2)
        return Mesh(points, self.F, name), Report(**figures)

    def write(self, path: Path) -> None:
        """Writes a difference file (.h5) that the program reads; a file that is there is replaced."""
        self._core.write(_arrays.path_ending(path, ".h5"))

    def __repr__(self) -> str:
        of = f"{len(self.pairs)} pairs" if self.pairs else "two groups without pairs"
        return f"Difference({of}, norm {float(np.linalg.norm(self.lengths)):.4g})"


def difference(
    meshes: Collection, from_: str, to: str, *, pair_by: str = "", scale: str = "unit"
) -> Difference:
    """The mean difference between two groups, as `shape difference`.

    from_, to: "LABEL=VALUE". pair_by: meshes with the same value of this label are a pair, others are left out;
    default: the means of the groups are compared. scale: "unit" (lengths are divided by their sum; what is added
    keeps the size of a mesh) or "none" (lengths stay as they are). Warns where, without pairs, meshes look like repeated
    measurements of some more often than of others. Raises InvalidInput if a rule is broken or a
    group has no mesh.
    """
    space_options("edge", scale, "plain", False, 0.0, 0.0)  # refuses an unknown scale
    core, warned = _core.difference(
        core_of(meshes),
        _arrays.text(pair_by, "pair_by"),
        _labels.label_and_value(from_, "from_"),
        _labels.label_and_value(to, "to"),
        scale,
    )
    warn(warned)
    return Difference(core)


def read_difference(path: Path, *, untrusted: bool = False) -> Difference:
    """Reads a difference of `shape difference` or Difference.write(). untrusted: as of read()."""
    file = _arrays.path(path)
    with _files.isolated(untrusted):
        return Difference(_core.read_difference(file))


def _difference_of_bytes(content: bytes) -> Difference:
    return Difference(_files.of_bytes(content, _core.read_difference))
