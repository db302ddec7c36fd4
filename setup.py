"""What pyproject.toml cannot say: the kernels are compiled when the package is built."""

from setuptools import setup

setup(cffi_modules=["fenics_mech/_kernels/build.py:builder"])
