"""Building a wheel: the C libraries of the package are compiled where there is a compiler (see nospill.native)."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

sys.path.insert(0, str(Path(__file__).with_name("src")))
from nospill.native import libraries

COMPILER = shutil.which(os.environ.get("CC", "cc")) if os.name == "posix" else None


class WithLibraries(build_py):
    """The package and its compiled libraries; an editable installation compiles them at their first use."""

    def run(self) -> None:
        """Compile after everything else is in its place."""
        super().run()
        if COMPILER is None or self.editable_mode:
            return
        folder = Path(self.build_lib) / libraries.CARRIED.relative_to(libraries.CARRIED.parents[2])
        try:
            libraries.compile_into(folder, COMPILER)
        except (OSError, subprocess.SubprocessError) as error:
            print(
                f"nospill: libraries are not compiled into the wheel, but at their first use: {error}", file=sys.stderr
            )


class OfThisPlatform(Distribution):
    """Not pure Python where there is a compiler."""

    def has_ext_modules(self) -> bool:
        """Whether there is one."""
        return COMPILER is not None


class ForEveryPython(bdist_wheel):
    """A wheel that uses no ABI of Python's."""

    def get_tag(self) -> tuple[str, str, str]:
        """Whose platform alone is that of the compiler."""
        return "py3", "none", super().get_tag()[2]


setup(distclass=OfThisPlatform, cmdclass={"build_py": WithLibraries, "bdist_wheel": ForEveryPython})
