# SPDX-License-Identifier: MIT
"""Arguments on their way in: what they must be, said with their name and what came."""
from __future__ import annotations

import os
from typing import Any, Callable, Dict, Iterable, List, Mapping, Optional, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._errors import InvalidInput

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Path = Union[str, "os.PathLike[str]"]
Columns = Dict[str, Any]  #: Name -> values, all of one length.
Progress = Union[None, bool, Callable[[str, int, int], object]]


def shown(value: Any) -> str:
    """A value in a message: its type, and itself if that is short."""
    kind = type(value).__name__
    text = repr(value) if isinstance(value, (str, int, float, bytes)) else ""
    return f"{kind} {text}" if 0 < len(text) <= 60 else kind


def integer(value: Any, name: str, least: int = -(2**31), most: int = 2**31 - 1) -> int:
    if isinstance(value, (bool, np.bool_)) or not hasattr(value, "__index__"):
        raise TypeError(f"{name}: must be a whole number, is {shown(value)}")
    number = int(value.__index__())
    if not least <= number <= most:
        rule = f"at least {least}" if number < least else f"at most {most}"
        raise InvalidInput(f"{name}: is {number}, must be {rule}")
    return number


def seed(value: Any) -> int:
    return integer(value, "seed", 0, 2**64 - 1)


def number(value: Any, name: str) -> float:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise TypeError(f"{name}: must be a number, is {shown(value)}")
    return float(value)


def finite_number(value: Any, name: str) -> float:
    return float(finite(np.asarray(number(value, name)), name))


def flag(value: Any, name: str) -> bool:
    if not isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name}: must be True or False, is {shown(value)}")
    return bool(value)


def text(value: Any, name: str) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{name}: must be a str, is {shown(value)}")
    return value


def texts(value: Any, name: str) -> List[str]:
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise TypeError(f"{name}: must be a list of str, is {shown(value)}")
    return [text(item, f"{name}[{i}]") for i, item in enumerate(value)]


def path(value: Any, name: str = "path") -> str:
    found = os.fspath(value) if isinstance(value, (str, os.PathLike)) else None
    if not isinstance(found, str):
        raise TypeError(f"{name}: must be a str or a path, is {shown(value)}")
    if not found or "\0" in found:
        raise InvalidInput(f"{name}: {found!r} names no file")
    return found


def path_ending(value: Any, ending: str, name: str = "path") -> str:
    """A path of a file that is written in one format."""
    found = path(value, name)
    if not found.lower().endswith(ending):
        raise InvalidInput(f"{name}: {found!r} must end in {ending}")
    return found


def points(value: Any, name: str) -> Array:
    """(n, 3) float64, row-major; not copied if it is that already."""
    array = numbers(value, name)
    if array.ndim != 2 or array.shape[1] != 3:
        raise TypeError(f"{name}: shape must be (n, 3), is {array.shape}")
    return array


def faces(value: Any, name: str) -> Indices:
    """(m, 3) int64, row-major; not copied if it is that already."""
    refuse_masked(value, name)
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
    refuse_masked(value, name)
    try:
        array = np.asarray(value)
    except (ValueError, TypeError):  # lists of unequal lengths, and what is no array at all
        raise TypeError(f"{name}: must be an array of numbers, is {shown(value)}") from None
    if array.dtype.kind not in "iufb":
        of = f" of dtype {array.dtype} and shape {array.shape}" if array.ndim > 0 else ""
        raise TypeError(f"{name}: must be an array of numbers, is {shown(value)}{of}")
    return np.ascontiguousarray(array, dtype=np.float64).reshape(array.shape)


def finite(array: Array, name: str) -> Array:
    if not np.isfinite(array).all():
        place = np.argwhere(~np.isfinite(array))[0]
        at = f"[{', '.join(str(i) for i in place)}]" if array.ndim else ""
        raise InvalidInput(f"{name}{at}: is {array[tuple(place)]}, must be finite")
    return array


def refuse_masked(value: Any, name: str) -> None:
    if isinstance(value, np.ma.MaskedArray):
        count = int(np.asarray(value.mask).sum())
        if count > 0:
            raise InvalidInput(f"{name}: is a masked array in which {count} are masked")


def _is_matrix(value: Any) -> bool:
    try:
        return np.ndim(value) == 2
    except ValueError:  # rows of unequal lengths
        return False


def mesh_parts(value: Any) -> Optional[Tuple[Any, Any]]:
    """V and F of a pair, or of the mesh of this or another library; None: it is not a mesh."""
    if hasattr(value, "V") and hasattr(value, "F"):
        return value.V, value.F
    if isinstance(value, (tuple, list)):
        return (value[0], value[1]) if len(value) == 2 and _is_matrix(value[0]) else None
    if hasattr(value, "vertices") and hasattr(value, "faces"):  # trimesh
        return value.vertices, value.faces
    if hasattr(value, "points") and hasattr(value, "cells_dict"):  # meshio
        if set(value.cells_dict) != {"triangle"}:
            raise TypeError(f"its cells are {sorted(value.cells_dict)}, must be triangles")
        return value.points, value.cells_dict["triangle"]
    if hasattr(value, "points") and hasattr(type(value), "regular_faces"):  # pyvista
        try:
            return value.points, value.regular_faces
        except ValueError:
            raise TypeError("its faces must be triangles") from None
    if hasattr(value, "points") and hasattr(value, "regular_faces"):
        return value.points, value.regular_faces
    return None


def is_mesh(value: Any) -> bool:
    try:
        return mesh_parts(value) is not None
    except TypeError:  # one of another library that is not of triangles
        return True


def mesh(value: Any, name: str) -> Tuple[Array, Indices]:
    """(V, F) of a pair, or of the mesh of another library."""
    try:
        found = mesh_parts(value)
    except TypeError as error:
        raise TypeError(f"{name}: {error}") from None
    if found is None and isinstance(value, (tuple, list)) and len(value) == 2:
        found = (value[0], value[1])  # says what is wrong with V
    if found is None:
        raise TypeError(f"{name}: must be a Mesh or a pair (V, F), is {shown(value)}")
    return points(found[0], f"{name}.V"), faces(found[1], f"{name}.F")


def columns(value: Any, name: str) -> List[Tuple[str, Any]]:
    """Columns of a mapping or of a table of pandas."""
    if value is None:
        return []
    if not isinstance(value, Mapping) and not (hasattr(value, "columns") and hasattr(value, "items")):
        raise TypeError(f"{name}: must map names to values (dict, DataFrame), is {shown(value)}")
    return [(text(column, f"{name}: name of a column"), values) for column, values in value.items()]


def cells(values: Any, name: str) -> List[str]:
    """Values of a label as cells of a table. What is missing is a word that docs/formats.md lists."""
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise TypeError(f"{name}: must be a sequence of values, is {shown(values)}")
    if isinstance(values, np.ma.MaskedArray):
        masked: Any = values
        values = masked.tolist()  # None where masked
    return [
        "" if value is None or type(value).__name__ == "NaTType" else str(value) for value in values
    ]


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
        raise TypeError(f"progress: must be None, True or a function, is {shown(value)}")
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
