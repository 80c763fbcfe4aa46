# SPDX-License-Identifier: MIT
"""Options that several functions take."""
from __future__ import annotations

from typing import Optional

from . import _arrays, _core


def embedding_options(
    method: str,
    quality: str,
    smoothness: Optional[float],
    avoid_contact: bool,
    seed: int,
) -> _core.EmbeddingOptions:
    return _core.EmbeddingOptions(
        _arrays.text(method, "method"),
        _arrays.text(quality, "quality"),
        float("nan") if smoothness is None else _arrays.finite_number(smoothness, "smoothness"),
        _arrays.seed(seed),
        _arrays.flag(avoid_contact, "avoid_contact"),
    )


def space_options(
    space: str,
    scale: str,
    coordinates: str,
    area_weighted: bool,
    with_dihedrals: float,
    with_positions: float,
) -> _core.SpaceOptions:
    return _core.SpaceOptions(
        _arrays.text(space, "space"),
        _arrays.text(scale, "scale"),
        _arrays.text(coordinates, "coordinates"),
        _arrays.flag(area_weighted, "area_weighted"),
        _arrays.number(with_dihedrals, "with_dihedrals"),
        _arrays.number(with_positions, "with_positions"),
    )
