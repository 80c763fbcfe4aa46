# SPDX-License-Identifier: MIT
"""Models, and the meshes that they decode."""
from __future__ import annotations

import os
import warnings
from functools import cached_property
from typing import Any, Dict, List, Optional, Sequence, Tuple

import numpy as np

from . import _arrays, _core, _files
from ._arrays import Array, Indices, Path, Progress
from ._errors import InvalidInput
from ._mesh import Mesh, name_of, read_only
from ._options import embedding_options
from ._results import Report, Scores


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
        return read_only(self._core.faces())

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
        seed: int = 1,
    ) -> Tuple[Mesh, Report]:
        """The mesh at scores of the first modes in standard deviations, the others being 0.

        scores: (k,), k <= K. size: of the result [length], > 0; default: mean_size.
        method: how lengths and angles become a mesh: "dihedral" (both together), "closure" (Rojas 2014,
        section 2) or "multiscale" (Winkler 2010, section 3).
        quality: of the method dihedral: "preview" (a few steps) or "fine" (to convergence, the default).
        smoothness: of the method dihedral: weight of the dihedral angles [rad] against the relative lengths, > 0;
        default 0.005.
        avoid_contact: bend the mesh a little where faces cross that cross in no input, until they no longer do.
        seed: in [0, 2**64 - 1], by which the method multiscale draws its patches; the others draw nothing.
        The same bits as `shape generate --scores`. Where no mesh has the lengths the nearest comes out, and the
        report says so. Raises InvalidInput if a rule is broken or an option is of another method; NumericalError if
        a factorisation breaks down.
        """
        row = _arrays.finite(_arrays.vector(scores, "scores"), "scores")
        ((points, figures),) = _core.decode(
            self._core,
            [row],
            self._size(size),
            embedding_options(method, quality, smoothness, avoid_contact, seed),
            None,
        )
        return Mesh(points, self.F, "scores"), Report(**figures)

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
        seed: int = 1,
        progress: Progress = None,
    ) -> Tuple[List[Mesh], List[Report]]:
        """decode() of every row of (n, k) scores; the options are those of decode()."""
        rows = _arrays.numbers(scores, "scores")
        if rows.ndim != 2:
            raise TypeError(f"scores: shape must be (n, k), is {rows.shape}")
        made = _core.decode(
            self._core,
            list(_arrays.finite(rows, "scores")),
            self._size(size),
            embedding_options(method, quality, smoothness, avoid_contact, seed),
            _arrays.progress(progress),
        )
        meshes = [Mesh(points, self.F, f"scores_{i:04}") for i, (points, _) in enumerate(made)]
        return meshes, [Report(**figures) for _, figures in made]

    def sample(self, n: int, *, seed: int = 1) -> Array:
        """(n, K) independent standard normal scores, those of `shape generate --sample n --seed seed`."""
        return _core.sample(self._core, _arrays.integer(n, "n", 0), _arrays.seed(seed))

    def feasible_range(self, mode: int) -> Tuple[float, float]:
        """From where to where a mode (from 0) keeps every triangle inequality [standard deviations]."""
        return self._core.feasible_range(_arrays.integer(mode, "mode", 0, self.mode_count - 1))

    def scores(self, meshes: Any) -> Scores:
        """Scores of a Collection, of a mesh, or of vertices V in the order of the model.

        A mesh is a Mesh, a pair (V, F) or one of another library; its faces must be those of the model. Mirror images
        of the model's meshes, and meshes far larger, smaller or farther off, are warned of, as `shape project` does.
        """
        together = getattr(meshes, "_core", None)
        if isinstance(together, _core.Collection):  # of a Collection, whose module imports this one
            names, labels, rows, sizes, residuals, warned = _core.project_collection(
                self._core, together
            )
            for text in warned:
                warnings.warn(text, stacklevel=2)
            return Scores(tuple(names), labels, rows, rows / np.sqrt(self.variances), sizes, residuals)
        if _arrays.is_mesh(meshes):
            vertices, corners = _arrays.mesh(meshes, "meshes")
            if corners is not self.F and not np.array_equal(corners, self.F):
                known = self._core.reference_points()
                _core.check_same_faces(vertices, corners, "meshes", known, self.F, "the model")
        else:
            vertices = _arrays.points(meshes, "V")
        name = name_of(meshes, "V")
        _, labels, rows, sizes, residuals, warned = _core.project_points(self._core, vertices, name)
        for text in warned:
            warnings.warn(text, stacklevel=2)
        return Scores(
            (name,),
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


def read_model(path: Path, *, untrusted: bool = False) -> Model:
    """Reads a model of `shape stats` or Model.write(). untrusted: as of read()."""
    file = _arrays.path(path)
    with _files.isolated(untrusted):
        return Model(_core.read_model(file), file)


def _model_of_bytes(content: bytes, file: str) -> Model:
    return Model(_files.of_bytes(content, _core.read_model), file)
