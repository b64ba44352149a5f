# SPDX-License-Identifier: MIT
"""Puts the extension, the sources and the data into one folder, makes a wheel of it and installs this."""
import argparse
import os
import pathlib
import shutil
import subprocess
import sys


def options():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("stage", "sources", "models", "pages", "license", "wheels", "install"):
        parser.add_argument(f"--{name}", type=pathlib.Path, required=True)
    parser.add_argument("--version", required=True)
    return parser.parse_args()


def fill_stage(given):
    package = given.stage / "silvafit"
    for old in package.iterdir():
        if old.suffix == ".so":
            continue
        shutil.rmtree(old) if old.is_dir() else old.unlink()
    ignored = shutil.ignore_patterns("__pycache__", "*.so")
    shutil.copytree(given.sources / "silvafit", package, dirs_exist_ok=True, ignore=ignored)
    share = package / "share"
    shutil.copytree(given.models, share / "models", ignore=shutil.ignore_patterns("CMakeLists.txt"))
    if given.pages.is_dir():
        shutil.copytree(given.pages, share / "viewer")
    shutil.copy(given.sources / "setup.py", given.stage)
    shutil.copy(given.license, given.stage)


def make_wheel(given):
    shutil.rmtree(given.wheels, ignore_errors=True)
    for old in ("build", "silvafit.egg-info"):
        shutil.rmtree(given.stage / old, ignore_errors=True)
    command = [sys.executable, "setup.py", "--quiet", "bdist_wheel", "--dist-dir", str(given.wheels.resolve())]
    subprocess.run(command, cwd=given.stage, check=True,
                   env=dict(os.environ, SILVAFIT_VERSION=given.version))
    return next(given.wheels.glob("*.whl"))


def install(wheel, folder):
    shutil.rmtree(folder, ignore_errors=True)
    subprocess.run([sys.executable, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps",
                    "--disable-pip-version-check", "--root-user-action=ignore",
                    "--target", str(folder), str(wheel)], check=True)


def main():
    given = options()
    fill_stage(given)
    install(make_wheel(given), given.install)


if __name__ == "__main__":
    main()
