"""README: its commands parse, as those of the docs do; its Python runs, its BibTeX is that of the bibliography."""

from __future__ import annotations

import importlib
import json
import re
import shlex
from pathlib import Path

import pytest

from symdyn.errors import SymdynError
from symdyn_cli.commands import GROUPS

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")
COMMANDS = {name: command for group in GROUPS.values() for name, command in group.items()}


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)


def command_lines() -> list[str]:
    """Lines that call symdyn, without comment and without the sign for the background."""
    lines = [line.split("   #")[0].split(" # ")[0] for block in blocks("sh") for line in block.splitlines()]
    return [line.strip().removesuffix("&").strip() for line in lines if "bin/symdyn " in line]


def lines_of_docs() -> list[str]:
    """Commands in the pages, but for those that need the page's own changes (tests/project/test_docs.py)."""
    found: list[str] = []
    # docs/results.md tells what was run when, by the settings of that time
    for page in sorted(path for path in (ROOT / "docs").rglob("*.md") if path.name != "results.md"):
        for block in re.findall(
            r"^ *```sh[^\n]*\n(.*?)^ *```$", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
        ):
            for line in block.replace("\\\n", " ").splitlines():
                command = line.split(" #")[0].strip().removesuffix("&").strip().removeprefix(".venv/bin/")
                if command.startswith("symdyn ") and "|" not in command and ">" not in command:
                    found.append(command)
    mine = ("--env.rewards.power", "--env.observation stance", "canter", "backpack")
    return [line for line in dict.fromkeys(found) if not any(word in line for word in mine)]


@pytest.mark.parametrize("line", [*command_lines(), *lines_of_docs()])
def test_a_command_line_is_understood(line, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    _, name, *arguments = shlex.split(line)
    try:
        importlib.import_module(COMMANDS[name].arguments).parse(arguments)
    except SymdynError as error:  # of a run that the reader has made and this test has not
        assert re.search(r"(runs|out)/\w+", str(error))


def test_every_command_has_a_line_and_every_group_a_heading():
    shown = {shlex.split(line)[1] for line in command_lines()}
    assert set(COMMANDS) - shown == {"completion"}
    assert "symdyn completion bash" in README
    for group in GROUPS:
        assert group in README or group == "Type less"


def test_the_python_runs(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    (code,) = blocks("python")
    exec(compile(code, "README.md", "exec"), {})
    said = capsys.readouterr()
    assert said.out.startswith("K=1 H=<g_r>")
    assert said.err == ""  # nothing is searched: what the snippet needs comes with symdyn


def test_the_bibtex_is_that_of_the_bibliography():
    (entry,) = blocks("bibtex")
    assert entry.splitlines()[:-2] == _paper().splitlines()[: len(entry.splitlines()) - 2]


def _paper() -> str:
    text = (ROOT / "docs" / "references.bib").read_text(encoding="utf-8")
    return text[text.index("@misc{ding2025towards") :]


def test_the_headline_numbers_are_those_of_the_result_files():
    here = {}
    for name in ("gaits", "velocity", "robustness", "transitions"):
        result = json.loads((ROOT / "docs" / "results" / f"{name}.json").read_text(encoding="utf-8"))
        here[name] = {target["what"]: target["here"] for target in result["targets"]}
    first = README.split("## Two commands")[0]
    for number in (
        f"{100.0 * here['gaits']['strides in the commanded gait, mean']:.1f}% on average",
        f"{100.0 * here['gaits']['the same, worst gait and speed']:.1f}% for the worst",
        f"{here['velocity']['steady-state speed error, mean, m/s']:.3f} m/s on average",
        f"{here['velocity']['the same, worst gait and step, m/s']:.3f} m/s in the worst case",
        f"| {here['robustness']['falls in 100 random sequences']:.0f} on the nominal robot",
        f"only {here['robustness']['latency 20 ms: share of robots that did not fall']:.0%} of the robots",
        f"is {here['gaits']['GC stance of the sequence']:.3f} (goal",
        f"{here['transitions']['share of switches within one stride']:.0%} of the gait",
    ):
        assert number in first


def test_the_first_screen_says_what_for_and_what_is_missed():
    first = README.split("## Two commands")[0]
    assert first.count("\n") < 25
    for word in ("Not reached", "docs/results.md", "go2.gif", "goal"):
        assert word in first
