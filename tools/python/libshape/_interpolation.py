# SPDX-License-Identifier: MIT
"""Blends of meshes."""
from __future__ import annotations

import warnings
from typing import Any, List, Optional

from . import _arrays, _core
from ._arrays import Progress
from ._collection import Collection, gather
from ._errors import InvalidInput
from ._mesh import Mesh, MeshLike
from ._options import embedding_options
from ._results import Frames, Report


def interpolate(
    *meshes: MeshLike,
    frames: int = 0,
    weights: Any = None,
    squared: bool = False,
    method: str = "dihedral",
    quality: str = "",
    smoothness: Optional[float] = None,
    avoid_contact: bool = False,
    seed: int = 1,
    progress: Progress = None,
) -> Frames:
    """Blends of two or more meshes in edge-length space, at single places or along a path.

    meshes: with the same faces, one by one or as a Collection. A blend is turned and placed as the first mesh is,
    a further frame of a path as the one before it.
    frames: this many, at least 2, equally spaced along the straight lines that join the meshes in order, each as
    long as the others, both ends included. weights: instead of frames, (frames, meshes); each row sums to 1, within
    1e-9. Beyond [0, 1] no mesh may have the lengths.
    squared: squared lengths are combined (Rojas 2014, section 6) instead of lengths.
    method: how lengths and angles become a mesh: "dihedral" (both together), "closure" (Rojas 2014,
    section 2) or "multiscale" (Winkler 2010, section 3).
    quality: of the method dihedral: "preview" (a few steps) or "fine" (to convergence, the default).
    smoothness: of the method dihedral: weight of the dihedral angles [rad] against the relative lengths, > 0;
    default 0.005.
    avoid_contact: bend the mesh a little where faces cross that cross in no input, until they no longer do.
    seed: in [0, 2**64 - 1], by which the method multiscale draws its patches; the others draw nothing.

    The same bits as `shape interpolate` with --frames or --weights. By the method dihedral, fine, 31 frames and more
    are a motion, whose neighbours agree on folds (docs/embedding.md); fewer, and blends by weights, are embedded each
    by itself.
    Where no mesh has the lengths the nearest comes out, and its report says so. What is odd about meshes that are
    given one by one is warned of, but for copies: a path may come back. Raises InvalidInput if a rule is broken, an
    option is of another method or faces differ; NumericalError if a factorisation breaks down.
    """
    warned: List[str] = []
    if len(meshes) == 1 and isinstance(meshes[0], Collection):
        together = meshes[0]
    elif len(meshes) < 2:
        came = f"there is one, {_arrays.shown(meshes[0])}" if meshes else "there is none"
        raise TypeError(
            f"meshes: give two or more, one by one (interpolate(*meshes)), or a Collection; {came}"
        )
    else:
        names = [f"mesh_{i:04}" for i in range(len(meshes))]
        together, warned = gather(meshes, None, names, None, may_repeat=True)
    count = len(together)
    frames = _arrays.integer(frames, "frames")
    if (frames != 0) == (weights is not None):
        given = "not given" if weights is None else "given too"
        raise TypeError(f"frames, weights: frames is {frames}, weights are {given}; give one of them")
    if weights is None:
        if frames < 2:
            raise InvalidInput(f"frames: is {frames}, must be at least 2")
        if count < 2:
            raise InvalidInput(f"meshes: there is {count}, there must be at least 2")
        rows = _core.line_weights(count, frames)
    else:
        rows = _arrays.finite(_arrays.numbers(weights, "weights"), "weights")
        if rows.ndim != 2 or rows.shape[1] != count:
            raise TypeError(f"weights: shape must be (frames, {count}), is {rows.shape}")
    squared = _arrays.flag(squared, "squared")
    options = embedding_options(method, quality, smoothness, avoid_contact, seed)
    told = _arrays.progress(progress)
    for text in warned:
        warnings.warn(text, stacklevel=2)
    made = _core.interpolate(together._core, list(rows), weights is None, squared, options, told)
    return Frames(
        [Mesh(points, together.F, f"frame_{i:04}") for i, (points, _) in enumerate(made)],
        [Report(**figures) for _, figures in made],
        rows,
    )
