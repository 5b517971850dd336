"""Plain words: names and prose of source, tests and examples use the field's verb."""

import pathlib
import re

ROOT = pathlib.Path(__file__).parents[2]

DIALECT = re.compile(
    r"(?<![a-z])(found|told|tells?|laid|lies|kept|said|whose they are)(?![a-z])", re.IGNORECASE
)
"""Words that stand for another verb: "returns", "prints", "is at", "stored", "message"."""

FIELD = re.compile(r"not found|tension(: Literal\[| )\W*kept.*|\(``\"kept\"``\)")
"""Where such a word is the usual one: a file that does not exist, and the rule ``tension = "kept"``."""


def offences(text: str) -> list[str]:
    """Return the lines of a text with a word of the dialect, each after its number."""
    lines = ((number, FIELD.sub("", line)) for number, line in enumerate(text.splitlines(), start=1))
    return [f"{number}: {line.strip()}" for number, line in lines if DIALECT.search(line)]


def test_source_tests_and_examples_use_plain_words():
    here, wrong = pathlib.Path(__file__), []
    for folder in ("src", "tests", "examples"):
        for path in sorted((ROOT / folder).rglob("*.py")):
            if path != here:
                name = path.relative_to(ROOT).as_posix()
                wrong += [f"{name}:{line}" for line in offences(path.read_text(encoding="utf-8"))]
    assert not wrong, "\n".join(["say it with the verb of the field:", *wrong])


def test_the_words_are_seen_in_names_and_prose_and_not_inside_other_words():
    assert offences("laid = was_found(told)") and offences("# What is kept, tells")
    assert not offences("profound, folklies = retell('tub.stl not found'), 'tension kept'")
