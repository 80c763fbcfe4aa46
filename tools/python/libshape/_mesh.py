# SPDX-License-Identifier: MIT
"""Meshes."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Iterator, Optional

import numpy as np

from . import _arrays, _core
from ._arrays import Array, Indices, Path
from ._errors import InvalidInput


@dataclass(frozen=True, eq=False)
class Mesh:
    """Vertices and faces. Unpacks: ``V, F = mesh``; ``trimesh.Trimesh(*mesh)``."""

    V: Array  #: (n, 3) float64 [unit of the input]
    F: Indices  #: (m, 3) int64, counter-clockwise seen from outside
    name: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "V", _arrays.points(self.V, "V"))
        object.__setattr__(self, "F", _arrays.faces(self.F, "F"))

    def __iter__(self) -> Iterator["np.ndarray[Any, np.dtype[Any]]"]:
        yield self.V
        yield self.F

    def __repr__(self) -> str:
        name = f"{self.name!r}, " if self.name else ""
        return f"Mesh({name}{len(self.V)} vertices, {len(self.F)} faces)"

    def write(
        self,
        path: Path,
        *,
        ascii: bool = False,
        float32: bool = False,
        scalars: Any = None,
        quality: str = "",
        colors: Any = None,
        template: Optional[Path] = None,
    ) -> None:
        """Writes a mesh file; the ending names the format: .obj .ply .off .stl .vtk .vtp .glb.

        A file that is there is replaced. scalars: name -> (n,) numbers at the vertices (.ply .vtk .vtp), a dict
        or a DataFrame. quality: the one of them that a .ply
        file holds once more as `quality`, the name that most programs show. colors: (n, 3) uint8.
        template: an OBJ file of the same faces, whose texture coordinates, materials and polygons
        an .obj file is written with.
        """
        values = [
            (name, _arrays.vector(array, f"scalars[{name!r}]"))
            for name, array in _arrays.columns(scalars, "scalars")
        ]
        colours = None
        if colors is not None:
            _arrays.refuse_masked(colors, "colors")
            colours = np.ascontiguousarray(colors)
            if colours.dtype != np.uint8 or colours.ndim != 2 or colours.shape[1] != 3:
                raise TypeError(
                    f"colors: must be uint8 of shape (n, 3), is {colours.dtype} {colours.shape}"
                )
            if len(colours) != len(self.V):
                raise InvalidInput(f"colors: has {len(colours)} rows, the mesh has {len(self.V)} vertices")
        _core.write(
            _arrays.path(path),
            self.V,
            self.F,
            _arrays.flag(ascii, "ascii"),
            _arrays.flag(float32, "float32"),
            values,
            _arrays.text(quality, "quality"),
            colours,
            "" if template is None else _arrays.path(template, "template"),
        )


MeshLike = Any  #: A Mesh, a pair (V, F), or a mesh of trimesh, meshio or pyvista.


def read_only(faces: Indices) -> Indices:
    """Faces that many meshes share."""
    faces.flags.writeable = False
    return faces


def name_of(mesh: Any, default: str) -> str:
    name = getattr(mesh, "name", "")
    return name if isinstance(name, str) and name else default
