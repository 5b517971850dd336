"""FMUs that installed packages carry."""

import importlib.metadata
import shutil

import pytest


def packaged(package, name, folder, *needs):
    """Copy an FMU that an installed package carries to a folder."""
    try:
        files, *_ = (importlib.metadata.files(one) or [] for one in (package, *needs))
    except importlib.metadata.PackageNotFoundError as error:
        pytest.skip(f"needs the package {error.name}")
    path = next(file for file in files if file.name == name and "win" not in file.parts[-2])
    shutil.copyfile(path.locate(), folder / name)
