# SPDX-License-Identifier: MIT
"""What the package raises, and how errors of the library become that (tools/python/module.cpp)."""
from __future__ import annotations

import errno
import os
import re
import warnings
from typing import Dict, Iterable, Type


class Error(Exception):
    """Base of everything that libshape raises on purpose, but for TypeError, KeyError and IndexError."""


class InvalidInput(Error, ValueError):
    """A rule is broken; the message names argument (or file), place, value and rule."""


class NumericalError(Error, ArithmeticError):
    """A computation broke down: a factorisation failed, or a value is not finite."""


class FileError(Error, OSError):
    """The system refused to read or write a file; the message names path and cause.

    errno, strerror and filename are those of the system's error, or None. An error with a class of its own is
    of that class too: where a file is missing it is a FileNotFoundError.
    """

    _message = ""

    def __str__(self) -> str:
        return self._message or super().__str__()


class LimitExceeded(Error, ValueError):
    """The input is larger than a limit, which the message names."""


class FileNotFound(FileError, FileNotFoundError):
    __doc__ = FileError.__doc__


class FileExists(FileError, FileExistsError):
    __doc__ = FileError.__doc__


class FileNotPermitted(FileError, PermissionError):
    __doc__ = FileError.__doc__


class FileIsADirectory(FileError, IsADirectoryError):
    __doc__ = FileError.__doc__


class FileNotADirectory(FileError, NotADirectoryError):
    __doc__ = FileError.__doc__


_KINDS: Dict[int, Type[FileError]] = {
    errno.ENOENT: FileNotFound,
    errno.EEXIST: FileExists,
    errno.EACCES: FileNotPermitted,
    errno.EPERM: FileNotPermitted,
    errno.EISDIR: FileIsADirectory,
    errno.ENOTDIR: FileNotADirectory,
}
for _kind in (Error, InvalidInput, NumericalError, FileError, LimitExceeded):
    _kind.__module__ = "libshape"

#: How messages end, or go on after a path -> what the system calls it.
_CAUSES = {f": {os.strerror(number).lower()}": number for number in errno.errorcode}
_CAUSES[" does not exist"] = errno.ENOENT


#: Fields of the library's options whose arguments are called otherwise.
_ARGUMENTS = {
    "DifferenceOptions.from_label": "from_",
    "DifferenceOptions.to_label": "to",
    "DifferenceOptions.to_value": "to",
    "SpaceOptions.dihedral_weight": "with_dihedrals",
    "SpaceOptions.position_weight": "with_positions",
    "SpaceOptions.weighting": "area_weighted",
}


def _argument_of_field(field: "re.Match[str]") -> str:
    return _ARGUMENTS.get(field.group(0), field.group(1))


def _argument_of_option(option: "re.Match[str]") -> str:
    return option.group(1).replace("-", "_")


def in_python_words(message: str) -> str:
    """A message without the names that options have in C++ and on the command line.

    "ModelOptions.modes is 9" and "--modes is 9" become "modes is 9", "SpaceOptions.position_weight"
    "with_positions", "the method Closure" "the method 'closure'". Commands to type, which stand between backticks,
    stay.
    """
    parts = message.split("`")
    for i in range(0, len(parts), 2):
        text = re.sub(r"\b[A-Z]\w*Options\.(\w+)", _argument_of_field, parts[i])
        text = re.sub(r"\bthe method ([A-Z]\w*)", lambda name: f"the method '{name.group(1).lower()}'", text)
        text = re.sub(r"(?<!\w)--(force|triangulate)\b", r"\1=True", text)
        text = re.sub(r"^-o: ", "path: ", text)
        parts[i] = re.sub(r"(?<!\w)--([a-z][a-z-]*)", _argument_of_option, text)
    return "`".join(parts)


def warn(messages: Iterable[str]) -> None:
    """Warns the caller of the function that calls this."""
    for text in messages:
        warnings.warn(in_python_words(text), stacklevel=3)


def invalid_input(message: str) -> InvalidInput:
    return InvalidInput(in_python_words(message))


def numerical_error(message: str) -> NumericalError:
    return NumericalError(in_python_words(message))


def limit_exceeded(message: str) -> LimitExceeded:
    return LimitExceeded(in_python_words(message))


def other_error(message: str) -> Error:
    return Error(in_python_words(message))


def file_error(message: str) -> FileError:
    """The error of a message "PATH: CAUSE", or "cannot read PATH: CAUSE"."""
    number = next((n for cause, n in _CAUSES.items() if message.lower().endswith(cause)), None)
    if ": exists" in message:
        number = errno.EEXIST
    if number is None:
        error = FileError(message)
    else:
        error = _KINDS.get(number, FileError)(number, os.strerror(number), _path(message))
    error._message = in_python_words(message)
    return error


def _path(message: str) -> str:
    """The path that a message begins with; of a path with colons, as much as exists."""
    text = re.sub(r"^cannot (read|write) ", "", message)
    parts = text.split(": ")
    paths = [": ".join(parts[:i]) for i in range(1, len(parts) + 1)]
    return next((path for path in paths if os.path.lexists(path)), paths[0])
