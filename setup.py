# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The totalforce authors
"""Builds the Python package with CMake: `pip install .`, `pip wheel .`.

Beside the module lies every shared library that it needs, but those of the platform; they find one
another by DT_RPATH, which the libraries of the system, without a path of their own, inherit.
"""
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from wheel.bdist_wheel import bdist_wheel

SOURCE = pathlib.Path(__file__).resolve().parent
# what every system with the C library of the wheel's tag has (PEP 600)
PLATFORM = re.compile(r"lib(c|m|dl|pthread|rt|gcc_s|stdc\+\+)\.so\.|ld-linux|linux-vdso")
LINK = "-Wl,--disable-new-dtags"


def needed(library):
    """(name, path) of the shared libraries that one needs, at any depth"""
    listed = subprocess.run(["ldd", library], check=True, capture_output=True, text=True).stdout
    if "not found" in listed:
        sys.exit(f"{library}: {listed}")
    return re.findall(r"^\s*(\S+)(?: => (\S+))? \(", listed, re.M)


def copy_licence(name, folder):
    """Terms of a library that the wheel carries, where its package of Debian states them"""
    if not shutil.which("dpkg-query"):
        return
    owner = subprocess.run(["dpkg-query", "-S", f"*/{name}"], capture_output=True, text=True).stdout
    terms = pathlib.Path("/usr/share/doc", owner.split(":")[0], "copyright")
    if owner and terms.exists():
        folder.mkdir(exist_ok=True)
        shutil.copy(terms, folder / name)


class BuildModule(build_ext):
    def build_extension(self, ext):
        build = pathlib.Path(self.build_temp).resolve()
        made, package = build / "python/totalforce", pathlib.Path(self.get_ext_fullpath(ext.name))
        options = {
            "CMAKE_BUILD_TYPE": "Release",
            "TFA_ONLY_PYTHON": "ON",
            "Python3_EXECUTABLE": sys.executable,
            "CMAKE_LIBRARY_OUTPUT_DIRECTORY": made,
            "CMAKE_BUILD_WITH_INSTALL_RPATH": "ON",
            "CMAKE_INSTALL_RPATH": "$ORIGIN",
            "CMAKE_SHARED_LINKER_FLAGS": LINK,
            "CMAKE_MODULE_LINKER_FLAGS": LINK,
        }
        generator = ["-G", "Ninja"] if shutil.which("ninja") else []
        subprocess.check_call(
            ["cmake", "-S", SOURCE, "-B", build, *generator]
            + [f"-D{name}={value}" for name, value in options.items()]
            + shlex.split(os.environ.get("CMAKE_ARGS", ""))
        )
        subprocess.check_call(
            ["cmake", "--build", build, "--target", "totalforce_python", "--parallel"]
            + [str(self.parallel or os.cpu_count())]
        )
        package.parent.mkdir(parents=True, exist_ok=True)
        for old in package.parent.glob("*.so*"):
            old.unlink()
        shutil.copy(made / "_totalforce.pyi", package.parent)
        (module,) = made.glob("_totalforce*.so")
        shutil.copy(module, package)
        for name, path in needed(module):
            if not PLATFORM.match(pathlib.Path(name).name):
                shutil.copy(path, package.parent / name)
                copy_licence(name, package.parent / "licences")


class Wheel(bdist_wheel):
    """Named after the C library of this machine, the oldest one that is sure to do"""

    def get_tag(self):
        python, abi, platform = super().get_tag()
        version = os.confstr("CS_GNU_LIBC_VERSION").split()[1].replace(".", "_")
        return python, abi, platform.replace("linux_", f"manylinux_{version}_", 1)


os.makedirs(SOURCE / "build", exist_ok=True)
limited = sys.version_info >= (3, 11)  # lib/python/request/python_api.h
setup(
    version=re.search(r"VERSION ([\d.]+)", (SOURCE / "CMakeLists.txt").read_text().split("project(")[1])[1],
    ext_modules=[Extension("totalforce._totalforce", [], py_limited_api=limited)],
    cmdclass={"build_ext": BuildModule, "bdist_wheel": Wheel},
    options={
        "egg_info": {"egg_base": "build"},
        "bdist_wheel": {"py_limited_api": "cp311" if limited else False},
    },
)
