"""The command line of ``symdyn completion``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, get_args

import tyro

from symdyn.io.command_line import parsed

Shell = Literal["bash", "zsh", "fish"]


SHELLS: tuple[Shell, ...] = get_args(Shell)


@dataclass(frozen=True)
class CompletionArguments:
    """Print a script that makes the Tab key complete symdyn's commands and options. Ten seconds, once.

    bash: symdyn completion bash > ~/.local/share/bash-completion/completions/symdyn

    zsh: symdyn completion zsh > ~/.symdyn.zsh, and a line "source ~/.symdyn.zsh" in ~/.zshrc after compinit

    fish: symdyn completion fish > ~/.config/fish/completions/symdyn.fish

    Attributes:
        shell: bash, zsh or fish.
    """

    shell: Annotated[Shell, tyro.conf.Positional]


def parse(arguments: Sequence[str]) -> CompletionArguments:
    """The arguments of the command line. Raises SymdynError for bad input, SystemExit after ``--help``."""
    return parsed(CompletionArguments, arguments, "symdyn completion")
