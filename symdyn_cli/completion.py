"""``symdyn completion``: a script by which a shell completes commands, their options, and what options may be."""

from __future__ import annotations

import ast
import contextlib
import importlib
import io
import shlex
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from rich.console import Console

from symdyn_cli.arguments.completion import CompletionArguments
from symdyn_cli.commands import GROUPS, Command


@dataclass(frozen=True)
class Option:
    """An option of a command.

    Attributes:
        flags: that name it.
        takes: what follows: nothing, a file, one of ``choices``, or something else.
        choices: of which one follows.
        help: one line.
    """

    flags: tuple[str, ...]
    takes: Literal["nothing", "file", "choice", "value"]
    choices: tuple[str, ...] = ()
    help: str = ""


@dataclass(frozen=True)
class Words:
    """What can follow a command.

    Attributes:
        summary: of the command.
        names: for its first argument; empty if that is a file, or there is none.
        options: of the command.
    """

    summary: str
    names: tuple[str, ...]
    options: tuple[Option, ...]


def run(args: CompletionArguments) -> int:
    """The command."""
    with Console(stderr=True).status("asking every command for its options"):
        words = {name: words_of(command) for group in GROUPS.values() for name, command in group.items()}
    sys.stdout.write({"bash": bash, "zsh": zsh, "fish": fish}[args.shell](words))
    return 0


def words_of(command: Command) -> Words:
    """Ask a command, which has to be imported for that. One whose extra is not installed has no words but its name."""
    try:
        parse = importlib.import_module(command.arguments).parse
        names = _names(command)
    except ModuleNotFoundError:
        return Words(command.summary, (), ())
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.suppress(SystemExit):
        parse(["--tyro-print-completion", "bash"])
    # tyro's own script is for one command of one word, and long; what it knows stands in one line of it
    start = "COMPLETION_SPEC = "
    spec = next(line for line in printed.getvalue().splitlines() if line.startswith(start))
    found = ast.literal_eval(spec.removeprefix(start))
    return Words(command.summary, names, tuple(_option(entry) for entry in found["options"]))


def _names(command: Command) -> tuple[str, ...]:
    if command.names is None:
        return ()
    module, _, attribute = command.names.partition(":")
    return tuple(getattr(importlib.import_module(module), attribute))


def _option(entry: dict[str, Any]) -> Option:
    takes = {"flag": "nothing", "boolean": "nothing", "path": "file", "choice": "choice"}.get(entry["type"], "value")
    described = entry["description"].partition(" • ")
    return Option(
        tuple(entry["flags"]),
        takes,  # pyright: ignore[reportArgumentType]
        tuple(sorted(entry.get("choices", ()))),
        described[2] or described[0],
    )


def bash(words: dict[str, Words]) -> str:
    """The script for bash."""
    after, within = [], []
    for name, its in words.items():
        flags = [flag for option in its.options for flag in option.flags]
        within.append(f"{name}) options={_quoted(flags)} names={_quoted(its.names)} ;;")
        for option in its.options:
            if option.takes != "nothing":
                pattern = "|".join(f"'{name} {flag}'" for flag in option.flags)
                after.append(f"{pattern}) choices={_quoted(option.choices)} value=1 ;;")
    return "\n".join(
        [
            "# made by: symdyn completion",
            "_symdyn() {",
            "  local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]}",
            "  local options= names= choices= value=",
            "  COMPREPLY=()",
            '  if [ "$COMP_CWORD" -eq 1 ]; then',
            f'    COMPREPLY=($(compgen -W {_quoted([*words, "--help", "--version"])} -- "$current"))',
            "    return",
            "  fi",
            '  case "$command $before" in',
            *(f"    {line}" for line in after),
            "  esac",
            '  if [ -z "$value" ]; then',
            '    case "$command" in',
            *(f"      {line}" for line in within),
            "    esac",
            '    case "$current" in -*) choices=$options ;; *) choices=$names ;; esac',
            "  fi",
            '  COMPREPLY=($(compgen -W "$choices" -- "$current"))',
            "}",
            "# where nothing fits, names of files",
            "complete -o default -F _symdyn symdyn",
            "",
        ]
    )


def zsh(words: dict[str, Words]) -> str:
    """The script for zsh, which runs bash's."""
    return "autoload -U +X bashcompinit && bashcompinit\n" + bash(words)


def fish(words: dict[str, Words]) -> str:
    """The script for fish."""
    lines = ["# made by: symdyn completion", "complete -c symdyn -n __fish_use_subcommand -f"]
    for name, its in words.items():
        lines.append(f"complete -c symdyn -n __fish_use_subcommand -a {name} -d {_fish_quoted(its.summary)}")
        here = f"complete -c symdyn -n '__fish_seen_subcommand_from {name}'"
        if its.names:
            lines.append(f"{here} -f -a {_fish_quoted(' '.join(its.names))}")
        for option in its.options:
            flags = " ".join(f"-l {flag[2:]}" if flag.startswith("--") else f"-s {flag[1:]}" for flag in option.flags)
            takes = {
                "nothing": "",
                "file": " -r -F",
                "choice": f" -x -a {_fish_quoted(' '.join(option.choices))}",
                "value": " -x",
            }[option.takes]
            lines.append(f"{here} {flags}{takes} -d {_fish_quoted(option.help)}")
    return "\n".join([*lines, ""])


def _quoted(words: Sequence[str]) -> str:
    return shlex.quote(" ".join(words))


def _fish_quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace("'", "\\'")
    return f"'{escaped}'"
