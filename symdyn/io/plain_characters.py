"""Terminals whose encoding lacks a character show a plain one instead of a traceback."""

# what looks like an ASCII character is what this module is about
# ruff: noqa: RUF001

from __future__ import annotations

import codecs
import sys
import unicodedata
from typing import TextIO

ERRORS = "symdyn.plain"
"""Name of the error handler for streams."""

_PLAIN = {
    "─": "-", "━": "-", "│": "|", "┃": "|", "╭": "+", "╮": "+", "╰": "+", "╯": "+", "┏": "+", "┓": "+", "┗": "+",
    "┛": "+", "█": "#", "▏": "|", "•": "*", "→": "->", "←": "<-", "↔": "<->", "−": "-", "–": "-", "—": "-", "’": "'",
    "‘": "'", "“": '"', "”": '"', "…": "...", "≥": ">=", "≤": "<=", "≈": "~", "√": "sqrt", "×": "x", "·": ".",
    "°": " deg",
    "α": "alpha", "β": "beta", "γ": "gamma", "δ": "delta", "θ": "theta", "φ": "phi", "κ": "kappa", "π": "pi", "μ": "u",
    "Δ": "Delta", "Σ": "sum", "²": "^2", "³": "^3", "±": "+-",
}  # fmt: skip


def plain(text: str) -> str:
    """The same in ASCII: a known replacement, a letter without its accent, or a question mark; blocks become ``#``."""
    found = []
    for character in text:
        if character in _PLAIN:
            found.append(_PLAIN[character])
        elif "\u2800" <= character <= "\u28ff":  # Braille, of which rich makes spinners
            found.append("*")
        elif "\u2580" <= character <= "\u259f":
            found.append("#")
        else:
            base = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
            found.append(base or "?")
    return "".join(found)


def use_plain_characters(*streams: TextIO) -> None:
    """Let streams write a plain character for one that their encoding lacks.

    Args:
        streams: standard output and error if none are given; others than files of text are left alone.
    """
    codecs.register_error(ERRORS, _handle)
    for stream in streams or (sys.stdout, sys.stderr):
        if (reconfigure := getattr(stream, "reconfigure", None)) is not None:
            reconfigure(errors=ERRORS)


def _handle(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return plain(error.object[error.start : error.end]), error.end
