"""Case files that were damaged at random, and case files with one extreme value.

Half of the attempts are damaged files of a mill and of a mechanism, half are the published mill with one
extreme value of one of its keys.  All are read; of one in `SHEETS` the pre-flight sheet is made as well.
"""

import functools
import random
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from nutamill.base.schema import SIZES, Quantity
from nutamill.base.units import EXAMPLES, UNITS
from nutamill.case import Case, Machine, case_of_text, load_case
from nutamill.case.toml.messages import fields_at
from nutamill.design.machine_sheet import machine_sheet
from nutamill.design.preflight import preflight

PLAIN = ["mechanism.mounting=rigid", "charge.count=50"]
"""Changes of the published mill that make its pre-flight sheet quick."""
PENDULUM = """
title = "pendulum"
[[bodies]]
name = "bob"
mass = "1 kg"
inertia = ["0.01 kg m^2", "0.01 kg m^2", "0.01 kg m^2"]
position = ["0 m", "0 m", "-1 m"]
[[joints]]
name = "hinge"
kind = "revolute"
between = ["ground", "bob"]
point = ["0 m", "0 m", "0 m"]
axis = [0, 1, 0]
[[bushings]]
name = "pad"
between = ["ground", "bob"]
point = ["0 m", "0 m", "-1 m"]
axis = [0, 0, 1]
shear_stiffness = "10 N/mm"
[[drives]]
name = "motor"
joint = "hinge"
speed = "10 rpm"
ramp = "10 rpm/s"
[run]
until = "1 s"
"""
"""A mechanism of listed parts."""
FOREIGN = "\x00\x1b\u202e\u2028\ufeff\"'[]{}=#.,\\\n\r\té½√😀"
"""Characters that damage puts in."""
NASTY = (
    "",
    '""',
    "nan",
    "-inf",
    "true",
    "[]",
    "{}",
    "0",
    "-1",
    "1e308",
    '"1e300 m"',
    '"1e-300 s"',
    "9" * 30,
    '"\\u001b[2J"',
)
"""Values that damage puts in."""


SHEETS = 100
"""One attempt in so many is taken as far as the pre-flight sheet, which takes a second [1]."""


class HostileCase(NamedTuple):
    """A case file, or a change of the published mill."""

    group: str
    """What was done to it, for the table."""
    name: str
    """Which one it is."""
    text: str = ""
    """Its TOML text."""
    changes: tuple[str, ...] = ()
    """Instead of a text: changes of the published mill."""


def attempts(number: int, seed: int) -> Iterator[tuple[str, str, Callable[[], Any]]]:
    """Yield the group, the name and the reading of so many hostile case files."""
    checked(HostileCase("", "sound", changes=("run.seed = 1",)))  # compiled kernels are loaded once
    hostile = [*mutants(number - number // 2, seed), *sampled(number // 2, seed)]
    for count, case in enumerate(hostile):
        if count % SHEETS == SHEETS - 1:
            yield "pre-flight sheet", f"sheet of {case.name}", functools.partial(checked, case)
        else:
            yield case.group, case.name, functools.partial(read, case)


def mutants(number: int, seed: int) -> Iterator[HostileCase]:
    """Yield complete case files of a mill and of a mechanism with one to three random damages each."""
    draw = random.Random(seed)
    sound = (load_case("numill", PLAIN).to_toml(), PENDULUM)
    for count in range(number):
        text = draw.choice(sound)
        done = [draw.choice(DAMAGES) for _ in range(draw.randint(1, 3))]
        for damage in done:
            text = damage(text or "\n", draw)
        names = [damage.__name__.strip("_").replace("_", " ") for damage in done]
        yield HostileCase(names[0], f"mutant {count} of seed {seed}: {', '.join(names)}", text)


def extremes() -> list[HostileCase]:
    """Return the mill's case file once for each of its keys and each extreme value of it."""
    case = load_case("numill", PLAIN)
    content = case.model_dump(by_alias=True, exclude_none=True)
    keys = [key for key in _leaves(content) if key not in ("schema", "title")]
    changes = [f"{key} = {value}" for key in keys for value in _values(key)]
    return [HostileCase("extreme value", change, changes=(change,)) for change in changes]


def read(attempt: HostileCase) -> Case | Machine:
    """Return the case that the text or the changes describe.

    Raises
    ------
    CaseError : the text is refused
    """
    if attempt.changes:
        return load_case("numill", [*PLAIN, *attempt.changes])
    return case_of_text(attempt.text)


def checked(attempt: HostileCase) -> None:
    """Read a case and make its pre-flight sheet.

    Raises
    ------
    CaseError, StepError : the case is refused
    """
    case = read(attempt)
    sheet = machine_sheet(case) if isinstance(case, Machine) else preflight(case)
    sheet.lines()


def sampled(number: int, seed: int) -> list[HostileCase]:
    """Return a random choice of the extremes, always the same for a seed; pairs of them where more are asked
    for.
    """
    every, draw = extremes(), random.Random(seed)
    pairs = [draw.sample(every, 2) for _ in range(number - len(every))]
    found = draw.sample(every, min(number, len(every)))
    for one, other in pairs:
        name = f"{one.name} and {other.name}"
        found.append(HostileCase("two extreme values", name, changes=one.changes + other.changes))
    return found


def _leaves(content: Any, above: str = "") -> Iterator[str]:
    """Dotted keys of all values that are no tables."""
    if isinstance(content, dict):
        for key, value in content.items():
            yield from _leaves(value, f"{above}.{key}" if above else key)
    else:
        yield above


def _values(key: str) -> list[str]:
    """Extreme values of a key, as they are typed."""
    *table, last = key.split(".")
    field = fields_at(Case, tuple(table)).get(last)
    quantity = next((mark for mark in field.metadata if isinstance(mark, Quantity)), None) if field else None
    plain = [
        "0",
        "-1",
        "1",
        "1e-300",
        "1e300",
        "nan",
        "9223372036854775807",
        "1e12",
        "true",
        '"x"',
        "[]",
        "{}",
    ]
    if quantity is None:
        return plain
    unit, (smallest, largest) = next(iter(UNITS[quantity.kind])), SIZES[quantity.kind]
    sizes = (
        0.0,
        smallest,
        largest,
        1e-300,
        1e300,
        -largest,
        10 * largest,
        0.1 * smallest,
        smallest**0.5,
        largest**0.5,
    )
    return [
        *plain,
        *(f'"{size:g} {unit}"' for size in sizes),
        f'"{EXAMPLES[quantity.kind]} x"',
        f'"nan {unit}"',
    ]


def _spot(text: str, draw: random.Random) -> int:
    return draw.randrange(len(text) + 1)


def _character_in(text: str, draw: random.Random) -> str:
    at = _spot(text, draw)
    return text[:at] + draw.choice(FOREIGN) + text[at:]


def _characters_out(text: str, draw: random.Random) -> str:
    at = _spot(text, draw)
    return text[:at] + text[at + draw.choice((1, 1, 1, 2, 10, 100)) :]


def _bit_flipped(text: str, draw: random.Random) -> str:
    at = draw.randrange(len(text))
    return text[:at] + chr(ord(text[at]) ^ (1 << draw.randrange(7))) + text[at + 1 :]


def _cut_off(text: str, draw: random.Random) -> str:
    return text[: _spot(text, draw)]


def _line_out(text: str, draw: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    del lines[draw.randrange(len(lines)) : draw.randrange(len(lines)) + 1]
    return "".join(lines) or "\n"


def _line_twice(text: str, draw: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    lines.insert(draw.randrange(len(lines) + 1), draw.choice(lines))
    return "".join(lines)


def _lines_swapped(text: str, draw: random.Random) -> str:
    lines = text.splitlines(keepends=True)
    a, b = draw.randrange(len(lines)), draw.randrange(len(lines))
    lines[a], lines[b] = lines[b], lines[a]
    return "".join(lines)


def _value_replaced(text: str, draw: random.Random) -> str:
    lines = text.splitlines()
    at = draw.choice([k for k, line in enumerate(lines) if "=" in line] or [0])
    lines[at] = f"{lines[at].partition('=')[0]}= {draw.choice(NASTY)}"
    return "\n".join(lines) + "\n"


def _number_scaled(text: str, draw: random.Random) -> str:
    """Append an exponent to one of the digits."""
    digits = [at for at, character in enumerate(text) if character.isdigit()]
    if not digits:
        return text
    at = draw.choice(digits)
    return f"{text[: at + 1]}e{draw.choice((-300, -20, -6, -3, 3, 6, 20, 300))}{text[at + 1 :]}"


DAMAGES: tuple[Callable[[str, random.Random], str], ...] = (
    _character_in,
    _characters_out,
    _bit_flipped,
    _cut_off,
    _line_out,
    _line_twice,
    _lines_swapped,
    _value_replaced,
    _number_scaled,
)
"""The ways in which a file is damaged."""
