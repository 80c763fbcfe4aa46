# SPDX-License-Identifier: MIT
"""Files that the package itself makes and looks after: scratch, outputs, and reading with care."""
from __future__ import annotations

import os
import re
import tempfile
import threading
from contextlib import contextmanager
from typing import Any, Callable, Iterator

from . import _arrays, _core
from ._errors import InvalidInput, file_error

_PREFIX = "libshape-"


@contextmanager
def in_scratch(name: str) -> Iterator[str]:
    """A path in a folder that lives as long as the block. Messages do not tell where that is."""
    with tempfile.TemporaryDirectory(prefix=_PREFIX) as folder:
        try:
            yield os.path.join(folder, name)
        except InvalidInput as error:
            raise InvalidInput(without_scratch(str(error))) from None


def without_scratch(text: str) -> str:
    """A text that calls files in scratch folders by their names alone."""
    return re.sub(re.escape(os.path.join(tempfile.gettempdir(), _PREFIX)) + r"\w+" + re.escape(os.sep), "", text)


def bytes_of(write: Callable[[str], None]) -> bytes:
    """The file of HDF5 that something writes."""
    with in_scratch("x.h5") as path:
        write(path)
        with open(path, "rb") as file:
            return file.read()


def of_bytes(content: bytes, read: Callable[[str], Any]) -> Any:
    with in_scratch("x.h5") as path:
        with open(path, "wb") as file:
            file.write(content)
        return read(path)


def check_output(path: str, force: bool) -> None:
    """Before long work: may something be written here? What is there is replaced only with force."""
    if not force and os.path.lexists(path):
        raise file_error(f"{path}: exists; force=True replaces it")
    folder = os.path.dirname(path.rstrip(os.sep)) or os.curdir
    if not os.path.isdir(folder):
        raise file_error(f"{path}: the directory {folder} does not exist")


def write_text(path: str, content: str) -> None:
    """Writes beside the target and renames into place, so that nothing is lost where it fails."""
    temporary = ""
    try:
        with tempfile.NamedTemporaryFile(
            "w", encoding="utf-8", newline="", dir=os.path.dirname(path) or os.curdir, delete=False
        ) as file:
            temporary = file.name
            file.write(content)
        mask = os.umask(0)
        os.umask(mask)
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
    except OSError as error:
        if temporary:
            os.unlink(temporary)
        raise file_error(f"cannot write {path}: {error.strerror}") from None


_isolating = 0  # blocks that ask for it just now
_isolating_lock = threading.Lock()


@contextmanager
def isolated(untrusted: bool) -> Iterator[None]:
    """While the block lasts, HDF5 is asked about files in child processes, if they are not trusted.

    The same goes for what other threads read meanwhile, which costs them time and nothing else.
    """
    global _isolating
    if not _arrays.flag(untrusted, "untrusted"):
        yield
        return
    with _isolating_lock:
        _isolating += 1
        _core.isolate_hdf5_files(True)
    try:
        yield
    finally:
        with _isolating_lock:
            _isolating -= 1
            _core.isolate_hdf5_files(_isolating > 0)
