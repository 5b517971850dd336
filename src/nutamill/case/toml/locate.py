"""Find the parts of a key, and the line of each key in TOML text that is already known to be sound."""

import re
import tomllib

_KEY = r"(?:[A-Za-z0-9_\-]+|\"(?:[^\"\\]|\\.)*\"|'[^']*')"
_DOTTED = rf"{_KEY}(?:\s*\.\s*{_KEY})*"
_HEADER = re.compile(rf"\s*\[\[?\s*({_DOTTED})\s*\]\]?\s*(?:#.*)?$")
_PAIR = re.compile(rf"\s*({_DOTTED})\s*=")
_TOKEN = re.compile(r'"""|\'\'\'|"(?:[^"\\]|\\.)*+"|\'[^\']*+\'|[\[\]{}#]')


def key_lines(text: str) -> dict[tuple[str | int, ...], int]:
    """Return the line (from 1) of every table header and key.

    Keys of inline tables have their parent's line.

    Tables of a list, ``[[charge.part]]``, are counted from 0: the key of the first is
    ``("charge", "part", 0)``.
    """
    lines: dict[tuple[str | int, ...], int] = {}
    table: tuple[str | int, ...] = ()
    listed: dict[tuple[str, ...], int] = {}
    open_brackets, open_quote = 0, ""
    for number, line in enumerate(text.splitlines(), start=1):
        if not open_brackets and not open_quote:
            if header := _HEADER.match(line):
                table = key_parts(header[1])
                lines.setdefault(table, number)
                if line.lstrip().startswith("[["):
                    listed[table] = listed.get(table, -1) + 1
                    table = (*table, listed[table])
                    lines[table] = number
                elif above := next(
                    (table[:n] for n in range(len(table) - 1, 0, -1) if table[:n] in listed), None
                ):
                    table = (*above, listed[above], *table[len(above) :])
                    lines.setdefault(table, number)
                continue
            if not (pair := _PAIR.match(line)):
                continue
            lines.setdefault((*table, *key_parts(pair[1])), number)
            line = line[pair.end() :]
        open_brackets, open_quote = _scan(line, open_brackets, open_quote)
    return lines


def key_parts(dotted: str) -> tuple[str, ...]:
    """Split a dotted key into its parts.

    A dot in quotes splits nothing.

    Raises
    ------
    ValueError : no key (tomllib's error is one too)
    """
    table = tomllib.loads(f"{dotted} = 0")
    parts = []
    while isinstance(table, dict):
        if len(table) != 1:
            raise ValueError(f"more than one key in {dotted!r}")
        part, table = next(iter(table.items()))
        parts.append(part)
    return tuple(parts)


def _scan(line: str, open_brackets: int, open_quote: str) -> tuple[int, str]:
    """Return the brackets and long strings still open at the end of the line."""
    at = 0
    while at < len(line):
        if open_quote:
            end = line.find(open_quote, at)
            if end < 0:
                return open_brackets, open_quote
            at, open_quote = end + 3, ""
            continue
        token = _TOKEN.search(line, at)
        if token is None or token.group() == "#":
            break
        at = token.end()
        if token.group() in ('"""', "'''"):
            open_quote = token.group()
        elif token.group() in "[{":
            open_brackets += 1
        elif token.group() in "]}":
            open_brackets -= 1
    return open_brackets, open_quote
