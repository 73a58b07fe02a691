"""Builds the package with setuptools and cffi from an installed libcollided-dev; the rest is in pyproject.toml."""

from setuptools import setup
from wheel.bdist_wheel import bdist_wheel


class AbiWheel(bdist_wheel):  # type: ignore[misc]
    """One wheel for each CPython from 3.11 on: the extension keeps to the limited API."""

    def get_tag(self):
        return "cp311", "abi3", super().get_tag()[2]


setup(cffi_modules=["build_native.py:ffibuilder"], cmdclass={"bdist_wheel": AbiWheel})
