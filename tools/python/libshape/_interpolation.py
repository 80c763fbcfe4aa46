# SPDX-License-Identifier: MIT
"""Blends of meshes."""
from __future__ import annotations

from typing import Any, Optional

import numpy as np

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
    progress: Progress = None,
) -> Frames:
    """Blends of two or more meshes in edge-length space, the same bits as `shape interpolate`.

    frames: the number of frames along the straight lines that join the meshes in order, both ends
    included. Or weights: (frames, meshes), rows that sum to 1.
    """
    if len(meshes) == 1 and isinstance(meshes[0], Collection):
        together = meshes[0]
    elif len(meshes) < 2:
        came = f"there is one, {_arrays.shown(meshes[0])}" if meshes else "there is none"
        raise TypeError(
            f"meshes: give two or more, one by one (interpolate(*meshes)), or a Collection; {came}"
        )
    else:
        together, _ = gather(meshes, None, [f"mesh_{i:04}" for i in range(len(meshes))], None)
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
        rows = np.array([_core.line_weights(count, i / (frames - 1)) for i in range(frames)])
    else:
        rows = _arrays.finite(_arrays.numbers(weights, "weights"), "weights")
        if rows.ndim != 2 or rows.shape[1] != count:
            raise TypeError(f"weights: shape must be (frames, {count}), is {rows.shape}")
    made = _core.interpolate(
        together._core,
        list(rows),
        weights is None,
        _arrays.flag(squared, "squared"),
        embedding_options(method, quality, smoothness, avoid_contact),
        _arrays.progress(progress),
    )
    return Frames(
        [Mesh(points, together.F, f"frame_{i:04}") for i, (points, _) in enumerate(made)],
        [Report(**figures) for _, figures in made],
        rows,
    )
