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
import tomllib
from collections.abc import Callable
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
    from rl.learning.presets import preset

    training = text_of(site / "reference" / "settings.html")
    known = [flag for flag in flags(preset("paper")) if flag != "--stages"]
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


def test_the_picture_of_the_packages_has_the_layers_that_import_linter_checks():
    tools = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
    contracts = tools["importlinter"]["contracts"]
    layers = {contract["containers"][0]: contract["layers"] for contract in contracts if "containers" in contract}
    wanted = [
        name
        for package in ("slip", "rl", "hardware", "symdyn")
        for layer in layers[package]
        for name in layer.split(" | ")
        if name != "__main__"
    ]
    picture = (DOCS / "images/packages.svg").read_text(encoding="utf-8")
    assert re.findall(r'<text class="folder"[^>]*>(\w+)<', picture) == wanted


# the examples run


def page_blocks(page: str) -> list[tuple[str, str, str]]:
    """Language, title or class, and text of every code block of a page, from top to bottom."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(r"^```(\w+) ?([^\n]*)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def follow(page: str, folder: Path, run: Callable[[str, str], str]) -> str:
    """Do what a page says, from top to bottom: write its files, run its Python and its commands.

    Args:
        page: under docs/.
        folder: to write the files in.
        run: runs a block of the language ``python`` or ``sh`` there, and returns what it prints.

    Returns:
        All that was printed. Each block of output on the page was in what the code before it printed.
    """
    everything, said = "", ""
    for language, info, text in page_blocks(page):
        if language in ("python", "sh") and not info:
            said = run(language, text)
            everything += said
        elif language == "text":
            printed = {line.strip() for line in said.splitlines()}
            wanted = [line.strip() for line in text.splitlines() if line != "..."]
            assert [line for line in wanted if line not in printed] == [], said
        elif (title := re.fullmatch(r'title="([\w./]+)"', info)) and language in ("toml", "xml"):
            (folder / title[1]).write_text(text)
    return everything


def test_the_gait_of_the_how_to_runs_and_prints_what_the_page_says(tmp_path, capsys):
    found = blocks("howto/gait.md", "python")
    assert found
    names: dict[str, Any] = {}
    with contextlib.chdir(tmp_path):
        for code in found:
            exec(compile(code, "howto/gait.md", "exec"), names)
    said = capsys.readouterr().out
    for line in ("K=1 H=1 (('LH', 'RF'),)", "{'trot': 0.1, 'half_bound_right': 0.1, 'walk': 0.1}"):
        assert line in said
        assert line in (DOCS / "howto/gait.md").read_text(encoding="utf-8")


def test_the_robot_of_the_how_to_is_analysed_trained_and_judged_as_the_page_says(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    names: dict[str, Any] = {}

    def run(language: str, text: str) -> str:
        if language == "python":
            with contextlib.chdir(tmp_path):
                exec(compile(text, "howto/robot.md", "exec"), names)
            return capsys.readouterr().out
        said = ""
        for command in text.splitlines():
            name, *arguments = shlex.split(command)
            assert name == "symdyn"
            done = symdyn(*arguments, cwd=tmp_path)
            assert done.returncode == 0, (command, done.stderr)
            said += done.stdout
        return said

    said = follow("howto/robot.md", tmp_path, run)
    page = (DOCS / "howto/robot.md").read_text(encoding="utf-8")
    for number in ("19.08 kg", "stands at 0.353 m", "0.4570", "0.2126", "kp 35.6", "kd 0.771"):
        assert number in said
        assert number in page
    assert tomllib.loads((tmp_path / "backpack.toml").read_text())["kp"] == 35.6  # as the analysis suggests
    assert json.loads((tmp_path / "runs/backpack/robot.json").read_text())["name"] == "backpack"
    assert (tmp_path / "out/policy/report.md").is_file()


def test_sentences_of_the_robot_file_page_are_those_that_are_raised(tmp_path):
    from rl.physics.model import build_model
    from rl.pretrained import policy_path
    from symdyn.errors import SymdynError
    from symdyn.gait.timing import TimingCurve
    from symdyn.policy.file import Policy
    from symdyn.robot.descriptions import urdf_path
    from symdyn.robot.robot_file import get_robot, load_robot_file

    go2 = urdf_path(get_robot("go2"))
    urdf = go2.read_text(encoding="utf-8")
    robot = (ROOT / "symdyn/robot/robots/go2.toml").read_text(encoding="utf-8").replace('"go2"', '"backpack"')
    robot = re.sub('urdf = ".*"', 'urdf = "backpack.urdf"', robot)
    (tmp_path / "backpack.toml").write_text(robot)
    backpack = load_robot_file(tmp_path / "backpack.toml")
    shutil.copy(policy_path("go2"), tmp_path / "policy.onnx")
    TimingCurve().save(tmp_path / "curves.json", robot="go2")

    def of_robot_file(old: str, new: str) -> Callable[[], object]:
        def load() -> None:
            assert old in robot
            (tmp_path / "backpack.toml").write_text(robot.replace(old, new))
            load_robot_file(tmp_path / "backpack.toml")

        return load

    def of_urdf(pattern: str, new: str) -> Callable[[], object]:
        def build() -> None:
            changed, count = re.subn(pattern, new, urdf)
            assert count
            (tmp_path / "backpack.urdf").write_text(changed)
            build_model(backpack)

        return build

    wrong = [
        of_robot_file("kp = 30.0", ""),
        of_robot_file("kp = 30.0", "kp = 30.0\nkpp = 30.0"),
        of_robot_file("kp = 30.0", "kp = -1.0"),
        lambda: build_model(backpack),
        of_urdf("RL_hip_joint", "LH_hip_joint"),
        of_urdf('"RL_foot"', '"LH_foot"'),
        of_urdf('effort="[^"]*"', 'effort="0"'),
        of_urdf("RL_hip_rotor", "LH_hip_rotor"),
        lambda: Policy.load(tmp_path / "policy.onnx", backpack),
        lambda: TimingCurve.load(tmp_path / "curves.json", "backpack"),
    ]
    table = (DOCS / "robot-file.md").read_text(encoding="utf-8").split("## On a mismatch")[1]
    sentences = re.findall(r"\| `([^`]+)` \|$", table, re.MULTILINE)
    for cause in wrong:
        with pytest.raises(SymdynError) as raised:
            cause()
        text = str(raised.value).replace(f"{tmp_path.resolve()}/", "").replace(f"{tmp_path}/", "")
        assert [sentence for sentence in sentences if text.startswith(sentence.removesuffix("..."))], text


def test_the_robot_file_of_the_site_is_that_of_the_go2_with_every_key(site):
    from symdyn.robot.definition import JointLimit, Leg, Robot

    page = text_of(site / "robot-file.html")
    for line in (ROOT / "symdyn/robot/robots/go2.toml").read_text(encoding="utf-8").splitlines():
        assert line in page
    for key in (field.name for kind in (Robot, Leg, JointLimit) for field in fields(kind)):
        assert re.search(rf"^{key}\n(?:number|text|table|list)", page, re.MULTILINE), key
    assert re.search(r"^kd\nnumber\nN m s/rad\nyes\nderivative gain", page, re.MULTILINE)
    assert re.search(r"^stance\nlist of 3 numbers\nrad\nyes\n", page, re.MULTILINE)
    assert re.search(r"^velocity\nnumber\nrad/s\nno\n", page, re.MULTILINE)


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


PARSE = """
import importlib, shlex, sys
from symdyn_cli.commands import GROUPS
commands = {name: command for group in GROUPS.values() for name, command in group.items()}
for line in sys.argv[1:]:
    _, name, *words = shlex.split(line)
    importlib.import_module(commands[name].arguments).parse(words)
"""
"""A program that parses command lines, without running them."""

TINY = ("--preset", "smoke", "--num-envs", "8", "--ppo.hidden", "32", "16", "--iterations", "1")


def test_a_gait_added_as_the_how_to_says_can_be_trained(changed_copy):
    copy = changed_copy("howto/gait.md")
    (gait,) = json.loads(python("-m", "symdyn", "gaits", "canter", "--json", cwd=copy))
    assert gait["symmetric_pairs"] == [["LH", "RF"]]
    python("-m", "symdyn", "train", *TINY, "--env.commands.gaits", "trot", "canter", "--out", "run", cwd=copy)
    assert "- canter" in (copy / "run" / "config.yaml").read_text()


def test_a_reward_term_added_as_the_how_to_says_is_logged_and_summed(changed_copy):
    copy = changed_copy("howto/reward.md")
    weights = ("--env.rewards.power", "0.2", "--env.rewards.softness", "0")
    python("-m", "symdyn", "train", *TINY, *weights, "--out", "run", cwd=copy)
    record = json.loads((copy / "run" / "progress.jsonl").read_text())
    assert -0.2 <= record["reward/power"] < 0.0
    # the commands of the page, with the term in place, are understood
    shown = "\n".join(blocks("howto/reward.md", "sh"))
    lines = [line for line in shown.splitlines() if line.startswith("symdyn")]
    assert len(lines) > 6
    python("-c", PARSE, *lines, cwd=copy)
    page = (DOCS / "howto/reward.md").read_text(encoding="utf-8")
    test = re.search(r'title="tests/rl/task/test_rewards.py"\n(.*?)```', page, re.DOTALL)[1]
    head = "import math\nimport pytest\nimport torch\nfrom rl.task import rewards\n\nonly = torch.Tensor.item\n\n"
    (copy / "test_power.py").write_text(head + test)
    assert "1 passed" in python("-m", "pytest", "-q", "-p", "no:cacheprovider", "test_power.py", cwd=copy)


def test_an_observation_term_added_as_the_how_to_says_is_trained_with_and_exported(changed_copy):
    copy = changed_copy("howto/observation.md")

    def run(language: str, text: str) -> str:
        if language == "python":
            return python("-c", text, cwd=copy)
        commands = [shlex.split(command)[1:] for command in text.splitlines()]
        # in one interpreter: another one would import torch anew
        return python("-c", f"from symdyn_cli.main import main\nassert not any(map(main, {commands}))", cwd=copy)

    follow("howto/observation.md", copy, run)
    head = "import numpy as np\nfrom symdyn.policy.observation import VALUES, Sensed, Situation\n\n"
    (test,) = [text for _, info, text in page_blocks("howto/observation.md") if "test_observation.py" in info]
    (copy / "test_stance.py").write_text(head + test)
    assert "1 passed" in python("-m", "pytest", "-q", "-p", "no:cacheprovider", "test_stance.py", cwd=copy)


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
