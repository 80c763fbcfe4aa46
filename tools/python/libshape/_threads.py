# SPDX-License-Identifier: MIT
"""The number of threads."""
from __future__ import annotations

from . import _arrays, _core


def thread_count() -> int:
    """Threads that the library may use; at first, the number of processors."""
    return _core.thread_count()


def set_thread_count(count: int) -> None:
    """Sets thread_count() for the whole process, in [1, 1024]. Results do not depend on it."""
    _core.set_thread_count(_arrays.integer(count, "count"))
