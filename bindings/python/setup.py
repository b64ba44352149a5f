# SPDX-License-Identifier: MIT
"""The wheel of what CMake has built; make_wheel.py runs this in the staging folder."""
import os

from setuptools import Distribution, setup


class BuiltExtension(Distribution):
    """A package whose extension is there already."""

    def has_ext_modules(self):
        return True


setup(
    name="silvafit",
    version=os.environ["SILVAFIT_VERSION"],
    description="Nonlinear mixed-effects models, structural indices and 3D trees for forest inventories",
    license="MIT",
    license_files=["LICENSE"],
    packages=["silvafit"],
    package_data={"silvafit": ["*.so", "py.typed", "*.pyi", "share/**/*"]},
    python_requires=">=3.9",
    install_requires=["numpy", "pandas"],
    extras_require={
        "plots": ["matplotlib"],
        "sklearn": ["scikit-learn"],
        "geo": ["geopandas"],
        "progress": ["tqdm"],
    },
    distclass=BuiltExtension,
    zip_safe=False,
)
