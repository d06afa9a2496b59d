"""The command ``symdyn``: finds the subcommand and imports only what it needs.

A command is two modules: ``arguments.NAME`` with ``parse(arguments)``, which imports no heavy library, so that
``symdyn NAME --help`` appears at once; and ``NAME`` with ``run(parsed) -> exit code``, imported only to do the work.
"""

from __future__ import annotations

import contextlib
import errno
import importlib
import os
import sys
from collections.abc import Sequence
from typing import TextIO

from symdyn.errors import SymdynError, UnknownName
from symdyn.io.exit_codes import BAD_INPUT, INTERRUPTED
from symdyn.io.plain_characters import use_plain_characters
from symdyn_cli.commands import GROUPS, Command

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""What a full disk says, a used-up quota, and a limit on the size of files."""

_WIDTH = max(len(name) for group in GROUPS.values() for name in group)


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point. Returns the exit code: 0 done, 2 bad input, 130 interrupted.

    Args:
        arguments: of the command line, without the program's name; ``sys.argv`` if None.
    """
    use_plain_characters()
    given = list(sys.argv[1:] if arguments is None else arguments)
    if not given or given[0] in ("-h", "--help"):
        sys.stdout.write(overview())
        return 0
    if given[0] == "--version":
        from importlib.metadata import version

        sys.stdout.write(f"symdyn {version('symdyn-gaits')}\n")
        return 0
    commands = {name: command for group in GROUPS.values() for name, command in group.items()}
    try:
        if given[0] not in commands:
            raise UnknownName("command", given[0], commands)
        code = _run(given[0], commands[given[0]], given[1:])
        sys.stdout.flush()  # here, where a full disk or a reader that has gone is answered
        return code
    except SymdynError as error:
        return _fail(str(error))
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        # the reader (head, less) has gone; without this the interpreter complains once more while it exits
        _silence(sys.stdout)
        return 0
    except OSError as error:
        if error.errno not in _FULL:
            raise
        _silence(sys.stdout)
        return _fail(f"{error.filename or 'The output'} cannot be written: {error.strerror}.")


def _silence(stream: TextIO) -> None:
    """Let the interpreter flush a stream that can no longer be written to when it exits, without a complaint."""
    with contextlib.suppress(OSError, ValueError):  # a stream of a test has no number
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def overview() -> str:
    """The text of ``symdyn --help``: commands by what one wants to do, with an example each."""
    lines = [
        "symdyn: one definition of a gait for analysis, training and the robot.",
        "",
        "usage: symdyn COMMAND [options]",
    ]
    for group, commands in GROUPS.items():
        lines += ["", f"{group}:"]
        for name, command in commands.items():
            lines += [f"  {name:<{_WIDTH}} {command.summary}", f"  {'':<{_WIDTH}} $ {command.example}"]
    lines += ["", "'symdyn COMMAND --help' explains every option. 'symdyn --version' prints the version.", ""]
    return "\n".join(lines)


def _run(name: str, command: Command, arguments: list[str]) -> int:
    try:
        parsed = importlib.import_module(command.arguments).parse(arguments)
        module = importlib.import_module(command.module)
    except ModuleNotFoundError as error:
        if command.extra is None or error.name in (command.arguments, command.module):
            raise
        return _fail(
            f"{name} needs {error.name!r}, which is not installed. In a checkout of symdyn: "
            f"pip install -c constraints.txt -e '.[{command.extra}]' (docs/install.md)."
        )
    return module.run(parsed)


def _fail(message: str) -> int:
    sys.stderr.write(f"symdyn: error: {message}\n")
    return BAD_INPUT
