"""Building a wheel: the C libraries of the package are compiled where there is a compiler (see nospill.native)."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

COMPILER = shutil.which(os.environ.get("CC", "cc")) if os.name == "posix" else None
SOURCE = Path(__file__).with_name("src")
PREBUILT = Path("nospill", "native", "prebuilt")


class BuildWithNative(build_py):
    """The package and its compiled libraries; an editable installation compiles them at their first use."""

    def run(self) -> None:
        """Compile after everything else is in its place."""
        super().run()
        if COMPILER is None or self.editable_mode:
            return
        command = [sys.executable, "-m", "nospill.native.libraries", str(Path(self.build_lib) / PREBUILT), COMPILER]
        if subprocess.run(command, env={**os.environ, "PYTHONPATH": str(SOURCE)}, check=False).returncode:
            print("nospill: libraries are not compiled into the wheel, but at their first use", file=sys.stderr)


class PlatformDistribution(Distribution):
    """Not pure Python where there is a compiler."""

    def has_ext_modules(self) -> bool:
        """Whether there is one."""
        return COMPILER is not None


class AbiIndependentWheel(bdist_wheel):
    """A wheel that uses no ABI of Python's, for every Linux whose C library is as new as its libraries ask for."""

    def get_tag(self) -> tuple[str, str, str]:
        """That of the compiler; where the libraries name versions of glibc, any Linux that has the newest (PEP 600)."""
        platform = super().get_tag()[2]
        libraries = (Path(self.get_finalized_command("build_py").build_lib) / PREBUILT).glob("*.so")
        wanted = [int(n) for file in libraries for n in re.findall(rb"\0GLIBC_2\.(\d+)", file.read_bytes())]
        if wanted and platform.startswith("linux_"):
            platform = platform.replace("linux", f"manylinux_2_{max(wanted)}", 1)
        return "py3", "none", platform


setup(distclass=PlatformDistribution, cmdclass={"build_py": BuildWithNative, "bdist_wheel": AbiIndependentWheel})
