"""What ``--help`` prints: plain text in 80 columns, commands under headings, no names of Python types."""

from collections.abc import Callable
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup

HEADINGS = {
    "cases": "Run a case",
    "runs": "Run a case",
    "page": "In a browser",
    "campaigns": "Many runs",
    "answers": "Answers for a designer",
    "readings": "Answers for a designer",
    "grinding": "Grinding and wear",
    "pictures": "Look at results",
    "measured": "Measured data",
    "information": "Information",
}
"""Heading of the commands of each file of this room, in the order in which help lists them."""


class PlainCommand(TyperCommand):
    """A command whose help lists arguments and options without the types of Python."""

    def collect_usage_pieces(self, ctx: Any) -> list[str]:
        """Return the words of the usage line. An argument that may be left out is in brackets."""
        arguments = [one for one in self.get_params(ctx) if one.param_type_name == "argument"]
        return [
            "[OPTIONS]",
            *(_argument(one) if one.required else f"[{_argument(one)}]" for one in arguments),
        ]

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments, then options."""
        shown = [(parameter, parameter.get_help_record(ctx)) for parameter in self.get_params(ctx)]
        arguments = [
            (_argument(parameter), record[1].replace("  [required]", ""))
            for parameter, record in shown
            if record is not None and parameter.param_type_name == "argument"
        ]
        options = [record for parameter, record in shown if record and parameter.param_type_name == "option"]
        for heading, rows in (("Arguments", arguments), ("Options", options)):
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)


class PlainGroup(TyperGroup):
    """All commands, under headings, each with the first sentence of its description in full."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section for each file of commands."""
        sections: dict[str, list[tuple[str, str]]] = {heading: [] for heading in HEADINGS.values()}
        for name, command in self.commands.items():
            sections[self._heading(command)].append((name, summary_of(command)))
        for heading, rows in sections.items():
            if rows:
                with formatter.section(heading):
                    formatter.write_dl(rows)

    def _heading(self, command: Any) -> str:
        module = getattr(command.callback, "__module__", "").rpartition(".")[2]
        return HEADINGS.get(module, HEADINGS["information"])


class App(typer.Typer):
    """A Typer application whose commands are `PlainCommand`."""

    def command(self, name: str | None = None, **how: Any) -> Callable[[Any], Any]:
        """Return the decorator of a command."""
        return super().command(name, cls=PlainCommand, **how)


def summary_of(command: Any) -> str:
    """Return the first sentence of what a command does."""
    text = " ".join((command.help or "").split("\n\n")[0].split())
    first, stop, _ = text.partition(". ")
    return first + stop.strip() if stop else text


def _argument(parameter: Any) -> str:
    """Return what help calls an argument."""
    return parameter.metavar or parameter.name.upper()
