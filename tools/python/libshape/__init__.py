# SPDX-License-Identifier: MIT
"""Statistics of triangle meshes in the space of their edge lengths.

The whole flow::

    import libshape as ls
    c = ls.read("faces/", labels="labels.csv")      # a Collection: meshes in correspondence
    m = c.model(modes=20)                           # a Model: mean, modes, variances
    mesh, report = m.decode([-2, 1, 0])             # a Mesh at scores in standard deviations
    scores = m.scores(mesh.V)                       # and back
    frames = ls.interpolate(c[0], c[1], frames=60)  # a path between two meshes
    ls.groups(c, by="expression").table()           # do groups differ?
    m.explorer("page.html")                         # the model in the hand, in a browser

Vertices `V` are (n, 3) float64 [unit of the input], faces `F` are (m, 3) int64, counter-clockwise seen
from outside. A `Mesh` unpacks to (V, F). float32, int32 and lists are taken; other shapes and kinds
raise a TypeError that names argument and shape. Results are the same bits as those of the program
`shape`. Long work lets other Python threads run, and Ctrl-C ends it at once.

`progress` is None, True (a bar of tqdm, if that is installed) or a function of (stage, done, total).
"""
from ._arrays import Array, Indices, Progress
from ._collection import Collection, collection, read, read_mesh, synthetic
from ._core import version as _version
from ._difference import Difference, difference, read_difference
from ._errors import Error, FileError, InvalidInput, LimitExceeded, NumericalError
from ._interpolation import interpolate
from ._measures import distance, edges, groups
from ._mesh import Mesh, MeshLike
from ._model import Model, read_model
from ._registration import fit
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
from ._threads import set_thread_count, thread_count

__version__ = _version()

__all__ = [
    "Array",
    "Collection",
    "Difference",
    "Distance",
    "Distances",
    "Edges",
    "Error",
    "FileError",
    "FitReport",
    "Frames",
    "Groups",
    "Indices",
    "InvalidInput",
    "LimitExceeded",
    "Mesh",
    "MeshLike",
    "Model",
    "NumericalError",
    "PairTest",
    "Progress",
    "Report",
    "Scores",
    "Test",
    "collection",
    "difference",
    "distance",
    "edges",
    "fit",
    "groups",
    "interpolate",
    "read",
    "read_difference",
    "read_mesh",
    "read_model",
    "set_thread_count",
    "synthetic",
    "thread_count",
]
