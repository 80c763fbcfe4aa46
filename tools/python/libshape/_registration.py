# SPDX-License-Identifier: MIT
"""Templates laid onto raw scans."""
from __future__ import annotations

import os
from typing import Any, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from . import _arrays, _core
from ._arrays import Array, Path
from ._errors import InvalidInput
from ._mesh import Mesh, MeshLike, name_of
from ._results import Distance, FitReport


def fit(
    template: MeshLike,
    scan: Union[MeshLike, Path],
    landmarks: Optional[Mapping[str, Tuple[Any, Any]]] = None,
    *,
    landmark_tolerance: float = 0.0,
    boundaries: Sequence[str] = (),
    smoothness: float = 4.0,
    growth_smoothness: float = 50.0,
    search: bool = True,
) -> Tuple[Mesh, FitReport]:
    """The template laid onto a raw scan of any triangulation, as `shape fit`, to the same bits.

    template: one connected surface. scan: a mesh, or the path of a file; holes, several parts and odd faces are
    all right.
    landmarks: name -> (on the template, on the scan), each (x, y, z), the first also a vertex of the template
    (from 0). Three or more, not on a line, give the start.
    landmark_tolerance: how far they may be missed [length of the scan], >= 0; 0: 1e-3 of the diagonal.
    boundaries: names of landmarks at boundary loops that correspond from end to end; default: loops near each
    other do.
    smoothness: weight of the dihedral angles beside the lengths, > 0; larger: folds of the template are kept.
    growth_smoothness: weight that lets neighbours grow alike, > 0.
    search: look for where the template starts; else it starts where it lies.
    The mesh has the template's faces and the scan's place and unit; look at `report.status`: a scan that the
    template does not fit raises nothing. Raises InvalidInput if a rule is broken.
    """
    vertices, corners = _arrays.mesh(template, "template")
    if isinstance(scan, (str, os.PathLike)):
        raw, raw_faces, name = _core.read_scan(_arrays.path(scan, "scan"))
    else:
        raw, raw_faces = _arrays.mesh(scan, "scan")
        name = name_of(scan, "fit")
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
