"""Store compiled code in files, one for each function and key, that several processes may write at once.

The name of a file is made of the key, so that no process writes what another one takes for something else.
A file starts with a checksum: damaged code is never run.
"""

import contextlib
import hashlib
import os
import pickle
import uuid
from pathlib import Path

CHECKSUM_BYTES = 32


class CompiledFiles:
    """The stored versions of one function.

    Parameters
    ----------
    folder : is made when the first file is written
    name : of the function, with its module
    """

    def __init__(self, folder: Path, name: str):
        self._folder = folder
        self._name = "".join(letter if letter.isalnum() or letter in "._" else "-" for letter in name)

    def save(self, key: object, code: bytes) -> None:
        """Store pickled `code` under `key`, whose ``repr`` and equality are the same in every process.

        Raises OSError if the file cannot be written.
        """
        content = pickle.dumps((key, code))
        file = self._file(key)
        temporary = file.with_name(f"{file.name}.{uuid.uuid4().hex[:8]}")
        self._folder.mkdir(parents=True, exist_ok=True)
        try:
            temporary.write_bytes(hashlib.sha256(content).digest() + content)
            os.replace(temporary, file)
        except OSError:
            with contextlib.suppress(OSError):
                temporary.unlink()
            raise

    def load(self, key: object) -> object | None:
        """Return what was stored under `key`, unpickled. None if there is nothing, or it is damaged."""
        try:
            stored = self._file(key).read_bytes()
        except OSError:
            return None
        content = stored[CHECKSUM_BYTES:]
        if hashlib.sha256(content).digest() != stored[:CHECKSUM_BYTES]:
            return None
        stored_key, code = pickle.loads(content)
        return pickle.loads(code) if stored_key == key else None

    def flush(self) -> None:
        """Remove all that is stored of the function."""
        for file in self._folder.glob(f"{self._name}-*.compiled"):
            with contextlib.suppress(OSError):
                file.unlink()

    def _file(self, key: object) -> Path:
        digest = hashlib.sha256(repr(key).encode()).hexdigest()[:24]
        return self._folder / f"{self._name}-{digest}.compiled"
