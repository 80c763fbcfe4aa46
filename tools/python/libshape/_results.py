# SPDX-License-Identifier: MIT
"""What comes back: small records whose text tells what they hold."""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Dict, Iterator, List, Optional, Tuple, Union, overload

import numpy as np

from . import _arrays, _core
from ._arrays import Array, Columns, Indices, Path, data_frame
from ._errors import InvalidInput
from ._mesh import Mesh


@dataclass(frozen=True)
class Report:
    """How far a mesh is from the lengths and dihedral angles that it was made from."""

    status: str  #: "exact", "approximate" or "infeasible" (no mesh has these lengths).
    reason: str  #: Why the target is infeasible, else empty.
    edge_rms: float  #: Root of the mean squared error of the lengths, over their mean.
    edge_max: float  #: Largest relative error of a length.
    edge_p999: float  #: 99.9 % quantile of the same.
    edge_p99: float  #: 99 % quantile.
    dihedral_rms_deg: float  #: Root mean square of the errors of dihedral angles [deg].
    dihedral_p99_deg: float  #: 99 % quantile of the same [deg].
    dihedral_max_deg: float  #: Largest [deg].
    closure_energy: float  #: E of Rojas 2014 eq. 3, >= 0: how far the target's angles are from any mesh.
    inverted_faces: int  #: Faces without area, or folded flat onto a neighbour.
    self_intersections: Optional[int]  #: Pairs of faces that pass through each other.
    new_self_intersections: Optional[int]  #: Those that do so in no input.
    avoidable_self_intersections: Optional[int]  #: What that was before avoid_contact; else None.
    companion_rms: Optional[float]  #: How far off in the large, % of the diagonal; see docs/embedding.md.
    iterations: int  #: Steps of the nonlinear solver.
    converged: bool  #: It met its criterion.
    seconds: float  #: Wall time of this mesh alone.
    setup_seconds: float  #: Wall time spent once for the triangulation.

    def __repr__(self) -> str:
        text = (
            f"Report({self.status}: edge errors RMS {100 * self.edge_rms:.3g} % of the mean length, largest "
            f"{100 * self.edge_max:.3g} % of the edge's own; dihedral angles {self.dihedral_rms_deg:.3g} deg RMS"
        )
        return text + (f"; {self.reason})" if self.reason else ")")


@dataclass(frozen=True)
class Distance:
    """Distances between two surfaces [length of the scan]."""

    mean: float
    p95: float  #: 95 % quantile.
    max: float


@dataclass(frozen=True, eq=False)
class FitReport:
    """How well a template lies on a scan; lengths are those of the scan. See docs/correspondence.md."""

    status: str  #: "good", "check" (look at it) or "failed" (it is not a fit).
    reasons: List[str]  #: Why it is not good.
    ignored: List[str]  #: What of the scan was left out.
    scan_to_fit: Distance  #: Of at most 20,000 vertices of the scan.
    fit_to_scan: Distance  #: Of vertices that have a counterpart.
    diagonal: float  #: Of the bounding box of the fit.
    strain_rms: float  #: Of edges, relative, growth taken off.
    growth_low: float  #: 1 % quantile of growth.
    growth_high: float  #: 99 % quantile.
    folded_faces: int  #: With an edge that bends by > 120 degrees more or less than the template's.
    unclaimed_share: float  #: Of the scan's surface: without counterpart in the fit.
    contested_vertices: int  #: Another part of the template lies in the same place.
    turned_faces: int  #: Of the scan: they faced inwards.
    scale: float  #: Of the start: 1, or a change of unit.
    landmarks: List[str]  #: Names.
    landmark_errors: Array  #: (landmarks,) distances.
    doubted_landmarks: Dict[str, float]  #: Names, and how far each is from where it is without it.
    distance: Array  #: (n,) of each vertex to the scan.
    growth: Array  #: (n,) factors by which the template grew.
    seen: "np.ndarray[Any, np.dtype[np.bool_]]"  #: (n,) whether the scan has a counterpart.

    def __repr__(self) -> str:
        text = (
            f"FitReport({self.status}: scan to fit {100 * self.scan_to_fit.mean / self.diagonal:.3g} % of "
            f"the diagonal on average, {int(self.seen.sum())} of {len(self.seen)} vertices seen"
        )
        return text + (f"; {'; '.join(self.reasons)})" if self.reasons else ")")


@dataclass(frozen=True, eq=False)
class Frames:
    """Meshes along a path, and what each is worth."""

    meshes: List[Mesh]
    reports: List[Report]
    weights: Array  #: (frames, inputs); each row sums to 1.

    def __len__(self) -> int:
        return len(self.meshes)

    def __iter__(self) -> Iterator[Mesh]:
        return iter(self.meshes)

    @overload
    def __getitem__(self, index: int) -> Mesh: ...

    @overload
    def __getitem__(self, index: slice) -> "Frames": ...

    def __getitem__(self, index: Union[int, slice]) -> Union[Mesh, "Frames"]:
        if isinstance(index, slice):
            return Frames(self.meshes[index], self.reports[index], self.weights[index])
        return self.meshes[_arrays.integer(index, "frames[...]")]

    def write(
        self, path: Path, *, frames_per_second: float = 25.0, tolerance: float = 1e-3
    ) -> None:
        """Writes an animation (.glb) for any glTF viewer, Blender and game engines; over one that is there.

        tolerance: largest error of a coordinate, as a fraction of the diagonal: frames that linear
        interpolation gives back that well are left out.
        """
        target = _arrays.path_ending(path, ".glb")
        if not self.meshes:
            raise InvalidInput("frames: there are none to write")
        _core.write_animation(
            target,
            [mesh.V for mesh in self.meshes],
            self.meshes[0].F,
            _arrays.number(frames_per_second, "frames_per_second"),
            _arrays.number(tolerance, "tolerance"),
        )

    def __repr__(self) -> str:
        worst = max((report.edge_rms for report in self.reports), default=0.0)
        return f"Frames({len(self)} meshes, edge errors at worst RMS {100 * worst:.3g} % of the mean length)"


@dataclass(frozen=True, eq=False)
class Scores:
    """Meshes in the modes of a model."""

    names: Tuple[str, ...]
    labels: Dict[str, Tuple[Optional[str], ...]]
    scores: Array  #: (N, K) coordinates along the modes; (K,) of a single V.
    deviations: Array  #: The same in standard deviations of the modes.
    sizes: Array  #: (N,) [length], or a number of shape () for a single V.
    residuals: Array  #: Distances to the span of the modes, likewise.

    def as_dict(self) -> Columns:
        """Columns as `shape project` writes them: mesh, labels, size, residual, pc1, pc2, ..."""
        rows = self.scores.reshape(len(self.names), -1)
        measured: Columns = {"size": self.sizes.reshape(-1), "residual": self.residuals.reshape(-1)}
        measured.update({f"pc{k + 1}": rows[:, k] for k in range(rows.shape[1])})
        for label in self.labels:
            if label == "mesh" or label in measured:
                raise InvalidInput(f"the label {label!r} has the name of another column of the table; rename it")
        return {"mesh": self.names, **self.labels, **measured}

    def table(self) -> Any:
        """as_dict() as a pandas.DataFrame."""
        return data_frame(self.as_dict())

    def __repr__(self) -> str:
        modes = self.scores.shape[-1]
        return f"Scores({len(self.names)} meshes in {modes} modes)"


@dataclass(frozen=True)
class Test:
    """A test by permutation; see docs/groups.md. Of what was not tested, all is NaN and the counts are 0."""

    sum_of_squares: float  #: Explained by the groups.
    residual_sum_of_squares: float  #: Explained by nothing.
    total_sum_of_squares: float  #: About the mean of all.
    degrees_of_freedom: int
    residual_degrees_of_freedom: int
    f: float  #: Ratio of the mean squares.
    r_squared: float  #: sum_of_squares / total_sum_of_squares.
    p_value: float  #: (1 + #{permuted F >= F}) / (1 + permutations).
    permutations: int  #: 0 where no degree of freedom is left.
    smallest_p: float  #: The smallest p_value there is: 1 / (permutations + 1), or what the design allows.

    def __repr__(self) -> str:
        if self.residual_degrees_of_freedom == 0:
            return "Test(too few meshes for a test)"
        text = (
            f"Test(F({self.degrees_of_freedom}, {self.residual_degrees_of_freedom}) = {self.f:.4g}, "
            f"R2 = {self.r_squared:.4g}, "
        )
        if self.permutations == 0:
            return text + "not tested)"
        return text + f"p = {self.p_value:.4g})"


@dataclass(frozen=True)
class PairTest:
    """Two groups against each other."""

    first: str
    second: str
    distance: float  #: Between the means of the groups.
    radius: float  #: The true difference lies so near to the measured one, at 95 % (bootstrap).
    design: str  #: "crossed" (within blocks that have both groups) or "nested".
    test: Test
    adjusted_p: float  #: For all pairs that were tested (Holm).


#: Columns of the program's table -> fields of Test.
_TEST_COLUMNS = {
    "df": "degrees_of_freedom",
    "residual_df": "residual_degrees_of_freedom",
    "sum_of_squares": "sum_of_squares",
    "residual_sum_of_squares": "residual_sum_of_squares",
    "r_squared": "r_squared",
    "f": "f",
    "p_value": "p_value",
    "permutations": "permutations",
}


@dataclass(frozen=True)
class Groups:
    """Whether groups differ, all at once and two at a time."""

    names: Tuple[str, ...]
    counts: Tuple[int, ...]  #: Meshes in each group.
    design: str  #: "crossed" (compared within blocks) or "nested"; see docs/groups.md.
    left_out: int  #: Meshes of blocks that lie in one group, where others have several.
    overall: Test
    pairs: Tuple[PairTest, ...]

    def as_dict(self) -> Columns:
        """The table that `shape groups` writes: a row for all groups at once, then one for each pair.

        first, second, distance and radius are None in the first row.
        """
        tests = [self.overall, *(pair.test for pair in self.pairs)]
        columns: Columns = {
            name: [None, *(getattr(pair, name) for pair in self.pairs)]
            for name in ("first", "second", "distance", "radius")
        }
        columns.update(
            {column: [getattr(test, field) for test in tests] for column, field in _TEST_COLUMNS.items()}
        )
        columns["p_adjusted"] = [self.overall.p_value, *(pair.adjusted_p for pair in self.pairs)]
        return columns

    def table(self) -> Any:
        """as_dict() as a pandas.DataFrame."""
        return data_frame(self.as_dict())

    def __repr__(self) -> str:
        of = ", ".join(f"{name} ({count})" for name, count in zip(self.names, self.counts))
        return f"Groups({of}: {self.overall!r})"


@dataclass(frozen=True, eq=False)
class Distances:
    """Distances between all meshes of a collection."""

    names: Tuple[str, ...]
    matrix: Array  #: (N, N), symmetric, 0 on the diagonal.

    def as_dict(self) -> Columns:
        """Columns as `shape distance` writes them."""
        columns: Columns = {"mesh": self.names}
        columns.update({name: self.matrix[:, i] for i, name in enumerate(self.names)})
        return columns

    def table(self) -> Any:
        """A pandas.DataFrame with the names of the meshes as index and columns."""
        return data_frame(self.as_dict()).set_index("mesh")

    def __repr__(self) -> str:
        return f"Distances({len(self.names)} meshes, largest {self.matrix.max():.4g})"


@dataclass(frozen=True, eq=False)
class Edges:
    """The edges of a mesh: row e of each array is edge e, wherever the library has one."""

    ends: Indices  #: (#E, 2), the lower vertex first, sorted.
    lengths: Array  #: (#E,) [length]
    dihedral_angles: Array  #: (#E,) [rad], 0 flat, > 0 convex seen from outside, 0 on the boundary.

    def __repr__(self) -> str:
        return f"Edges({len(self.lengths)}, mean length {self.lengths.mean():.4g})"
