"""The documentation site builds without a warning and without the internet, is complete, and its examples run."""

from __future__ import annotations

import contextlib
import html
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import pytest

from symdyn_cli.commands import GROUPS
from tests.e2e.command_in_process import symdyn

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    """The site as ``make docs`` builds it."""
    pytest.importorskip("mkdocs")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)]
    built = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=600, check=False)
    assert built.returncode == 0, built.stderr
    return folder


def text_of(page: Path) -> str:
    """What stands on a page, without tags."""
    return html.unescape(re.sub(r"<[^>]+>", "", page.read_text(encoding="utf-8")))


def blocks(page: str, language: str) -> list[str]:
    """The code blocks of a page in a language, those with a title or a class of their own left out."""
    return re.findall(
        rf"^```{language}\n(.*?)^```$", (DOCS / page).read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )


def test_nothing_on_any_page_is_fetched_from_another_host(site):
    fetched = re.compile(r"<(?:script|link|img|iframe|source)\b[^>]*\b(?:src|href)=\"(?:https?:)?//[^\"]*\"")
    pages = list(site.rglob("*.html"))
    assert len(pages) > 100
    assert {page.name: found for page in pages if (found := fetched.findall(page.read_text(encoding="utf-8")))} == {}
    for style in site.rglob("*.css"):
        assert not re.search(r"(?:@import|url\()\s*[\"']?https?:", style.read_text(encoding="utf-8")), style


def test_every_command_has_a_page_with_its_help(site):
    for commands in GROUPS.values():
        for name in commands:
            assert f"usage: symdyn {name}" in text_of(site / "reference" / "commands" / f"{name}.html")


def flags(config: Any, path: tuple[str, ...] = ()) -> list[str]:
    """Every flag of a nested configuration."""
    found = []
    for field in fields(config):
        value, place = getattr(config, field.name), (*path, field.name)
        found += flags(value, place) if is_dataclass(value) else [f"--{'.'.join(place).replace('_', '-')}"]
    return found


def test_every_setting_has_a_row_with_default_and_meaning(site):
    from hardware.control.settings import Settings
    from rl.learning.config import preset

    training = text_of(site / "reference" / "settings.html")
    known = [flag for flag in flags(preset("paper")) if not flag.startswith("--env.curriculum.final.")]
    assert [flag for flag in known if f"{flag}\n" not in training] == []
    deployer = text_of(site / "reference" / "deployer.html")
    assert [flag for flag in flags(Settings()) if f"{flag}\n" not in deployer] == []
    # one row in full, the values those of the paper and of docs/method.md
    assert re.search(r"--env\.rewards\.temporal\s+0\.15\s+cpu, smoke: 0\.25", training)


def test_equations_are_drawn_by_the_browser_alone(site):
    for name in ("gait", "timing", "symmetry", "slip"):
        source = (DOCS / "theory" / f"{name}.md").read_text(encoding="utf-8")
        page = (site / "theory" / f"{name}.html").read_text(encoding="utf-8")
        assert page.count('display="block"') == source.count("$$") // 2 > 0
        assert page.count('display="inline"') == source.replace("$$", "").count("$") // 2 > 0
        assert "arithmatex" not in page
        assert "$$" not in page


def test_gait_page_has_the_papers_table(site):
    # Table I of the paper, by hand
    page = text_of(site / "theory" / "gait.html")
    assert re.search(r"half_bound_left\s+0\.00\s+0\.63\s+0\.37\s+0\.00", page)
    assert re.search(r"transverse_gallop\s+0\.13\s+0\.63\s+0\.37\s+0\.87", page)


def test_every_notebook_is_a_page_with_its_pictures(site):
    for notebook in (ROOT / "notebooks").glob("*.ipynb"):
        page = (site / "notebooks" / f"{notebook.stem}.html").read_text(encoding="utf-8")
        pictures = re.findall(rf"src=\"({notebook.stem}-\d+\.\w+)\"", page)
        assert len(pictures) >= 4
        assert all((site / "notebooks" / picture).stat().st_size > 1000 for picture in pictures)


# the examples run


@pytest.mark.parametrize(
    ("page", "lines"),
    [
        ("howto/gait.md", ["K=1 H=1 (('LH', 'RF'),)", "{'trot': 0.1, 'half_bound_right': 0.1, 'walk': 0.1}"]),
        ("howto/robot.md", ["19.08 kg", "stands at 0.353 m"]),
    ],
)
def test_python_of_a_how_to_runs_and_prints_what_the_page_says(page, lines, tmp_path, capsys):
    found = blocks(page, "python")
    assert found
    names: dict[str, Any] = {}
    with contextlib.chdir(tmp_path):
        for code in found:
            exec(compile(code, page, "exec"), names)
    said = capsys.readouterr().out
    for line in lines:
        assert line in said
        assert line in (DOCS / page).read_text(encoding="utf-8")


def test_the_robot_of_the_how_to_can_be_analysed(tmp_path):
    page = (DOCS / "howto/robot.md").read_text(encoding="utf-8")
    (make, *_), (command,) = blocks("howto/robot.md", "python"), blocks("howto/robot.md", "sh")
    with contextlib.chdir(tmp_path):
        exec(compile(make, "howto/robot.md", "exec"), {})
    (tmp_path / "backpack.srdf").write_text(re.search(r'title="backpack.srdf"\n(.*?)```', page, re.DOTALL)[1])
    done = symdyn(*shlex.split(command)[1:], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    for number in ("0.4570", "0.2126", "35.6", "0.771"):  # as the page has them
        assert number in done.stdout
        assert number in page


@pytest.fixture
def changed_copy(tmp_path):
    """A function that takes a page and returns a copy of the packages with the page's diffs applied."""

    def make(page: str) -> Path:
        for package in ("symdyn", "slip", "rl", "hardware", "symdyn_cli"):
            shutil.copytree(ROOT / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__"))
        for number, diff in enumerate(blocks(page, "diff")):
            (tmp_path / f"{number}.diff").write_text(diff)
            command = ["git", "apply", f"{number}.diff"]
            applied = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
            assert applied.returncode == 0, applied.stderr
        return tmp_path

    return make


def python(*arguments: object, cwd: Path) -> str:
    """Python in a directory whose packages come before the installed ones."""
    environment = os.environ | {"PYTHONPATH": str(cwd)}
    command = [sys.executable, *map(str, arguments)]
    done = subprocess.run(command, cwd=cwd, env=environment, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


TINY = ("--preset", "smoke", "--num-envs", "8", "--ppo.hidden", "32", "16", "--iterations", "1")


def test_a_gait_added_as_the_how_to_says_can_be_trained(changed_copy):
    copy = changed_copy("howto/gait.md")
    (gait,) = json.loads(python("-m", "symdyn", "gaits", "canter", "--json", cwd=copy))
    assert gait["symmetric_pairs"] == [["LH", "RF"]]
    python("-m", "symdyn", "train", *TINY, "--env.commands.gaits", "trot", "canter", "--out", "run", cwd=copy)
    assert "- canter" in (copy / "run" / "config.yaml").read_text()


def test_a_reward_term_added_as_the_how_to_says_is_logged_and_summed(changed_copy):
    copy = changed_copy("howto/reward.md")
    weights = ("--env.rewards.power", "0.2", "--env.curriculum.final.power", "0.2", "--env.rewards.softness", "0")
    python("-m", "symdyn", "train", *TINY, *weights, "--out", "run", cwd=copy)
    record = json.loads((copy / "run" / "progress.jsonl").read_text())
    assert -0.2 <= record["reward/power"] < 0.0
    page = (DOCS / "howto/reward.md").read_text(encoding="utf-8")
    test = re.search(r'title="tests/rl/task/test_rewards.py"\n(.*?)```', page, re.DOTALL)[1]
    head = "import math\nimport pytest\nimport torch\nfrom rl.task import rewards\n\nonly = torch.Tensor.item\n\n"
    (copy / "test_power.py").write_text(head + test)
    assert "1 passed" in python("-m", "pytest", "-q", "-p", "no:cacheprovider", "test_power.py", cwd=copy)


def test_the_tour_runs_as_it_stands(tmp_path):
    commands = [line for block in blocks("tour.md", "sh") for line in block.splitlines() if line.startswith("symdyn")]
    assert len(commands) >= 8
    for command in commands:
        done = symdyn(*shlex.split(command)[1:], cwd=tmp_path)
        assert done.returncode == 0, (command, done.stderr)
    # every file that the page tells of is there
    text = (DOCS / "tour.md").read_text(encoding="utf-8").replace("/NAME/", "/gaits/")
    promised = set(re.findall(r"`(out/[\w./-]+)`", text))
    assert len(promised) >= 4
    assert [path for path in promised if not (tmp_path / path).exists()] == []
