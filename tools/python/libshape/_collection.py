# SPDX-License-Identifier: MIT
"""Collections: read, put together, made up."""
from __future__ import annotations

import os
import warnings
from contextlib import nullcontext
from functools import cached_property
from typing import Any, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple, Union, overload

import numpy as np
import numpy.typing as npt

from . import _arrays, _core, _files, _labels
from ._arrays import Array, Columns, Indices, Path, Progress
from ._errors import InvalidInput, warn
from ._mesh import Mesh, MeshLike, name_of, read_only
from ._model import Model
from ._options import space_options


class Collection:
    """Meshes in correspondence: one triangulation, N sets of vertices, names and labels.

    ``read()`` and ``collection()`` make one. ``c[3]`` and ``c["name"]`` are meshes; slices, ``c[[0, 2]]``,
    ``c[["name", "other"]]`` and ``c[[True, False, ...]]`` are collections; ``"name" in c``. Nothing changes
    a collection, so what it gives away is read-only.
    """

    def __init__(self, core: _core.Collection, notes: Sequence[str] = ()) -> None:
        self._core = core
        self.notes = tuple(notes)  #: What reading has to say, such as formats of single precision.

    @cached_property
    def names(self) -> Tuple[str, ...]:
        """N, all different."""
        return tuple(self._core.names)

    @cached_property
    def _labels(self) -> Dict[str, Tuple[Optional[str], ...]]:
        return self._core.labels

    @property
    def labels(self) -> Dict[str, Tuple[Optional[str], ...]]:
        """Name -> N values; None where one is missing. A copy."""
        return dict(self._labels)

    @cached_property
    def F(self) -> Indices:
        """(m, 3) faces of all meshes; read-only."""
        return read_only(self._core.faces())

    def __reduce__(self) -> Tuple[Any, ...]:
        return _collection_of_bytes, (_files.bytes_of(self._core.write), self.notes)

    def __contains__(self, name: object) -> bool:
        if not isinstance(name, str):
            raise TypeError(f"in: must be the name of a mesh, is {_arrays.shown(name)}")
        return name in self.names

    def __len__(self) -> int:
        return len(self._core)

    def __iter__(self) -> Iterator[Mesh]:
        return (self._mesh(i) for i in range(len(self)))

    def _mesh(self, index: int) -> Mesh:
        return Mesh(self._core.points(index), self.F, self.names[index])

    @overload
    def __getitem__(self, key: Union[int, str, "np.integer[Any]"]) -> Mesh: ...

    @overload
    def __getitem__(
        self, key: Union[slice, List[int], List[str], List[bool], npt.NDArray[Any]]
    ) -> "Collection": ...

    def __getitem__(self, key: Any) -> Union[Mesh, "Collection"]:
        if isinstance(key, str) or (isinstance(key, (int, np.integer)) and not isinstance(key, bool)):
            return self._mesh(self._index(key))
        chosen = self._chosen(key)
        if not chosen:
            raise InvalidInput(
                f"c[...]: chooses none of the {len(self)} meshes; a collection needs at least one"
            )
        seen = set()
        for i in chosen:
            if i in seen:
                raise InvalidInput(
                    f"c[...]: chooses mesh {self.names[i]!r} twice; names of a collection must differ"
                )
            seen.add(i)
        return Collection(self._core.subset(chosen))

    def _index(self, key: Any) -> int:
        """The number of a mesh by its number, from either end, or its name."""
        if isinstance(key, str):
            if key not in self.names:
                raise KeyError(key)
            return self.names.index(key)
        if not -len(self) <= key < len(self):
            raise IndexError(f"mesh {key} of {len(self)}")
        return int(key) % len(self)

    def _chosen(self, key: Any) -> List[int]:
        """Meshes of a slice, or of a list of numbers, of names, or of True and False."""
        if isinstance(key, slice):
            return list(range(len(self))[key])
        rule = "must be a number, a name, a slice, or a list of numbers, of names or of True and False"
        if isinstance(key, (bool, np.bool_)) or not isinstance(key, Iterable):
            raise TypeError(f"c[...]: {rule}, is {_arrays.shown(key)}")
        items = list(key)
        if items and all(isinstance(item, (bool, np.bool_)) for item in items):
            if len(items) != len(self):
                raise InvalidInput(f"c[...]: {len(items)} of True and False for {len(self)} meshes")
            return [i for i, item in enumerate(items) if item]
        for item in items:
            if not isinstance(item, (str, int, np.integer)) or isinstance(item, bool):
                raise TypeError(f"c[...]: {rule}, has an item that is {_arrays.shown(item)}")
        return [self._index(item) for item in items]

    def __repr__(self) -> str:
        labels = f", labels {', '.join(self._labels)}" if self._labels else ""
        return (
            f"Collection({len(self)} meshes, {self._core.vertex_count} vertices, "
            f"{len(self.F)} faces{labels})"
        )

    def model(
        self,
        modes: int = 0,
        variance: float = 1.0,
        *,
        space: str = "edge",
        scale: str = "unit",
        coordinates: str = "plain",
        area_weighted: bool = False,
        with_dihedrals: float = 0.0,
        with_positions: float = 0.0,
    ) -> Model:
        """Mean, principal modes, variances and scores, as `shape stats` finds them.

        modes: this many, at most N - 1; 0: as few as have the share `variance` of the variance.
        variance: in (0, 1]; 1 unless modes is 0.
        space: "edge" (edge lengths, which are pose-invariant) or "procrustes" (vertex positions after
        generalised Procrustes alignment), where what follows scale stays as it is.
        scale: "unit" (lengths are divided by their sum, positions by their centroid size, and size is kept
        apart) or "none" (size is part of the shape).
        coordinates: "plain", "squared" or "log", the function of the edge lengths that is the coordinate.
        area_weighted: the squared relative change of a length is weighted by the share of the mean's area around
        the edge, so that a densely meshed part does not dominate.
        with_dihedrals: > 0: dihedral angles are coordinates too, and 1 rad counts as much as a relative change of
        length by this; at most 1e6.
        with_positions: > 0, say 5: aligned positions are coordinates too, and moving all vertices by 1 % of the
        diagonal counts as much as changing all lengths by this number of percent; at most 1e6.
        Raises InvalidInput if a rule is broken, there are fewer than two meshes, or all are equal.
        """
        chosen = space_options(
            space, scale, coordinates, area_weighted, with_dihedrals, with_positions
        )
        core, warned = _core.fit(
            self._core, _arrays.integer(modes, "modes", 0), _arrays.number(variance, "variance"), chosen
        )
        warn(warned)
        return Model(core)

    def write(self, path: Path) -> None:
        """Writes a collection file (.h5) that the program reads; a file that is there is replaced."""
        self._core.write(_arrays.path_ending(path, ".h5"))

    def as_dict(self) -> Columns:
        """Columns mesh and labels; None where a label is missing."""
        return {"mesh": self.names, **self._labels}

    def table(self) -> Any:
        """as_dict() as a pandas.DataFrame."""
        return _arrays.data_frame(self.as_dict())


def read(
    paths: Union[Path, Iterable[Path]],
    labels: Any = None,
    *,
    triangulate: bool = False,
    untrusted: bool = False,
    progress: Progress = None,
) -> Collection:
    """Reads meshes, directories (natural name order) and collection files (.h5), in any mix.

    labels: a CSV file whose first column is `mesh`, or a DataFrame with that column or with the names of the
    meshes as index. triangulate: cut polygons into triangles. untrusted: a child process, which a hostile file
    may crash, reads files of HDF5 (.h5, .H5); costs some milliseconds each. What is odd about the
    meshes is warned of; raises InvalidInput naming mesh and place if they do not correspond.
    """
    if isinstance(paths, (str, os.PathLike)):
        files = [_arrays.path(paths, "paths")]
    elif isinstance(paths, Iterable):
        files = [_arrays.path(path, f"paths[{i}]") for i, path in enumerate(paths)]
    else:
        raise TypeError(f"paths: must be a path or a list of paths, is {_arrays.shown(paths)}")
    if not files:
        raise InvalidInput("paths: there is none")
    triangulate = _arrays.flag(triangulate, "triangulate")
    told = _arrays.progress(progress)
    label_file = nullcontext("") if labels is None else _labels.file_of(labels)
    with _files.isolated(untrusted), label_file as table:
        core, messages, warned = _core.read(files, table, triangulate, told)
    for text in warned:
        warnings.warn(text, stacklevel=2)
    return Collection(core, messages)


def read_mesh(path: Path, *, triangulate: bool = False) -> Mesh:
    """Reads a single mesh; of a file with several, the first."""
    return read(_arrays.path(path), triangulate=triangulate)[0]


def _collection_of_bytes(content: bytes, notes: Sequence[str]) -> Collection:
    core, _, _ = _files.of_bytes(content, lambda path: _core.read([path], "", False, None))
    return Collection(core, notes)


def collection(
    meshes: Iterable[MeshLike],
    F: Any = None,
    *,
    names: Optional[Sequence[str]] = None,
    labels: Any = None,
) -> Collection:
    """A collection of meshes in memory; or of vertex arrays (N of (n, 3)) that share the faces F.

    labels: name -> N values, in a dict or a DataFrame; a column `mesh`, or the names of the meshes as index of the
    DataFrame, says which mesh each row is of. Or a CSV file, as of read(). None, NaN, "NA" and the like are
    missing values (docs/formats.md). What is odd about the meshes is warned of.
    """
    made, warned = gather(meshes, F, names, labels)
    for text in warned:
        warnings.warn(text, stacklevel=2)
    return made


def gather(
    meshes: Iterable[MeshLike],
    F: Any,
    names: Optional[Sequence[str]],
    labels: Any,
    *,
    may_repeat: bool = False,
) -> Tuple[Collection, List[str]]:
    """A collection, and what is odd about it; copies of meshes are, unless they may repeat."""
    if isinstance(meshes, (str, bytes)) or not isinstance(meshes, Iterable):
        raise TypeError(f"meshes: must be a list of meshes, is {_arrays.shown(meshes)}")
    vertices: List[Array] = []
    corners = None if F is None else _arrays.faces(F, "F")
    found_names: List[str] = []
    for i, item in enumerate(meshes):
        if F is not None:
            vertices.append(_arrays.points(item, f"meshes[{i}]"))
        else:
            points, own = _arrays.mesh(item, f"meshes[{i}]")
            if corners is None:
                corners = own
            elif own is not corners and not np.array_equal(own, corners):
                _core.check_same_faces(points, own, f"meshes[{i}]", vertices[0], corners, "meshes[0]")
            vertices.append(points)
        found_names.append(name_of(item, f"mesh_{i:04}"))
    if corners is None or not vertices:
        raise InvalidInput("meshes: there is none; a collection needs at least one")
    chosen = found_names if names is None else _arrays.texts(names, "names")
    if len(chosen) != len(vertices):
        raise TypeError(f"names: {len(chosen)} for {len(vertices)} meshes")
    if "" in chosen:
        raise InvalidInput(f"names[{chosen.index('')}]: is empty, every mesh must have a name")
    cells, unused = _labels.cells_of(labels, chosen)
    core, warned = _core.from_arrays(vertices, corners, chosen, cells, may_repeat)
    notes = [f"labels: {len(unused)} rows are of other meshes, such as {unused[0]}"] if unused else []
    return Collection(core, notes), warned


def core_of(meshes: Any) -> _core.Collection:
    if not isinstance(meshes, Collection):
        raise TypeError(f"meshes: must be a Collection, is {_arrays.shown(meshes)}")
    return meshes._core


def synthetic(name: str, *, count: int = 0, vertices: int = 0, seed: int = 1) -> Collection:
    """A made-up collection, as `shape synth`: "faces", "arm", "helix", ...; 0: the set's own number."""
    return Collection(
        _core.synthetic(
            _arrays.text(name, "name"),
            _arrays.integer(count, "count", 0),
            _arrays.integer(vertices, "vertices", 0),
            _arrays.seed(seed),
        )
    )
