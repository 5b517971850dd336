"""What every case file is, whatever it describes: frozen data with a name, a digest, and a way to TOML and
back.
"""

import functools
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar

from pydantic import PrivateAttr

from nutamill.base.errors import Fault
from nutamill.base.notebook_hook import notebook_html
from nutamill.base.schema import Frequency, Table, Time
from nutamill.case.titles import Origin, leaves
from nutamill.case.toml.layers import Layer, python_layer
from nutamill.case.toml.merge import merge
from nutamill.case.toml.messages import checked
from nutamill.case.toml.write import written

LONGEST_STEM = 100
"""Characters of a case's name that go into the name of its result [1]."""

DIGEST_CHARACTERS = 12
"""Characters of a case's digest that go into the name of its result [1]."""

RESULTS = Path("results")
"""Folder of a result for which no folder is given."""


class SnapshotPlan(Table):
    """When the whole state is recorded for pictures."""

    rate: Frequency
    """How often [Hz]."""
    last: Time
    """How long before the end of the run [s]."""


class CaseFile(Table):
    """Everything that is needed to repeat a run."""

    files: ClassVar[dict[str, Any]] = {}
    """Keys that name files known by their content elsewhere in the case, as pydantic excludes them: no part
    of the identity.
    """

    _name: str = PrivateAttr("case")
    _origin: Origin | None = PrivateAttr(None)

    def _repr_html_(self) -> str:
        return notebook_html("cases.case_html", self)

    @property
    def name(self) -> str:
        """Short name for file names: the stem of the case file, or the library name."""
        return self._name

    def file_in(self, folder: str | Path = RESULTS) -> Path:
        """Return the result file of the case in a folder: ``<name>-<digest>.h5``."""
        return Path(folder) / f"{self.name[:LONGEST_STEM]}-{self.digest[:DIGEST_CHARACTERS]}.h5"

    @property
    def warnings(self) -> list[Fault]:
        """What is possible but odd about the case."""
        return []

    @functools.cached_property
    def digest(self) -> str:
        """SHA-256 of the content, in hexadecimal: the identity of the case, whatever units or base it was
        written with.
        """
        content = json.dumps(_rounded(self._plain(exclude=self.files)), sort_keys=True)
        return hashlib.sha256(content.encode()).hexdigest()

    def _plain(self, **how: Any) -> dict[str, Any]:
        """Return the values of the case.

        A title derived from what was changed gives way to the title it came from.
        """
        content = self.model_dump(by_alias=True, exclude_none=True, **how)
        if "changed_from" in content:
            content["title"] = content.pop("changed_from")
        return content

    def with_(self, key: str | Mapping[str, Any] | None = None, value: Any = None, /, **changes: Any) -> Self:
        """Return the case with other values: ``case.with_("drive.speed", "500 rpm")`` or
        ``case.with_(drive__speed=52.36)``.

        Parameters
        ----------
        key, value : dotted key, as after ``--set``, and its new value; or new values by dotted key
        changes : more of them, with ``__`` in place of the dot
        Values are SI floats or text with a unit.  An entry of a list of tables is addressed by its name,
        ``"bodies.box.mass"``, or by its number from 0, ``"charge.part.1.mass"``.  A float that no machine has
        in SI, as 500 rad/s for a speed, gives a warning.

        Raises
        ------
        CaseError : every fault of the changed case
        """
        given = {name.replace("__", "."): new for name, new in changes.items()}
        if isinstance(key, Mapping):
            given.update(key)
        elif key is not None:
            given[key] = value
        plain = self._plain()
        layer = python_layer(given)
        typed = dict(leaves(layer.content, plain))
        case = validated(type(self), [Layer(plain, {}, Path.cwd()), layer], self.name, [], from_file=False)
        from nutamill.case.doubts import warn_of_doubts  # reads the keys of the kinds of case that begin here

        warn_of_doubts(given, stacklevel=2)
        if "title" in given:
            return case
        origin = self._origin or Origin(
            self.name, plain.get("title", ""), dict(leaves(self._plain(mode="json")))
        )
        return titled(case, origin._replace(changed={**origin.changed, **typed}))

    def to_toml(self) -> str:
        """Return the complete case file with every default. `Case.from_toml` reads back an equal case."""
        return written(self)

    @classmethod
    def from_toml(cls, text: str, name: str = "case") -> Self:
        """Return the case that complete TOML text describes, as `to_toml` writes it and a result file stores
        it.

        Raises
        ------
        CaseError : every fault
        """
        return validated(cls, [Layer.of_text(text, name)], name, [])

    def __eq__(self, other: object) -> bool:
        return isinstance(other, CaseFile) and self.digest == other.digest

    def __hash__(self) -> int:
        return hash(self.digest)


Case = TypeVar("Case", bound=CaseFile)


def validated(
    kind: type[CaseFile], layers: list[Layer], name: str, faults: list[Fault], *, from_file: bool = True
) -> Any:
    """Merge the layers and make the case of that `kind`, or raise the earlier faults with all others."""
    content, places, more = merge(layers)
    case = checked(kind, content, places, [*faults, *more], from_file)
    case._name = name
    return case


def titled(case: Case, origin: Origin) -> Case:
    """Return the case with a title that names in what it differs from its origin."""
    title = origin.title_with(dict(leaves(case._plain(mode="json")))) if origin.title else ""
    if title != origin.title:
        case = case.model_copy(update={"title": title, "changed_from": origin.title})
    case._origin = origin
    return case


def _rounded(value: Any) -> Any:
    """Return the floats rounded to 12 digits, so that a value given in another unit has the same digest."""
    if isinstance(value, float):
        return f"{value:.12g}"
    if isinstance(value, dict):
        return {key: _rounded(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_rounded(inner) for inner in value]
    return value
