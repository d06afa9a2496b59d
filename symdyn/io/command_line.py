"""Command lines from dataclasses of settings, and their help."""

from __future__ import annotations

import contextlib
import inspect
import io
import re
import shutil
import sys
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import field, fields, is_dataclass, make_dataclass
from typing import Annotated, Any, TextIO, TypeVar, get_type_hints

import docstring_parser
import tyro

C = TypeVar("C")

HELP, HELP_ALL = ("-h", "--help"), "--help-all"

_CONFIG = (tyro.conf.DisallowNone,)  # so that help says PATH, not {None}|PATH
_NARROWEST, _WIDEST = 40, 120
_PLACE = "PLACE_OF_THE_INTRODUCTION"


def parsed(
    kind: type[C],
    arguments: Sequence[str],
    prog: str,
    default: C | None = None,
    description: str | None = None,
    first: Sequence[str] = (),
) -> C:
    """The arguments of a command.

    Args:
        kind: dataclass of the arguments; its docstring up to ``Attributes:`` introduces the command.
        arguments: of the command line.
        prog: how the command is called.
        default: where the arguments start from; the dataclass's defaults if None.
        description: introduction in place of the docstring's; an empty line separates paragraphs.
        first: options that ``--help`` shows, by attribute with dots in between (``config.ppo.epochs``); ``--help-all``
            then shows all of them, in groups. If empty, ``--help`` shows all.

    Raises:
        SystemExit: after help (code 0) or for bad arguments (code 2).
        SymdynError: for a value that a dataclass of settings refuses.
    """
    given = list(arguments)
    text = introduction_of(kind) if description is None else description
    if HELP_ALL in given:
        return _help(kind, prog, text, default)
    if any(word in given for word in HELP):
        if not first:
            return _help(kind, prog, text, default)
        count = len(list(_leaves(kind if default is None else default)))
        text += f"\n\nThe most used options are below. All {count}, in groups: {prog} {HELP_ALL}"
        return _help(_excerpt(kind, default, first), prog, text, None)
    return _cli(kind, given, prog, text, default)


def introduction_of(kind: type) -> str:
    """A dataclass's docstring up to its attributes."""
    return (inspect.getdoc(kind) or "").partition("Attributes:")[0].rstrip()


def wrapped(text: str) -> str:
    """Paragraphs, wrapped for the terminal. An indented line stays a line of its own."""
    width = min(max(shutil.get_terminal_size().columns, _NARROWEST), _WIDEST)
    paragraphs = []
    for paragraph in text.strip().split("\n\n"):
        lines: list[str] = []
        for line in paragraph.splitlines():
            if line.startswith(" ") or not lines or lines[-1].startswith(" "):
                lines.append(line)
            else:
                lines[-1] += f" {line}"
        paragraphs.append("\n".join(_wrapped_line(line, width) for line in lines))
    return "\n\n".join(paragraphs)


def _cli(kind: Any, arguments: list[str], prog: str, description: str, default: Any) -> Any:
    if default is None:
        return tyro.cli(kind, args=arguments, prog=prog, description=description, config=_CONFIG)
    return tyro.cli(kind, args=arguments, prog=prog, description=description, config=_CONFIG, default=default)


class _Captured(io.StringIO):
    """Text that looks like the terminal that it is for."""

    def __init__(self, terminal: TextIO) -> None:
        super().__init__()
        self._terminal = terminal

    @property
    def encoding(self) -> str:  # pyright: ignore[reportIncompatibleVariableOverride]
        return getattr(self._terminal, "encoding", None) or "utf-8"

    def isatty(self) -> bool:
        return self._terminal.isatty()


def _help(kind: Any, prog: str, introduction: str, default: Any) -> Any:
    """Print help and exit. tyro joins the lines of a description, so the introduction is put in afterwards."""
    captured = _Captured(sys.stdout)
    try:
        with contextlib.redirect_stdout(captured):
            _cli(kind, ["--help"], prog, _PLACE, default)
    finally:
        text = captured.getvalue().replace(_PLACE, wrapped(introduction))
        sys.stdout.write(_without_marks(_without_none(text)))


def _without_marks(text: str) -> str:
    """Leave out the double backquotes of docstrings, and the braces around an optional list of values."""
    rows = []
    for row in text.splitlines(keepends=True):
        plain = re.sub(r"\{([A-Z \[\].]+)\}", r"\1  ", row)
        edge = plain.rfind("│")
        rows.append(
            plain[:edge].replace("``", "") + "  " * plain[:edge].count("``") + plain[edge:] if edge > 0 else plain
        )
    return "".join(rows)


def _without_none(text: str) -> str:
    """Leave out a default of None or of nothing; a row that held nothing else goes with it."""

    def erased(match: re.Match[str]) -> str:
        return re.sub(r"[^│\n]", "\0", match[0])

    text = re.sub(r"\(default:(?: *│?\n│? *| )(?:None)?\)", erased, text)
    rows = (row for row in text.splitlines(keepends=True) if not ("\0" in row and not row.strip("│ \0\n")))
    return "".join(rows).replace("\0", " ")


def _wrapped_line(line: str, width: int) -> str:
    indent = line[: len(line) - len(line.lstrip())]
    return textwrap.fill(
        line, width, subsequent_indent=f"{indent}    " if indent else "", break_long_words=False, break_on_hyphens=False
    )


def _leaves(value: Any) -> list[str]:
    """Dotted attributes of nested settings, of an instance or of a class with defaults."""
    found = []
    for item in fields(value):
        if isinstance(value, type):
            its = item.default_factory() if callable(item.default_factory) else item.default
        else:
            its = getattr(value, item.name)
        found += [f"{item.name}.{leaf}" for leaf in _leaves(its)] if is_dataclass(its) else [item.name]
    return found


def _excerpt(kind: type, default: Any, names: Sequence[str]) -> type:
    """A flat dataclass of some options, with the flags, defaults and explanations that they have in ``kind``."""
    made = []
    for number, name in enumerate(names):
        holder, value, flag = kind, default, []
        *path, last = name.split(".")
        for part in path:
            hint = get_type_hints(holder, include_extras=True)[part]
            if _name_in(hint) != "":
                flag.append(part)
            value = _default_of(holder, part) if value is None else getattr(value, part)
            holder = type(value)
        hint = get_type_hints(holder, include_extras=True)[last]
        extra: dict[str, Any] = (
            {}
            if tyro.conf.Positional in getattr(hint, "__metadata__", ())
            else {"name": ".".join([*flag, _name_in(hint) or last])}
        )
        its = _default_of(holder, last) if value is None else getattr(value, last)
        annotation = Annotated[hint, tyro.conf.arg(help=_meanings(holder)[last], **extra)]
        attribute = last if not extra else f"option_{number}"
        made.append((attribute, annotation, field(default=its)))
    return make_dataclass("Options", made, frozen=True)


def _name_in(hint: Any) -> str | None:
    """The name that an annotation gives an option, or None."""
    for note in getattr(hint, "__metadata__", ()):
        if getattr(note, "name", None) is not None:
            return note.name
    return None


def _default_of(kind: type, name: str) -> Any:
    (item,) = (item for item in fields(kind) if item.name == name)
    return item.default_factory() if callable(item.default_factory) else item.default


def _meanings(kind: type) -> Mapping[str, str]:
    """What the docstring says about each attribute."""
    found = docstring_parser.parse(inspect.getdoc(kind) or "", docstring_parser.DocstringStyle.GOOGLE)
    return {item.arg_name: " ".join((item.description or "").split()) for item in found.params}
