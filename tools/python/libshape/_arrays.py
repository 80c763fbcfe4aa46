# SPDX-License-Identifier: MIT
"""Arguments on their way in: what they must be, said with their name and shape."""
from __future__ import annotations

import os
from typing import Any, Callable, Dict, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Path = Union[str, "os.PathLike[str]"]
Columns = Dict[str, Any]  #: Name -> values, all of one length.
Progress = Union[None, bool, Callable[[str, int, int], object]]


def points(value: Any, name: str) -> Array:
    """(n, 3) float64, row-major; not copied if it is that already."""
    array = numbers(value, name)
    if array.ndim != 2 or array.shape[1] != 3:
        raise TypeError(f"{name}: shape must be (n, 3), is {array.shape}")
    return array


def faces(value: Any, name: str) -> Indices:
    """(m, 3) int64, row-major; not copied if it is that already."""
    try:
        array = np.asarray(value)
    except ValueError:
        raise TypeError(f"{name}: must be an array of integers of shape (m, 3)") from None
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name}: must hold integers, holds {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise TypeError(f"{name}: shape must be (m, 3), is {array.shape}")
    return np.ascontiguousarray(array, dtype=np.int64)


def vector(value: Any, name: str) -> Array:
    """(k,) float64."""
    array = numbers(value, name)
    if array.ndim != 1:
        raise TypeError(f"{name}: shape must be (k,), is {array.shape}")
    return array


def numbers(value: Any, name: str) -> Array:
    if type(value) is np.ndarray and value.dtype == np.float64 and value.flags.c_contiguous:
        return value
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "iufb":
            raise ValueError
    except ValueError:
        raise TypeError(
            f"{name}: must be an array of numbers, is {type(value).__name__}"
        ) from None
    return np.ascontiguousarray(array, dtype=np.float64).reshape(array.shape)


def mesh(value: Any, name: str) -> Tuple[Array, Indices]:
    """(V, F) of a pair, or of the mesh of another library."""
    if hasattr(value, "V") and hasattr(value, "F"):
        found: Tuple[Any, Any] = (value.V, value.F)
    elif isinstance(value, (tuple, list)) and len(value) == 2:
        found = (value[0], value[1])
    elif hasattr(value, "vertices") and hasattr(value, "faces"):  # trimesh
        found = (value.vertices, value.faces)
    elif hasattr(value, "points") and hasattr(value, "cells_dict"):  # meshio
        if set(value.cells_dict) != {"triangle"}:
            raise TypeError(f"{name}: its cells are {sorted(value.cells_dict)}, must be triangles")
        found = (value.points, value.cells_dict["triangle"])
    elif hasattr(value, "points") and hasattr(value, "regular_faces"):  # pyvista
        found = (value.points, value.regular_faces)
    else:
        raise TypeError(f"{name}: must be a Mesh or a pair (V, F), is {type(value).__name__}")
    return points(found[0], f"{name}.V"), faces(found[1], f"{name}.F")


def label_value(text: str, name: str) -> Tuple[str, str]:
    """Label and value of "LABEL=VALUE", as the program takes them."""
    label, sign, value = text.partition("=") if isinstance(text, str) else ("", "", "")
    if not (label and sign and value):
        raise TypeError(f"{name}: must be 'LABEL=VALUE', is {text!r}")
    return label, value


class _Bar:
    """A bar of tqdm, one for each stage."""

    def __init__(self, tqdm: Any) -> None:
        self._tqdm = tqdm
        self._bar: Any = None
        self._stage = ""

    def __call__(self, stage: str, done: int, total: int) -> None:
        if self._bar is None or stage != self._stage:
            if self._bar is not None:
                self._bar.close()
            self._bar = self._tqdm(total=total, desc=stage)
            self._stage = stage
        self._bar.update(done - self._bar.n)
        if done >= total:
            self._bar.close()
            self._bar = None


def progress(value: Progress) -> Optional[Callable[[str, int, int], object]]:
    if value is None or value is False:
        return None
    if value is True:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            return None
        return _Bar(tqdm)
    if not callable(value):
        raise TypeError(f"progress: must be None, True or a function, is {type(value).__name__}")
    return value


def data_frame(columns: Columns) -> Any:
    """A table of pandas."""
    try:
        import pandas
    except ImportError:
        raise ImportError(
            "tables need pandas (python3-pandas); as_dict() has the same columns without it"
        ) from None
    return pandas.DataFrame(columns)
