"""Output on terminals that lack our characters, and that are narrow."""

# ruff: noqa: RUF001

from __future__ import annotations

import io
import os
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from symdyn.io.plain_characters import plain, use_plain_characters

EVERYTHING = """
import contextlib, sys
from symdyn_cli.main import main
for arguments in (["gaits"], ["gaits", "rotary_gallop"], ["gaits", "--observation"], ["robots"], ["robots", "go2"],
                  ["--help"], ["gaits", "--help"], ["deploy", "--help"], ["robot-sim", "--help"], ["record", "--help"],
                  ["gaits", "trott"]):
    with contextlib.suppress(SystemExit):
        main(arguments)
"""


@pytest.mark.parametrize(
    "environment",
    [
        {"PYTHONIOENCODING": "latin-1"},
        {"PYTHONIOENCODING": "ascii"},
        {"LC_ALL": "de_DE.ISO-8859-1", "PYTHONUTF8": "0", "PYTHONIOENCODING": "iso-8859-1"},
        {"PYTHONIOENCODING": "latin-1", "COLUMNS": "50"},
        {"COLUMNS": "20"},
        {"NO_COLOR": "1", "COLUMNS": "50"},
    ],
)
def test_no_command_fails_for_want_of_a_character_or_of_columns(environment):
    command = [sys.executable, "-c", EVERYTHING]
    done = subprocess.run(command, env=os.environ | environment, capture_output=True, check=False, timeout=300)
    assert done.returncode == 0
    assert b"Traceback" not in done.stderr
    assert b"rotary_gallop" in done.stdout or b"rota" in done.stdout
    if "NO_COLOR" in environment:
        assert b"\x1b[" not in done.stdout


@given(st.text())
def test_any_text_can_be_written_in_ascii(text):
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="ascii")
    use_plain_characters(stream)
    encodable = text.encode("utf-8", "replace").decode("utf-8")  # without lone surrogates
    stream.write(encodable)
    stream.flush()
    assert raw.getvalue().decode("ascii") == plain(encodable).replace("\n", os.linesep) or not encodable.isascii()


def test_what_an_encoding_has_stays_as_it_is():
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="latin-1")
    use_plain_characters(stream)
    stream.write("ä × 5° β ≥ 1")
    stream.flush()
    assert raw.getvalue().decode("latin-1") == "ä × 5° beta >= 1"
