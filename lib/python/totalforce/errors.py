# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Exceptions of totalforce.

All derive from Error and, where Python has one, from the built-in exception of that meaning.
"""
from __future__ import annotations

import os
from typing import Any, Optional, Sequence


class Error(Exception):
    """A request, a robot or a connection failed.

    Attributes
    ----------
    status : str
        name of the status, for instance 'E_SIZE'
    code : int
        its number, negative
    summary, cause : str
        short text of the status; cause and remedy
    field : str or None
        argument that the error is about: 'q', 'tips', ...
    index, state : int
        invalid entry within one state; state of a batch
    link, joint, constraint : str or None
        link, joint or constraint that the error is about
    reply : Reply or None
        answers of the states that did not fail
    """

    status: str = "E_UNKNOWN"
    code: int = 0
    summary: str = ""
    cause: str = ""
    field: Optional[str] = None
    index: int = 0
    state: int = 0
    link: Optional[str] = None
    joint: Optional[str] = None
    constraint: Optional[str] = None
    reply: Any = None

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class InputError(Error, ValueError):
    """An argument has a wrong size, value or name."""


class InputTypeError(Error, TypeError):
    """An argument has a type that cannot be read, or the op has no such argument."""


class NotComputedError(Error, ArithmeticError):
    """The problem is singular at this configuration, or the method cannot answer it."""


class UnsupportedError(Error, RuntimeError):
    """This robot, workspace or build cannot do that."""


class BusyError(Error, RuntimeError):
    """Another thread uses the object, or the ring is full."""


class TimedOutError(Error, TimeoutError):
    """No reply within the given time."""


class DisconnectedError(Error, ConnectionError):
    """There is no daemon, or the connection to it was lost."""


class RefusedError(Error, PermissionError):
    """The daemon or the system refuses this user."""


class SystemCallError(Error, OSError):
    """A system call failed."""


class OutOfMemoryError(Error, MemoryError):
    """An allocation failed."""


class LoadError(Error, ValueError):
    """A robot cannot be loaded.

    Attributes
    ----------
    messages : sequence of Message
        all messages of the report: severity, file, line, code, text
    file : str or None
        name of the file
    line : int
        line of the first error; 0: none
    """

    messages: Sequence[Any] = ()
    file: Optional[str] = None
    line: int = 0


class FileError(LoadError, OSError):
    """A file cannot be read: `errno` and `filename` as of OSError."""


class MissingFileError(FileError, FileNotFoundError):
    """There is no such file."""


_CLASSES = {
    "E_ARGUMENT": InputError,
    "E_SIZE": InputError,
    "E_VALUE": InputError,
    "E_QUATERNION": InputError,
    "E_ROBOT": InputError,
    "E_LINK": InputError,
    "E_JOINT": InputError,
    "E_METHOD": InputError,
    "E_SINGULAR": NotComputedError,
    "E_NOT_COMPUTED": NotComputedError,
    "E_RANK": NotComputedError,
    "E_OPEN": NotComputedError,
    "E_NO_MASS": LoadError,
    "E_PARSE": LoadError,
    "E_MODEL": LoadError,
    "E_FILE": FileError,
    "E_MEMORY": OutOfMemoryError,
    "E_AGAIN": BusyError,
    "E_BUSY": BusyError,
    "E_TIMEOUT": TimedOutError,
    "E_LATE": TimedOutError,
    "E_DISCONNECTED": DisconnectedError,
    "E_PROTOCOL": DisconnectedError,
    "E_LOST": DisconnectedError,
    "E_REFUSED": RefusedError,
    "E_SYSTEM": SystemCallError,
    "E_UNSUPPORTED": UnsupportedError,
}


def _set(error: Error, attributes: dict[str, Any]) -> Error:
    for name, value in attributes.items():
        if value is not None:
            setattr(error, name, value)
    return error


def _load_attributes(attributes: dict[str, Any]) -> None:
    messages = attributes.get("messages", ())
    errors = [message for message in messages if message.severity == "error"]
    if errors:
        attributes["line"] = errors[0].line
        attributes["link"] = attributes["joint"] = None
        kind, _, rest = errors[0].text.partition(" '")
        if kind in ("link", "joint") and "'" in rest:
            attributes[kind] = rest.partition("'")[0]


def make(*, text: str, errno: int = 0, **attributes: Any) -> Error:
    """The exception of a status. Called by the extension module."""
    kind = _CLASSES.get(attributes["status"], Error)
    if "messages" in attributes:
        _load_attributes(attributes)
        if not issubclass(kind, (LoadError, MemoryError)):
            kind = LoadError
    if issubclass(kind, FileError) and errno == 2:
        kind = MissingFileError
    error = _set(kind(text), attributes)
    if isinstance(error, OSError) and errno:
        error.errno = errno
        error.strerror = os.strerror(errno)
        error.filename = attributes.get("file")
    return error


def make_type_error(*, text: str, **attributes: Any) -> Error:
    """An InputTypeError. Called by the extension module."""
    return _set(InputTypeError(text), attributes)
