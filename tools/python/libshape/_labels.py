# SPDX-License-Identifier: MIT
"""Labels from dictionaries, tables of pandas and files, by the rules of docs/formats.md."""
from __future__ import annotations

import csv
import os
from contextlib import contextmanager
from typing import Any, Iterator, List, Sequence, Tuple

from . import _arrays, _core, _files
from ._errors import InvalidInput

Cells = List[Tuple[str, List[str]]]  #: Columns of labels; empty where a value is missing.


def _named_rows(labels: Any) -> bool:
    """Whether the rows of a table of pandas carry the names of meshes."""
    index = getattr(labels, "index", None)
    return index is not None and (index.name == "mesh" or all(isinstance(name, str) for name in index))


def _table(labels: Any) -> Tuple[List[str], Cells]:
    """Names of the rows, none if they have none, and columns."""
    columns = _arrays.columns(labels, "labels")
    cells = [(name, _arrays.cells(values, f"labels[{name!r}]")) for name, values in columns]
    for name, values in cells:
        if len(values) != len(cells[0][1]):
            raise TypeError(
                f"labels[{name!r}]: {len(values)} values, labels[{cells[0][0]!r}] has {len(cells[0][1])}"
            )
    names: List[str] = next((values for name, values in cells if name == "mesh"), [])
    if names:
        return names, [(name, values) for name, values in cells if name != "mesh"]
    if not hasattr(labels, "columns") or not _named_rows(labels):
        return [], cells
    return [str(name) for name in labels.index], cells


@contextmanager
def file_of(labels: Any) -> Iterator[str]:
    """A CSV file of labels whose rows carry names: the one given, or one while the block runs."""
    if isinstance(labels, (str, os.PathLike)):
        yield _arrays.path(labels, "labels")
        return
    names, cells = _table(labels)
    if not names:
        raise TypeError(
            "labels: must say which mesh each row is of, in a column `mesh` or as index of the DataFrame"
        )
    with _files.in_scratch("labels") as path:
        with open(path, "w", encoding="utf-8", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(["mesh", *(name for name, _ in cells)])
            rows.writerows(zip(names, *(values for _, values in cells)))
        yield path


def cells_of(labels: Any, names: Sequence[str]) -> Tuple[Cells, List[str]]:
    """Labels of the meshes of these names, and rows that are of others."""
    if labels is None:
        return [], []
    if not isinstance(labels, (str, os.PathLike)):
        row_names, cells = _table(labels)
        if not row_names:
            _check(cells, len(names))
            return cells, []
    with file_of(labels) as path:
        found, unused = _core.read_labels(path, list(names))
    return [(name, [value or "" for value in values]) for name, values in found.items()], unused


def _check(cells: Cells, count: int) -> None:
    seen = set()
    for name, values in cells:
        if len(values) != count:
            raise TypeError(f"labels[{name!r}]: {len(values)} values for {count} meshes")
        key = _core.label_value(name)
        if not key or key in seen:
            rule = "occurs twice" if key else "must name a label"
            raise InvalidInput(f"labels: {name!r} {rule}")
        seen.add(key)


def label_and_value(text: Any, name: str) -> Tuple[str, str]:
    """Label and value of "LABEL=VALUE", as the program takes them."""
    before, sign, after = text.partition("=") if isinstance(text, str) else ("", "", "")
    if not (before and sign):
        raise TypeError(f"{name}: must be 'LABEL=VALUE', is {_arrays.shown(text)}")
    label, value = _core.label_value(before), _core.label_value(after)
    if not value:
        raise InvalidInput(
            f"{name}: {text!r} names no value (empty, NA, NaN, NULL and so on mean that a mesh has none)"
        )
    return label, value
