# SPDX-License-Identifier: MIT
"""Meshes, collections, models and differences."""
from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import (
    Any,
    Dict,
    Iterable,
    Iterator,
    List,
    Mapping,
    Optional,
    Sequence,
    Tuple,
    Union,
    overload,
)

import numpy as np
import numpy.typing as npt

from . import _arrays, _core, _files, _labels
from ._arrays import Array, Columns, Indices, Path, Progress
from ._errors import InvalidInput
from ._results import (
    Distance,
    Distances,
    Edges,
    FitReport,
    Frames,
    Groups,
    PairTest,
    Report,
    Scores,
    Test,
)


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


def _options(
    method: str,
    quality: str,
    smoothness: Optional[float],
    avoid_contact: bool,
    seed: int = 1,
) -> _core.EmbeddingOptions:
    return _core.EmbeddingOptions(
        _arrays.text(method, "method"),
        _arrays.text(quality, "quality"),
        float("nan") if smoothness is None else _arrays.finite_number(smoothness, "smoothness"),
        seed,
        _arrays.flag(avoid_contact, "avoid_contact"),
    )


def _space(
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


def _report(figures: Dict[str, Any]) -> Report:
    return Report(**figures)


def _read_only(faces: Indices) -> Indices:
    """Faces that many meshes share."""
    faces.flags.writeable = False
    return faces


def _name_of(mesh: Any, default: str) -> str:
    name = getattr(mesh, "name", "")
    return name if isinstance(name, str) and name else default


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
        return _read_only(self._core.faces())

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
    ) -> "Model":
        """Mean, principal modes, variances and scores, as `shape stats` finds them.

        modes: this many, at most N - 1; 0: as few as have the share `variance` of the variance.
        space: "edge" (edge lengths, which are pose-invariant) or "procrustes". scale: "unit" (every
        mesh is brought to one size) or "none". with_dihedrals, with_positions: weights > 0 with which
        these are coordinates beside lengths. Raises InvalidInput if a rule is broken.
        """
        chosen = _space(
            space, scale, coordinates, area_weighted, with_dihedrals, with_positions
        )
        return Model(
            _core.fit(
                self._core, _arrays.integer(modes, "modes", 0), _arrays.number(variance, "variance"), chosen
            )
        )

    def write(self, path: Path) -> None:
        """Writes a collection file (.h5) that the program reads; a file that is there is replaced."""
        self._core.write(_arrays.path_ending(path, ".h5"))

    def as_dict(self) -> Columns:
        """Columns mesh and labels; None where a label is missing."""
        return {"mesh": self.names, **self._labels}

    def table(self) -> Any:
        """as_dict() as a pandas.DataFrame."""
        return _arrays.data_frame(self.as_dict())


class Model:
    """Mean and principal modes of a collection. ``Collection.model()`` and ``read_model()`` make one."""

    def __init__(self, core: _core.Model, file: str = "model.h5") -> None:
        self._core = core
        self._file = file  # how a page calls it; what is exported is in memory

    @cached_property
    def names(self) -> Tuple[str, ...]:
        """Of the N meshes that the model was made from."""
        return tuple(self._core.names)

    @cached_property
    def _labels(self) -> Dict[str, Tuple[Optional[str], ...]]:
        return self._core.labels

    @property
    def labels(self) -> Dict[str, Tuple[Optional[str], ...]]:
        """Name -> values of those meshes, None where one is missing. A copy."""
        return dict(self._labels)

    @cached_property
    def F(self) -> Indices:
        """(m, 3) faces; read-only."""
        return _read_only(self._core.faces())

    def __reduce__(self) -> Tuple[Any, ...]:
        return _model_of_bytes, (_files.bytes_of(self._core.write), self._file)

    @property
    def mode_count(self) -> int:
        """K"""
        return self._core.mode_count

    @property
    def variances(self) -> Array:
        """(K,) descending; a view."""
        return self._core.variances

    @property
    def total_variance(self) -> float:
        """The sum over all modes, kept or not."""
        return self._core.total_variance

    @property
    def mean_size(self) -> float:
        """Mean size of the meshes [length]: sum of the edge lengths, or centroid size."""
        return self._core.mean_size

    @property
    def modes(self) -> Array:
        """(K, D) orthonormal rows, in the coordinates of the space; a view."""
        return self._core.modes

    @property
    def mean(self) -> Array:
        """(D,) coordinates; a view. ``decode([])`` makes it a mesh."""
        return self._core.mean

    @property
    def training_scores(self) -> Array:
        """(N, K) of the meshes that the model was made from; a view."""
        return self._core.scores

    @property
    def sizes(self) -> Array:
        """(N,) of those meshes [length]; a view."""
        return self._core.sizes

    def __repr__(self) -> str:
        share = self.variances.sum() / self.total_variance if self.total_variance else 1.0
        return (
            f"Model({self._core.space} space, {self.mode_count} modes with {100 * share:.3g} % of the "
            f"variance of {len(self.names)} meshes, {self._core.reference_points().shape[0]} vertices)"
        )

    def decode(
        self,
        scores: Any,
        *,
        size: Optional[float] = None,
        method: str = "dihedral",
        quality: str = "",
        smoothness: Optional[float] = None,
        avoid_contact: bool = False,
    ) -> Tuple[Mesh, Report]:
        """The mesh at scores of the first modes in standard deviations, the others being 0.

        size: of the result [length]; default: mean_size. method, quality ("preview" or "fine"),
        smoothness and avoid_contact are as of `shape generate`. The same bits as `shape generate --scores`.
        """
        row = _arrays.finite(_arrays.vector(scores, "scores"), "scores")
        ((points, figures),) = _core.decode(
            self._core,
            [row],
            self._size(size),
            _options(method, quality, smoothness, avoid_contact),
            None,
        )
        return Mesh(points, self.F, "scores"), _report(figures)

    @staticmethod
    def _size(size: Optional[float]) -> Optional[float]:
        return None if size is None else _arrays.finite_number(size, "size")

    def decode_all(
        self,
        scores: Any,
        *,
        size: Optional[float] = None,
        method: str = "dihedral",
        quality: str = "",
        smoothness: Optional[float] = None,
        avoid_contact: bool = False,
        progress: Progress = None,
    ) -> Tuple[List[Mesh], List[Report]]:
        """decode() of every row of (n, k) scores."""
        rows = _arrays.numbers(scores, "scores")
        if rows.ndim != 2:
            raise TypeError(f"scores: shape must be (n, k), is {rows.shape}")
        made = _core.decode(
            self._core,
            list(_arrays.finite(rows, "scores")),
            self._size(size),
            _options(method, quality, smoothness, avoid_contact),
            _arrays.progress(progress),
        )
        meshes = [Mesh(points, self.F, f"scores_{i:04}") for i, (points, _) in enumerate(made)]
        return meshes, [_report(figures) for _, figures in made]

    def sample(self, n: int, *, seed: int = 1) -> Array:
        """(n, K) independent standard normal scores, those of `shape generate --sample n --seed seed`."""
        return _core.sample(self._core, _arrays.integer(n, "n", 0), _arrays.seed(seed))

    def feasible_range(self, mode: int) -> Tuple[float, float]:
        """From where to where a mode (from 0) keeps every triangle inequality [standard deviations]."""
        return self._core.feasible_range(_arrays.integer(mode, "mode", 0, self.mode_count - 1))

    def scores(self, meshes: Any) -> Scores:
        """Scores of a Collection, of a mesh, or of vertices V in the order of the model.

        A mesh is a Mesh, a pair (V, F) or one of another library; its faces must be those of the model.
        """
        if isinstance(meshes, Collection):
            names, labels, rows, sizes, residuals = _core.project_collection(self._core, meshes._core)
            return Scores(tuple(names), labels, rows, rows / np.sqrt(self.variances), sizes, residuals)
        if _arrays.is_mesh(meshes):
            vertices, corners = _arrays.mesh(meshes, "meshes")
            if corners is not self.F and not np.array_equal(corners, self.F):
                raise InvalidInput("meshes: has other faces than the model")
        else:
            vertices = _arrays.points(meshes, "V")
        _, labels, rows, sizes, residuals = _core.project_points(self._core, vertices)
        return Scores(
            (_name_of(meshes, "V"),),
            labels,
            rows[0],
            rows[0] / np.sqrt(self.variances),
            sizes[0:1].reshape(()),
            residuals[0:1].reshape(()),
        )

    def write(self, path: Path) -> None:
        """Writes a model file (.h5) that the program reads; a file that is there is replaced."""
        self._core.write(_arrays.path_ending(path, ".h5"))

    def _command(self, name: str, options: Sequence[str], force: bool, progress: Progress) -> None:
        """Carries out a command of the program on what is in memory, whatever has become of its file."""
        told = _arrays.progress(progress)
        with _files.in_scratch(os.path.basename(self._file)) as model:
            self._core.write(model)
            _core.command(name, [model, *options], force, told)

    def explorer(
        self,
        path: Path,
        *,
        color_by: str = "",
        title: str = "",
        force: bool = False,
        progress: Progress = None,
    ) -> None:
        """Writes a page for any browser, the model in the hand: as `shape explore`.

        color_by: label that colours the plot of scores. A page that is there is replaced only with force.
        Raises InvalidInput if the package was built without the page.
        """
        page = _arrays.path_ending(path, ".html")
        options = []
        for option, value in (("color_by", color_by), ("title", title)):
            if _arrays.text(value, option):
                options.append(f"--{option.replace('_', '-')}={value}")
        _files.check_output(page, _arrays.flag(force, "force"))
        with _files.in_scratch("page.html") as made:
            self._command("explore", [f"--output={made}", *options], False, progress)
            with open(made, encoding="utf-8") as file:
                content = file.read()
        _files.write_text(page, _files.without_scratch(content))

    def export(
        self, path: Path, to: str, *, modes: int = 0, force: bool = False, progress: Progress = None
    ) -> None:
        """Writes the model for other programs: to "statismo", "shapeworks", "slicermorph" or "csv".

        As `shape export`; docs/ecosystem.md says what each file holds. path: a file (.h5) for statismo, else a
        folder. A file that is there, or a folder that is not empty, is refused; with force files of the names that
        are written are replaced, others stay. modes: the first so many; 0: all.
        """
        clients = ("statismo", "shapeworks", "slicermorph", "csv")
        if _arrays.text(to, "to") not in clients:
            raise InvalidInput(f"to: {to!r} must be one of {', '.join(clients)}")
        target = _arrays.path_ending(path, ".h5") if to == "statismo" else _arrays.path(path)
        options = [f"--to={to}", f"--output={target}"]
        if _arrays.integer(modes, "modes", 0, self.mode_count):
            options.append(f"--modes={modes}")
        self._command("export", options, _arrays.flag(force, "force"), progress)


class Difference:
    """The mean difference between two groups. ``difference()`` and ``read_difference()`` make one."""

    def __init__(self, core: _core.Difference) -> None:
        self._core = core

    @cached_property
    def F(self) -> Indices:
        """(m, 3) faces; read-only."""
        return _read_only(self._core.faces())

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
    ) -> Tuple[Mesh, Report]:
        """A mesh with so much of the difference added, in its place; default: onto the mean of `from`."""
        share = _arrays.finite_number(amount, "amount")
        starts: List[Array] = []
        name = "applied"
        if onto is not None:
            vertices, corners = _arrays.mesh(onto, "onto")
            if not np.array_equal(corners, self.F):
                raise InvalidInput("onto: has other faces than the difference")
            starts = [_arrays.finite(vertices, "onto.V")]
            name = _name_of(onto, name)
        ((points, figures),) = _core.apply(
            self._core, starts, share, _options(method, quality, smoothness, avoid_contact), None
        )
        return Mesh(points, self.F, name), _report(figures)

    def write(self, path: Path) -> None:
        """Writes a difference file (.h5) that the program reads; a file that is there is replaced."""
        self._core.write(_arrays.path_ending(path, ".h5"))

    def __repr__(self) -> str:
        of = f"{len(self.pairs)} pairs" if self.pairs else "two groups without pairs"
        return f"Difference({of}, norm {float(np.linalg.norm(self.lengths)):.4g})"


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
    meshes as index. triangulate: split polygons as fans. untrusted: read files of HDF5 in a process of their own
    first, which a hostile file may crash; costs a few tenths of a second. What is odd about the meshes is warned
    of; raises InvalidInput naming mesh and place if they do not correspond.
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
    for file in files:
        if file.endswith(".h5"):
            _files.rehearse(file, untrusted)
    if labels is None:
        core, messages, warned = _core.read(files, "", triangulate, told)
    else:
        with _labels.file_of(labels) as table:
            core, messages, warned = _core.read(files, table, triangulate, told)
    for text in warned:
        warnings.warn(text, stacklevel=2)
    return Collection(core, messages)


def read_mesh(path: Path, *, triangulate: bool = False) -> Mesh:
    """Reads a single mesh; of a file with several, the first."""
    return read(_arrays.path(path), triangulate=triangulate)[0]


def read_model(path: Path, *, untrusted: bool = False) -> Model:
    """Reads a model of `shape stats` or Model.write(). untrusted: as of read()."""
    file = _arrays.path(path)
    _files.rehearse(file, untrusted)
    return Model(_core.read_model(file), file)


def read_difference(path: Path, *, untrusted: bool = False) -> Difference:
    """Reads a difference of `shape difference` or Difference.write(). untrusted: as of read()."""
    file = _arrays.path(path)
    _files.rehearse(file, untrusted)
    return Difference(_core.read_difference(file))


def _collection_of_bytes(content: bytes, notes: Sequence[str]) -> Collection:
    core, _, _ = _files.of_bytes(content, lambda path: _core.read([path], "", False, None))
    return Collection(core, notes)


def _model_of_bytes(content: bytes, file: str) -> Model:
    return Model(_files.of_bytes(content, _core.read_model), file)


def _difference_of_bytes(content: bytes) -> Difference:
    return Difference(_files.of_bytes(content, _core.read_difference))


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
    made, warned = _gather(meshes, F, names, labels)
    for text in warned:
        warnings.warn(text, stacklevel=2)
    return made


def _gather(
    meshes: Iterable[MeshLike], F: Any, names: Optional[Sequence[str]], labels: Any
) -> Tuple[Collection, List[str]]:
    """A collection, and what is odd about it."""
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
                raise InvalidInput(f"meshes[{i}]: has other faces than meshes[0]")
            vertices.append(points)
        found_names.append(_name_of(item, f"mesh_{i:04}"))
    if corners is None or not vertices:
        raise InvalidInput("meshes: there is none; a collection needs at least one")
    chosen = found_names if names is None else _arrays.texts(names, "names")
    if len(chosen) != len(vertices):
        raise TypeError(f"names: {len(chosen)} for {len(vertices)} meshes")
    if "" in chosen:
        raise InvalidInput(f"names[{chosen.index('')}]: is empty, every mesh must have a name")
    cells, unused = _labels.cells_of(labels, chosen)
    core, warned = _core.from_arrays(vertices, corners, chosen, cells)
    notes = [f"labels: {len(unused)} rows are of other meshes, such as {unused[0]}"] if unused else []
    return Collection(core, notes), warned


def fit(
    template: MeshLike,
    scan: Union[MeshLike, Path],
    landmarks: Optional[Mapping[str, Tuple[Any, Any]]] = None,
    *,
    landmark_tolerance: float = 0.0,
    boundaries: Sequence[str] = (),
    smoothness: float = 1.0,
    growth_smoothness: float = 50.0,
    search: bool = True,
) -> Tuple[Mesh, FitReport]:
    """The template laid onto a raw scan of any triangulation, as `shape fit`, to the same bits.

    scan: a mesh, or the path of a file; holes, several parts and odd faces are all right. landmarks: name
    -> (on the template, on the scan), each (x, y, z), the first also a vertex of the template (from 0).
    boundaries: names of landmarks at boundary loops that correspond from end to end. The mesh has the
    template's faces and the scan's place and unit; look at `report.status`: a scan that the template
    does not fit raises nothing.
    """
    vertices, corners = _arrays.mesh(template, "template")
    if isinstance(scan, (str, os.PathLike)):
        raw, raw_faces, name = _core.read_scan(_arrays.path(scan, "scan"))
    else:
        raw, raw_faces = _arrays.mesh(scan, "scan")
        name = _name_of(scan, "fit")
    here: List[Array] = []
    there: List[Array] = []
    marks = _arrays.columns(landmarks, "landmarks")
    for mark, pair in marks:
        if not isinstance(pair, (tuple, list, np.ndarray)) or len(pair) != 2:
            raise TypeError(
                f"landmarks[{mark!r}]: must be (on the template, on the scan), is {_arrays.shown(pair)}"
            )
        on_template, on_scan = pair
        if isinstance(on_template, (int, np.integer)) and not isinstance(on_template, bool):
            if not 0 <= on_template < len(vertices):
                raise InvalidInput(
                    f"landmarks[{mark!r}]: vertex {on_template} is not among the template's {len(vertices)}"
                )
            on_template = vertices[on_template]
        for place, found in ((on_template, here), (on_scan, there)):
            position = _arrays.vector(place, f"landmarks[{mark!r}]")
            if position.shape != (3,):
                raise TypeError(f"landmarks[{mark!r}]: shape must be (3,), is {position.shape}")
            found.append(_arrays.finite(position, f"landmarks[{mark!r}]"))
    names = [mark for mark, _ in marks]
    points, figures = _core.fit_scan(
        vertices,
        corners,
        raw,
        raw_faces,
        names,
        np.array(here, dtype=np.float64).reshape(-1, 3),
        np.array(there, dtype=np.float64).reshape(-1, 3),
        _core.FitOptions(
            _arrays.number(smoothness, "smoothness"),
            _arrays.number(growth_smoothness, "growth_smoothness"),
            _arrays.number(landmark_tolerance, "landmark_tolerance"),
            _arrays.flag(search, "search"),
            _arrays.texts(boundaries, "boundaries"),
        ),
    )
    for key in ("scan_to_fit", "fit_to_scan"):
        figures[key] = Distance(**figures[key])
    return Mesh(points, corners, name), FitReport(landmarks=names, **figures)


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
        together, _ = _gather(meshes, None, [f"mesh_{i:04}" for i in range(len(meshes))], None)
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
        _options(method, quality, smoothness, avoid_contact),
        _arrays.progress(progress),
    )
    return Frames(
        [Mesh(points, together.F, f"frame_{i:04}") for i, (points, _) in enumerate(made)],
        [_report(figures) for _, figures in made],
        rows,
    )


def _collection(meshes: Any) -> _core.Collection:
    if not isinstance(meshes, Collection):
        raise TypeError(f"meshes: must be a Collection, is {_arrays.shown(meshes)}")
    return meshes._core


def difference(
    meshes: Collection, from_: str, to: str, *, pair_by: str = "", scale: str = "unit"
) -> Difference:
    """The mean difference between two groups, as `shape difference`.

    from_, to: "LABEL=VALUE". pair_by: meshes with the same value of this label are a pair; default: the
    means of the groups are compared.
    """
    _space("edge", scale, "plain", False, 0.0, 0.0)  # refuses an unknown scale
    return Difference(
        _core.difference(
            _collection(meshes),
            _arrays.text(pair_by, "pair_by"),
            _labels.label_and_value(from_, "from_"),
            _labels.label_and_value(to, "to"),
            scale,
        )
    )


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
    chosen = _space(space, scale, coordinates, area_weighted, with_dihedrals, with_positions)
    names, counts, overall, pairs = _core.groups(
        _collection(meshes),
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


def distance(meshes: Collection, metric: str = "edge-unit") -> Distances:
    """Distances between all meshes, as `shape distance --metric`: edge, edge-unit or procrustes."""
    spaces = {
        "edge": ("edge", "none"),
        "edge-unit": ("edge", "unit"),
        "procrustes": ("procrustes", "unit"),
    }
    core = _collection(meshes)
    if _arrays.text(metric, "metric") not in spaces:
        raise InvalidInput(f"metric: {metric!r} must be one of {', '.join(spaces)}")
    space, scale = spaces[metric]
    options = _space(space, scale, "plain", False, 0.0, 0.0)
    return Distances(meshes.names, _core.distances(core, options))


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


def edges(mesh: MeshLike) -> Edges:
    """Edges of a mesh, their lengths and dihedral angles."""
    return Edges(*_core.measure(*_arrays.mesh(mesh, "mesh")))


def thread_count() -> int:
    """Threads that the library may use; at first, the number of processors."""
    return _core.thread_count()


def set_thread_count(count: int) -> None:
    """Sets thread_count() for the whole process, in [1, 1024]. Results do not depend on it."""
    _core.set_thread_count(_arrays.integer(count, "count"))
