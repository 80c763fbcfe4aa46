# SPDX-License-Identifier: MIT
"""Builds the Python package: CMake compiles its module, setuptools packs it.

SHAPE_PYTHON_MODULE names a module that is compiled already (the target shape_python) and is packed as it
is. SHAPE_CMAKE_OPTIONS are further options of CMake.
"""
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = Path(__file__).resolve().parent
VERSION = ".".join(
    re.findall(
        r"define SHAPE_VERSION_[A-Z]+ ([0-9]+)$",
        (ROOT / "libshape/base/version.h").read_text(),
        re.MULTILINE,
    )
)


class CMakeBuild(build_ext):
    def build_extension(self, ext: Extension) -> None:
        target = Path(self.get_ext_fullpath(ext.name)).resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        finished = os.environ.get("SHAPE_PYTHON_MODULE")
        if not finished:
            folder = Path(self.build_temp).resolve()
            subprocess.check_call(
                ["cmake", "-S", str(ROOT), "-B", str(folder), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                 "-DSHAPE_BUILD_PYTHON=ON", "-DSHAPE_BUILD_TOOLS=ON", "-DSHAPE_BUILD_TESTS=OFF",
                 f"-DPython3_EXECUTABLE={sys.executable}"]
                + shlex.split(os.environ.get("SHAPE_CMAKE_OPTIONS", ""))
            )
            subprocess.check_call(["cmake", "--build", str(folder), "--target", "shape_python"])
            (built,) = (folder / "tools/python/libshape").glob("_core*.so")
            finished = str(built)
        shutil.copyfile(finished, target)


setup(
    version=VERSION,
    packages=["libshape"],
    package_dir={"libshape": "tools/python/libshape"},
    package_data={"libshape": ["py.typed", "*.pyi"]},
    ext_modules=[Extension("libshape._core", sources=[])],
    cmdclass={"build_ext": CMakeBuild},
    zip_safe=False,
)
