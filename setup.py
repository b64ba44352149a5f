# SPDX-License-Identifier: MIT
"""Builds the Python package: CMake compiles the extension, and the wheel contains the shared libraries that it needs.

SILVAFIT_BUILD_DIR names a build folder of CMake to use instead of a new one.
"""
import hashlib
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Distribution, setup
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:  # before setuptools 70
    from wheel.bdist_wheel import bdist_wheel

ROOT = pathlib.Path(__file__).resolve().parent
VERSION = re.search(r"project\(silvafit VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))[1]
# A source package has the bundled pages, so that npm and a network are not needed.
SHIPPED_PAGES = ROOT / "viewer" / "pages"
# What every Linux has and wheels may therefore use (PEP 600).
SYSTEM_LIBRARY = re.compile(r"(linux-vdso|ld-linux.*|lib(c|m|dl|rt|pthread|stdc\+\+|gcc_s))\.so")
# The oldest glibc beside which PEP 600's policies allow a version of libstdc++.
GLIBC_OF_LIBSTDCXX = {29: 34, 30: 35, 31: 38, 32: 38, 33: 39}


def output(*command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True).stdout


# ---------------------------------------------------------------- CMake
def build_folder(default):
    return pathlib.Path(os.environ.get("SILVAFIT_BUILD_DIR", default)).resolve()


def configure(build):
    options = {"SILVAFIT_BUILD_PYTHON": "ON", "SILVAFIT_PYTHON": sys.executable}
    if importlib.util.find_spec("pybind11"):
        import pybind11
        options["pybind11_DIR"] = pybind11.get_cmake_dir()
    if not (build / "CMakeCache.txt").exists():
        pages = not SHIPPED_PAGES.is_dir() and shutil.which("npm") is not None
        options |= {"CMAKE_BUILD_TYPE": "Release", "SILVAFIT_BUILD_CLI": "OFF", "SILVAFIT_BUILD_TESTS": "OFF",
                    "SILVAFIT_GDAL": "OFF", "SILVAFIT_BUILD_VIEWER": "ON" if pages else "OFF"}
        if shutil.which("ninja"):
            options["CMAKE_GENERATOR"] = "Ninja"
    subprocess.run(["cmake", "-S", ROOT, "-B", build, *(f"-D{name}={value}" for name, value in options.items())],
                   check=True)
    return build


def cmake_build(build, target):
    subprocess.run(["cmake", "--build", build, "--parallel", "--target", target], check=True)


def write_pages(build, folder):
    """The bundled pages, and the licences of what is compiled into them and into the extension."""
    if SHIPPED_PAGES.is_dir():
        shutil.copytree(SHIPPED_PAGES, folder)
        return
    folder.mkdir(parents=True)
    licences = [ROOT / "scripts" / "package-copyright", ROOT / "LICENSE"]
    if "SILVAFIT_BUILD_VIEWER:BOOL=ON" in (build / "CMakeCache.txt").read_text(encoding="utf-8"):
        cmake_build(build, "silvafit_viewer")
        for page in (build / "share" / "silvafit" / "viewer").glob("*.html"):
            shutil.copy(page, folder)
        licences.append(build / "viewer" / "workshop")
    (folder / "copyright").write_text(output(sys.executable, *licences), encoding="utf-8")


# ---------------------------------------------------------------- shared libraries
def foreign_libraries(extension):
    """The shared libraries that not every Linux has, by name."""
    lines = (line.split() for line in output("ldd", extension).splitlines())
    return {line[0]: pathlib.Path(line[2]).resolve() for line in lines
            if len(line) > 2 and not SYSTEM_LIBRARY.match(line[0])}


def own_name(name, path):
    """A name that no other package's copy of the library has: the loader knows libraries by their names."""
    digest = hashlib.sha256(path.read_bytes()).hexdigest()[:8]
    return name.replace(".so", f"-{digest}.so", 1)


def copy_licence(library, target):
    """Debian's copyright file of a library, where Debian has brought it."""
    if shutil.which("dpkg-query"):
        package = output("dpkg-query", "-S", f"*/{library.name}").split(":")[0]
        text = pathlib.Path(f"/usr/share/doc/{package}/copyright").read_text(encoding="utf-8")
        apache = pathlib.Path("/usr/share/common-licenses/Apache-2.0")
        # The file names this licence only, whose text has to come along.
        target.write_text(text + (apache.read_text(encoding="utf-8") if apache.name in text else ""), encoding="utf-8")


def bundle_libraries(extension):
    """Puts the libraries that an extension needs beside it, so that it works on every Linux that is not older."""
    folder = extension.parent / "libs"
    folder.mkdir()
    libraries = foreign_libraries(extension)
    names = {name: own_name(name, path) for name, path in libraries.items()}
    for name, path in libraries.items():
        shutil.copy(path, folder / names[name])
        copy_licence(path, folder / f"{names[name]}.copyright")
        subprocess.run(["patchelf", "--set-soname", names[name], folder / names[name]], check=True)
    renames = [word for pair in names.items() for word in ("--replace-needed", *pair)]
    for file, path in [(extension, "$ORIGIN/libs"), *((folder / name, "$ORIGIN") for name in names.values())]:
        # Two calls, because patchelf 0.14 takes one's argument for the other's.
        subprocess.run(["patchelf", *renames, file], check=True)
        subprocess.run(["patchelf", "--set-rpath", path, file], check=True)


def newest_symbol(files, prefix):
    found = re.findall(rf"\b{prefix}([\d]+)\b", "".join(output("readelf", "--version-info", file) for file in files))
    return max(map(int, found), default=0)


def glibc_version(package):
    """The 2.x of the oldest glibc that has all symbols that the files of a package use; None if that is not known."""
    files = [path for path in package.rglob("*.so*") if path.suffix != ".copyright"]
    libstdcxx = newest_symbol(files, r"GLIBCXX_3\.4\.")
    if libstdcxx > max(GLIBC_OF_LIBSTDCXX):
        return None
    return max(newest_symbol(files, r"GLIBC_2\."), GLIBC_OF_LIBSTDCXX.get(libstdcxx, 17))


# ---------------------------------------------------------------- commands of setuptools
class BuildPython(build_py):
    def run(self):
        # Files of an earlier build would become part of the wheel.
        shutil.rmtree(self.build_lib, ignore_errors=True)
        super().run()


class BuildExtension(build_ext):
    def run(self):
        build = configure(build_folder(self.build_temp))
        cmake_build(build, "silvafit_python")
        package = pathlib.Path(self.build_lib).resolve() / "silvafit"
        extension = package / self.get_ext_filename("_core")
        shutil.copy(build / "bindings" / "python" / extension.name, extension)
        if shutil.which("patchelf"):
            bundle_libraries(extension)
        shutil.copytree(ROOT / "models", package / "share" / "models", ignore=shutil.ignore_patterns("CMakeLists.txt"))
        write_pages(build, package / "share" / "viewer")
        # Signatures with all settings, which the extension knows.
        types = output(sys.executable, "-B", "-c", f"import sys; sys.path.insert(0, {str(package.parent)!r}); "
                                             "from silvafit import _settings; print(_settings.type_declarations())")
        (package / "__init__.pyi").write_text(types, encoding="utf-8")


class Wheel(bdist_wheel):
    def get_tag(self):
        python, abi, platform = super().get_tag()
        package = pathlib.Path(self.bdist_dir) / "silvafit"
        glibc = glibc_version(package) if (package / "libs").is_dir() else None
        if glibc:
            platform = platform.replace("linux_", f"manylinux_2_{glibc}_")
        return python, abi, platform


class SourcePackage(sdist):
    def make_release_tree(self, base_dir, files):
        super().make_release_tree(base_dir, files)
        write_pages(configure(build_folder("build")), pathlib.Path(base_dir) / "viewer" / "pages")


class WithExtension(Distribution):
    """A package whose extension CMake builds."""

    def has_ext_modules(self):
        return True


setup(version=VERSION, distclass=WithExtension,
      cmdclass={"build_py": BuildPython, "build_ext": BuildExtension, "bdist_wheel": Wheel, "sdist": SourcePackage})
