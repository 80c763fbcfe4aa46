# SPDX-License-Identifier: MIT
"""Meshes, collections, models and differences."""
from __future__ import annotations

import os
import tempfile
import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from . import _arrays, _core
from ._arrays import Array, Columns, Indices, Path, Progress
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

    def __iter__(self) -> Iterator[Any]:
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
        scalars: Optional[Mapping[str, Any]] = None,
        quality: str = "",
        colors: Any = None,
        template: Optional[Path] = None,
    ) -> None:
        """Writes a mesh file; the ending names the format: .obj .ply .off .stl .vtk .vtp .glb.

        scalars: name -> (n,) numbers at the vertices (.ply .vtk .vtp). quality: the one of them that a .ply
        file holds once more as `quality`, the name that most programs show. colors: (n, 3) uint8.
        template: an OBJ file of the same faces, whose texture coordinates, materials and polygons
        an .obj file is written with.
        """
        values = [
            (name, _arrays.vector(array, f"scalars[{name!r}]"))
            for name, array in (scalars or {}).items()
        ]
        colours = None
        if colors is not None:
            colours = np.ascontiguousarray(colors)
            if colours.dtype != np.uint8 or colours.ndim != 2 or colours.shape[1] != 3:
                raise TypeError(
                    f"colors: must be uint8 of shape (n, 3), is {colours.dtype} {colours.shape}"
                )
        _core.write(
            os.fspath(path),
            self.V,
            self.F,
            ascii,
            float32,
            values,
            quality,
            colours,
            os.fspath(template) if template else "",
        )


MeshLike = Any  #: A Mesh, a pair (V, F), or a mesh of trimesh, meshio or pyvista.


def _options(method: str, quality: str, smoothness: Optional[float], seed: int = 1) -> Any:
    return _core.EmbeddingOptions(
        method, quality, float("nan") if smoothness is None else smoothness, seed
    )


def _report(figures: Dict[str, Any]) -> Report:
    return Report(**figures)


class Collection:
    """Meshes in correspondence: one triangulation, N sets of vertices, names and labels.

    ``read()`` and ``collection()`` make one. ``c[3]`` and ``c["name"]`` are meshes, ``c[[0, 2]]`` and
    slices are collections.
    """

    def __init__(self, core: _core.Collection, notes: Sequence[str] = ()) -> None:
        self._core = core
        self.notes = list(notes)  #: What reading has to say, such as formats of single precision.

    @cached_property
    def names(self) -> List[str]:
        """N, all different."""
        return self._core.names

    @cached_property
    def labels(self) -> Dict[str, List[str]]:
        """Name -> N values; empty where one is missing."""
        return self._core.labels

    @cached_property
    def F(self) -> Indices:
        """(m, 3) faces of all meshes."""
        return self._core.faces()

    def __len__(self) -> int:
        return len(self.names)

    def __iter__(self) -> Iterator[Mesh]:
        return (self._mesh(i) for i in range(len(self)))

    def _mesh(self, index: int) -> Mesh:
        return Mesh(self._core.points(index), self.F, self.names[index])

    def __getitem__(self, key: Any) -> Any:
        if isinstance(key, str):
            if key not in self.names:
                raise KeyError(key)
            return self._mesh(self.names.index(key))
        if isinstance(key, (int, np.integer)):
            if not -len(self) <= key < len(self):
                raise IndexError(f"mesh {key} of {len(self)}")
            return self._mesh(int(key) % len(self))
        return Collection(self._core.subset(np.arange(len(self))[key].tolist()))

    def __repr__(self) -> str:
        labels = f", labels {', '.join(self.labels)}" if self.labels else ""
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
    ) -> "Model":
        """Mean, principal modes, variances and scores, as `shape stats` finds them.

        modes: this many, at most N - 1; 0: as few as have the share `variance` of the variance.
        space: "edge" (edge lengths, which are pose-invariant) or "procrustes". scale: "unit" (every
        mesh is brought to one size) or "none". Raises InvalidInput if a rule is broken.
        """
        chosen = _core.SpaceOptions(space, scale, coordinates, area_weighted, with_dihedrals)
        return Model(_core.fit(self._core, modes, variance, chosen))

    def write(self, path: Path) -> None:
        """Writes a collection file (.h5) that the program reads."""
        _core.Collection.write(self._core, os.fspath(path))

    def as_dict(self) -> Columns:
        """Columns mesh and labels."""
        return {"mesh": self.names, **self.labels}

    def table(self) -> Any:
        """as_dict() as a pandas.DataFrame."""
        return _arrays.data_frame(self.as_dict())


class Model:
    """Mean and principal modes of a collection. ``Collection.model()`` and ``read_model()`` make one."""

    def __init__(self, core: _core.Model, path: str = "") -> None:
        self._core = core
        self._path = path

    @cached_property
    def names(self) -> List[str]:
        """Of the N meshes that the model was made from."""
        return self._core.names

    @cached_property
    def labels(self) -> Dict[str, List[str]]:
        """Of those meshes."""
        return self._core.labels

    @cached_property
    def F(self) -> Indices:
        """(m, 3) faces."""
        return self._core.faces()

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
    ) -> Tuple[Mesh, Report]:
        """The mesh at scores of the first modes in standard deviations, the others being 0.

        size: of the result [length]; default: mean_size. method, quality ("preview" or "fine") and
        smoothness are as of `shape generate`. The same bits as `shape generate --scores`.
        """
        row = _arrays.vector(scores, "scores")
        ((points, figures),) = _core.decode(
            self._core, [row], size, _options(method, quality, smoothness), None
        )
        return Mesh(points, self.F, "scores"), _report(figures)

    def decode_all(
        self,
        scores: Any,
        *,
        size: Optional[float] = None,
        method: str = "dihedral",
        quality: str = "",
        smoothness: Optional[float] = None,
        progress: Progress = None,
    ) -> Tuple[List[Mesh], List[Report]]:
        """decode() of every row of (n, k) scores."""
        rows = _arrays.numbers(scores, "scores")
        if rows.ndim != 2:
            raise TypeError(f"scores: shape must be (n, k), is {rows.shape}")
        made = _core.decode(
            self._core,
            list(rows),
            size,
            _options(method, quality, smoothness),
            _arrays.progress(progress),
        )
        meshes = [Mesh(points, self.F, f"scores_{i:04}") for i, (points, _) in enumerate(made)]
        return meshes, [_report(figures) for _, figures in made]

    def sample(self, n: int, *, seed: int = 1) -> Array:
        """(n, K) independent standard normal scores, those of `shape generate --sample n --seed seed`."""
        return _core.sample(self._core, n, seed)

    def feasible_range(self, mode: int) -> Tuple[float, float]:
        """From where to where a mode (from 0) keeps every triangle inequality [standard deviations]."""
        return self._core.feasible_range(mode)

    def scores(self, meshes: Any) -> Scores:
        """Scores of a Collection, of a Mesh, or of vertices V in the order of the model."""
        if isinstance(meshes, Collection):
            found = _core.project_collection(self._core, meshes._core)
            is_single = False
        else:
            if hasattr(meshes, "V") and hasattr(meshes, "F"):
                vertices, corners = _arrays.mesh(meshes, "meshes")
                if corners is not self.F and not np.array_equal(corners, self.F):
                    raise _core.InvalidInput("meshes: has other faces than the model")
            else:
                vertices = _arrays.points(meshes, "V")
            found = _core.project_points(self._core, vertices)
            is_single = True
        names, labels, rows, sizes, residuals = found
        if is_single:
            names = [getattr(meshes, "name", "") or "V"]
            rows, sizes, residuals = rows[0], sizes[0:1].reshape(()), residuals[0:1].reshape(())
        deviations = rows / np.sqrt(self.variances)
        return Scores(names, labels, rows, deviations, sizes, residuals)

    def write(self, path: Path) -> None:
        """Writes a model file (.h5) that the program reads."""
        self._core.write(os.fspath(path))

    def _command(
        self, name: str, arguments: Sequence[str], force: bool, progress: Progress = None
    ) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = self._path
            if not path:
                path = os.path.join(folder, "model.h5")
                self._core.write(path)
            _core.command(name, [path, *arguments], force, _arrays.progress(progress))

    def explorer(
        self, path: Path, *, color_by: str = "", title: str = "", force: bool = True
    ) -> None:
        """Writes a page for any browser, the model in the hand: as `shape explore`.

        Raises ValueError if the package was built without the page.
        """
        options = ["-o", os.fspath(path)]
        for option, value in (("--color-by", color_by), ("--title", title)):
            if value:
                options += [option, value]
        self._command("explore", options, force)


    def export(
        self, path: Path, to: str, *, modes: int = 0, force: bool = True, progress: Progress = None
    ) -> None:
        """Writes the model for other programs: to "statismo", "shapeworks", "slicermorph" or "csv".

        As `shape export`; docs/ecosystem.md says what each file holds.
        """
        options = ["--to", to, "-o", os.fspath(path)]
        if modes:
            options += ["--modes", str(modes)]
        self._command("export", options, force, progress)


class Difference:
    """The mean difference between two groups. ``difference()`` and ``read_difference()`` make one."""

    def __init__(self, core: _core.Difference) -> None:
        self._core = core

    @cached_property
    def F(self) -> Indices:
        """(m, 3) faces."""
        return self._core.faces()

    @property
    def pairs(self) -> List[str]:
        """Values of the label that pairs; none if the groups are not paired."""
        return self._core.pairs

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
    ) -> Tuple[Mesh, Report]:
        """A mesh with so much of the difference added, in its place; default: onto the mean of `from`."""
        starts: List[Array] = []
        name = "applied"
        if onto is not None:
            vertices, corners = _arrays.mesh(onto, "onto")
            if not np.array_equal(corners, self.F):
                raise _core.InvalidInput("onto: has other faces than the difference")
            starts = [vertices]
            name = getattr(onto, "name", "") or name
        ((points, figures),) = _core.apply(
            self._core, starts, amount, _options(method, quality, smoothness), None
        )
        return Mesh(points, self.F, name), _report(figures)

    def write(self, path: Path) -> None:
        """Writes a difference file (.h5) that the program reads."""
        self._core.write(os.fspath(path))

    def __repr__(self) -> str:
        of = f"{len(self.pairs)} pairs" if self.pairs else "two groups without pairs"
        return f"Difference({of}, norm {float(np.linalg.norm(self.lengths)):.4g})"


def read(
    paths: Union[Path, Iterable[Path]],
    labels: Optional[Path] = None,
    *,
    triangulate: bool = False,
    progress: Progress = None,
) -> Collection:
    """Reads meshes, directories (natural name order) and collection files (.h5), in any mix.

    labels: a CSV file whose first column is `mesh`. triangulate: split polygons as fans. What is odd about
    the meshes is warned of; raises InvalidInput naming mesh and place if they do not correspond.
    """
    listed = [paths] if isinstance(paths, (str, os.PathLike)) else list(paths)
    core, messages, warned = _core.read(
        [os.fspath(path) for path in listed],
        os.fspath(labels) if labels else "",
        triangulate,
        _arrays.progress(progress),
    )
    for text in warned:
        warnings.warn(text, stacklevel=2)
    return Collection(core, messages)


def read_mesh(path: Path, *, triangulate: bool = False) -> Mesh:
    """Reads a single mesh; of a file with several, the first."""
    mesh = read(path, triangulate=triangulate)[0]
    assert isinstance(mesh, Mesh)
    return mesh


def read_model(path: Path) -> Model:
    """Reads a model of `shape stats` or Model.write()."""
    return Model(_core.read_model(os.fspath(path)), os.fspath(path))


def read_difference(path: Path) -> Difference:
    """Reads a difference of `shape difference` or Difference.write()."""
    return Difference(_core.read_difference(os.fspath(path)))


def collection(
    meshes: Iterable[MeshLike],
    F: Any = None,
    *,
    names: Optional[Sequence[str]] = None,
    labels: Optional[Mapping[str, Sequence[object]]] = None,
) -> Collection:
    """A collection of meshes in memory; or of vertex arrays (N of (n, 3)) that share the faces F."""
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
                raise _core.InvalidInput(f"meshes[{i}]: has other faces than meshes[0]")
            vertices.append(points)
        found_names.append(getattr(item, "name", "") or f"mesh_{i:04}")
    if corners is None:
        raise TypeError("meshes: there is none")
    chosen = list(names) if names is not None else found_names
    if len(chosen) != len(vertices):
        raise TypeError(f"names: {len(chosen)} for {len(vertices)} meshes")
    columns = [(name, [str(value) for value in values]) for name, values in (labels or {}).items()]
    for name, values in columns:
        if len(values) != len(vertices):
            raise TypeError(f"labels[{name!r}]: {len(values)} values for {len(vertices)} meshes")
    return Collection(_core.from_arrays(vertices, corners, chosen, columns))


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
        raw, raw_faces, name = _core.read_scan(os.fspath(scan))
    else:
        raw, raw_faces = _arrays.mesh(scan, "scan")
        name = getattr(scan, "name", "") or "fit"
    here: List[Array] = []
    there: List[Array] = []
    for mark, (on_template, on_scan) in (landmarks or {}).items():
        if isinstance(on_template, (int, np.integer)):
            if not 0 <= on_template < len(vertices):
                raise _core.InvalidInput(
                    f"landmarks[{mark!r}]: vertex {on_template} is not among the template's {len(vertices)}"
                )
            on_template = vertices[on_template]
        for place, found in ((on_template, here), (on_scan, there)):
            position = _arrays.vector(place, f"landmarks[{mark!r}]")
            if position.shape != (3,):
                raise TypeError(f"landmarks[{mark!r}]: shape must be (3,), is {position.shape}")
            found.append(position)
    names = list(landmarks or {})
    points, figures = _core.fit_scan(
        vertices,
        corners,
        raw,
        raw_faces,
        names,
        np.array(here, dtype=np.float64).reshape(-1, 3),
        np.array(there, dtype=np.float64).reshape(-1, 3),
        _core.FitOptions(
            smoothness, growth_smoothness, landmark_tolerance, search, list(boundaries)
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
    progress: Progress = None,
) -> Frames:
    """Blends of two or more meshes in edge-length space, the same bits as `shape interpolate`.

    frames: the number of frames along the straight lines that join the meshes in order, both ends
    included. Or weights: (frames, meshes), rows that sum to 1.
    """
    together = (
        meshes[0]
        if len(meshes) == 1 and isinstance(meshes[0], Collection)
        else collection(
            meshes, names=[f"mesh_{i:04}" for i in range(len(meshes))]
        )
    )
    count = len(together)
    if (frames > 0) == (weights is not None):
        raise TypeError("frames, weights: give one of them")
    if weights is None:
        if frames < 2 or count < 2:
            raise _core.InvalidInput(f"frames: {frames} frames of {count} meshes, both must be >= 2")
        rows = np.array([_core.line_weights(count, i / (frames - 1)) for i in range(frames)])
    else:
        rows = _arrays.numbers(weights, "weights")
        if rows.ndim != 2 or rows.shape[1] != count:
            raise TypeError(f"weights: shape must be (frames, {count}), is {rows.shape}")
    made = _core.interpolate(
        together._core,
        list(rows),
        weights is None,
        squared,
        _options(method, quality, smoothness),
        _arrays.progress(progress),
    )
    return Frames(
        [Mesh(points, together.F, f"frame_{i:04}") for i, (points, _) in enumerate(made)],
        [_report(figures) for _, figures in made],
        rows,
    )


def difference(
    meshes: Collection, from_: str, to: str, *, pair_by: str = "", scale: str = "unit"
) -> Difference:
    """The mean difference between two groups, as `shape difference`.

    from_, to: "LABEL=VALUE". pair_by: meshes with the same value of this label are a pair; default: the
    means of the groups are compared.
    """
    _core.SpaceOptions("edge", scale, "plain", False, 0.0)  # refuses an unknown scale
    return Difference(
        _core.difference(
            meshes._core,
            pair_by,
            _arrays.label_value(from_, "from_"),
            _arrays.label_value(to, "to"),
            scale,
        )
    )


def groups(
    meshes: Collection,
    by: str,
    *,
    within: str = "",
    permutations: int = 999,
    seed: int = 1,
    space: str = "edge",
    scale: str = "unit",
    coordinates: str = "plain",
    area_weighted: bool = False,
    with_dihedrals: float = 0.0,
) -> Groups:
    """Do the mean shapes of groups differ? By permutation, as `shape groups`.

    by: label whose values are the groups. within: label of blocks, such as subjects, within which labels
    are permuted.
    """
    chosen = _core.SpaceOptions(space, scale, coordinates, area_weighted, with_dihedrals)
    names, counts, overall, pairs = _core.groups(
        meshes._core, by, within, chosen, permutations, seed
    )
    return Groups(
        names,
        counts,
        Test(**overall),
        [
            PairTest(first, second, apart, Test(**test), adjusted)
            for first, second, apart, test, adjusted in pairs
        ],
    )


def distance(meshes: Collection, metric: str = "edge-unit") -> Distances:
    """Distances between all meshes, as `shape distance --metric`: edge, edge-unit or procrustes."""
    spaces = {
        "edge": ("edge", "none"),
        "edge-unit": ("edge", "unit"),
        "procrustes": ("procrustes", "unit"),
    }
    if metric not in spaces:
        raise _core.InvalidInput(f"metric: {metric!r} must be one of {', '.join(spaces)}")
    space, scale = spaces[metric]
    options = _core.SpaceOptions(space, scale, "plain", False, 0.0)
    return Distances(meshes.names, _core.distances(meshes._core, options))


def synthetic(name: str, *, count: int = 0, vertices: int = 0, seed: int = 1) -> Collection:
    """A made-up collection, as `shape synth`: "faces", "arm", "helix", ...; 0: the set's own number."""
    return Collection(_core.synthetic(name, count, vertices, seed))


def edges(mesh: MeshLike) -> Edges:
    """Edges of a mesh, their lengths and dihedral angles."""
    return Edges(*_core.measure(*_arrays.mesh(mesh, "mesh")))
