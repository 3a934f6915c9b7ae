# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Why the extension module cannot be imported, and the remedy."""
from __future__ import annotations

import importlib.machinery
import pathlib
import re
import sys

BUILD = "pip install --no-build-isolation --force-reinstall --no-deps SOURCES_OF_TOTALFORCE"


def explain(error: BaseException) -> str:
    folder = pathlib.Path(__file__).parent
    built = sorted(path.name for path in folder.glob("_totalforce.*"))
    names = ["_totalforce" + end for end in importlib.machinery.EXTENSION_SUFFIXES]
    library = re.match(r"(\S+): cannot open shared object file", str(error))
    try:
        import numpy  # noqa: F401
    except ImportError as missing:
        return f"totalforce needs NumPy 1.22 or later ({missing}): pip install numpy"
    if library:
        return (
            f"totalforce needs the library {library[1]}, which is not installed: install Debian's "
            f"package of it, or the wheel, which carries its libraries: {BUILD}"
        )
    if not set(names) & set(built):
        have = ", ".join(name for name in built if not name.endswith(".pyi")) or "none"
        return (
            f"{folder} has no module for this interpreter, {sys.implementation.cache_tag} "
            f"({sys.executable}); but: {have}. Use that interpreter, or build: {BUILD}"
        )
    return f"totalforce cannot be imported from {folder}: {error}"
