"""A page for every command: what it is for, an example, and its ``--help``, as it prints it."""

from __future__ import annotations

import contextlib
import io
import os
from functools import cache

from symdyn_cli.commands import GROUPS, Command
from symdyn_cli.main import main

_FOLDER = "reference/commands"
_COLUMNS = 92


def nav() -> list[object]:
    """The commands by what one wants to do."""
    groups = [{group: [{name: f"{_FOLDER}/{name}.md"} for name in commands]} for group, commands in GROUPS.items()]
    return [f"{_FOLDER}/index.md", *groups]


def pages() -> dict[str, str]:
    """Markdown by path."""
    found = {f"{_FOLDER}/index.md": _index()}
    for commands in GROUPS.values():
        for name, command in commands.items():
            found[f"{_FOLDER}/{name}.md"] = _page(name, command)
    return found


@cache
def help_text(name: str) -> str:
    """What ``symdyn NAME --help-all`` prints on a terminal of 92 columns.

    Raises:
        RuntimeError: if it fails.
    """
    out, err = io.StringIO(), io.StringIO()
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = str(_COLUMNS)
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = main([name, "--help-all"])
    except SystemExit as stop:  # the parser's own way out
        code = stop.code
    finally:
        if before is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = before
    if code:
        raise RuntimeError(f"symdyn {name} --help-all ends with {code}: {err.getvalue()}")
    return "\n".join(line.rstrip() for line in out.getvalue().splitlines()).rstrip()


def _index() -> str:
    lines = [
        "# Commands",
        "",
        "`symdyn` alone prints this list; `symdyn COMMAND --help` explains every option. Bad input gives one sentence",
        "and exit code 2; Ctrl-C, where a command can go on later, code 130.",
    ]
    for group, commands in GROUPS.items():
        lines += ["", f"## {group}", "", "| command | what it does | example |", "|---|---|---|"]
        lines += [
            f"| [`{name}`]({name}.md) | {command.summary} | `{command.example}` |" for name, command in commands.items()
        ]
    return "\n".join(lines) + "\n"


def _page(name: str, command: Command) -> str:
    needs = "nothing but the base install" if command.extra is None else f"the extra `{command.extra}`"
    summary = command.summary[0].upper() + command.summary[1:]
    lines = [
        f"# symdyn {name}",
        "",
        f"{summary}.",
        "",
        "```sh",
        command.example,
        "```",
        "",
        f"Needs {needs} ([install](../../install.md)).",
        "",
        "## Options",
        "",
        f"What `symdyn {name} --help-all` prints:",
        "",
        "```text { .help }",
        help_text(name),
        "```",
    ]
    return "\n".join(lines) + "\n"
