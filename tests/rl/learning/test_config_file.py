"""The settings of a run as YAML: nothing lost, nothing taken that is not a setting."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from rl.learning import config_file
from rl.learning.config import PPOConfig, TrainConfig
from rl.learning.presets import PRESETS, preset
from rl.task.settings import CommandConfig
from symdyn.errors import FileProblem
from symdyn.io.settings_data import differences, plain, rebuild


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "config.yaml"


def edit(path: Path, change: Callable[[Any], object]) -> None:
    """Change a good file in place."""
    config_file.save(preset("cpu"), path)
    data = yaml.safe_load(path.read_text())
    change(data)
    path.write_text(yaml.safe_dump(data))


def assert_refused(path: Path, *words: str) -> None:
    """One sentence or two that name the file and the problem."""
    with pytest.raises(FileProblem) as caught:
        config_file.load(path)
    text = str(caught.value)
    assert text.startswith(f"{path}: ")
    assert text.endswith(".")
    assert "\n" not in text
    for word in words:
        assert word in text


class TestRoundTrip:
    @pytest.mark.parametrize("name", PRESETS)
    def test_presets(self, path: Path, name: str) -> None:
        config_file.save(preset(name), path)
        found = config_file.load(path)
        assert found == preset(name)
        assert repr(found) == repr(preset(name))  # == takes 1 for 1.0

    def test_awkward_values(self, path: Path) -> None:
        base = preset("cpu")
        commands = replace(base.env.commands, gaits=("pace",), velocity_x=(-1e-17, 0.1 + 0.2), gait_again_s=None)
        config = replace(
            base,
            timing=Path("out/my curves: 1 # no comment.json"),
            seed=2**63,
            env=replace(base.env, commands=commands, episode_s=1e22),
            ppo=replace(base.ppo, hidden=(64,), learning_rate=1e-5, mixed_precision="on"),
        )
        config_file.save(config, path)
        found = config_file.load(path)
        assert found == config
        assert repr(found) == repr(config)
        assert isinstance(found.timing, Path)

    def test_plain_and_rebuild(self) -> None:
        config = preset("smoke")
        assert rebuild(TrainConfig, plain(config), "here") == config

    def test_whole_numbers_do_for_numbers(self, path: Path) -> None:
        edit(path, lambda d: d["env"].update(episode_s=30))
        found = config_file.load(path).env.episode_s
        assert found == 30.0
        assert isinstance(found, float)

    def test_whole_numbers_given_for_numbers_in_code(self, path: Path) -> None:
        config = replace(preset("cpu"), ppo=PPOConfig(max_grad_norm=2))
        config_file.save(config, path)
        assert config_file.load(path) == config


class TestRefused:
    def test_missing_file(self, path: Path) -> None:
        assert_refused(path, "cannot be read")

    @pytest.mark.parametrize("text", ["a: [", "\t", "a: !!python/object/apply:os.getcwd []", "--- 1\n--- 2\n"])
    def test_no_yaml(self, path: Path, text: str) -> None:
        path.write_text(text)
        assert_refused(path, "is not valid YAML")

    def test_not_utf8(self, path: Path) -> None:
        path.write_bytes(b"preset: \xff\xfe")
        assert_refused(path, "is not valid YAML")

    @pytest.mark.parametrize("text", ["", "- 1", "hello", "3"])
    def test_no_table(self, path: Path, text: str) -> None:
        path.write_text(text)
        assert_refused(path, "the file is", "a table of settings")

    def test_unknown_keys(self, path: Path) -> None:
        edit(path, lambda d: d["ppo"].update(learning_rat=1.0))
        assert_refused(path, "ppo.learning_rat", "learning_rate")
        edit(path, lambda d: d.update({1: 2}))
        assert_refused(path, "unknown settings: 1", "iterations")

    @pytest.mark.parametrize(
        ("change", "words"),
        [
            (lambda d: d.update(env=None), ("env is None", "a table")),
            (lambda d: d.update(iterations=1.0), ("iterations is 1.0", "a whole number")),
            (lambda d: d.update(iterations=True), ("iterations is True", "a whole number")),
            (lambda d: d.update(preset="gpu"), ("preset is 'gpu'", "'cpu', 'paper', 'smoke'")),
            (lambda d: d["stages"][1].update(ramp=1e9), ("stages[1]", "ramp")),
            (lambda d: d["stages"][1]["settings"].update({"env.no_such": 1}), ("stages", "env.no_such")),
            (lambda d: d["stages"][0].update(settings=[]), ("stages[0].settings is []", "a table")),
            (lambda d: d.update(timing=3), ("timing is 3", "a path")),
            (lambda d: d.update(timing=""), ("timing is ''", "a path")),
            (lambda d: d["ppo"].update(equivariant="yes"), ("ppo.equivariant is 'yes'", "true or false")),
            (lambda d: d["ppo"].update(mixed_precision=True), ("ppo.mixed_precision is True", "'on'")),
            (lambda d: d["ppo"].update(learning_rate="1e-3"), ("ppo.learning_rate is '1e-3'", "1.0e-3")),
            (lambda d: d["ppo"].update(learning_rate=math.nan), ("ppo.learning_rate is nan", "finite")),
            (lambda d: d["ppo"].update(learning_rate=10**400), ("ppo.learning_rate is", "finite")),
            (lambda d: d["ppo"].update(learning_rate=True), ("ppo.learning_rate is True", "a finite number")),
            (lambda d: d["ppo"].update(hidden=64), ("ppo.hidden is 64", "a list, each a whole number")),
            (lambda d: d["ppo"].update(hidden=[64, "a"]), ("ppo.hidden[1] is 'a'", "a whole number")),
            (lambda d: d["env"]["commands"].update(velocity_x=[1.0]), ("env.commands.velocity_x", "a list of 2")),
            (
                lambda d: d["env"]["commands"].update(velocity_x=None),
                ("velocity_x is None", "a list of 2"),
            ),
            (lambda d: d["env"]["commands"].update(velocity_again_s=3), ("env.commands.velocity_again_s", "list of 2")),
            (
                lambda d: d["env"]["commands"].update(gaits=["trott"]),
                ("env.commands", "Unknown gait 'trott'"),
            ),
            (lambda d: d["ppo"].update(discount=2.0), ("in ppo", "discount is 2.0", "[0, 1]")),
            (lambda d: d.update(num_envs=0), ("in the file", "num_envs is 0", "> 0")),
        ],
    )
    def test_wrong_values(self, path: Path, change: Callable[[Any], object], words: tuple[str, ...]) -> None:
        edit(path, change)
        assert_refused(path, *words)

    def test_what_could_not_be_read_back_is_not_written(self, path: Path) -> None:
        config = preset("cpu")
        object.__setattr__(config.env, "episode_s", math.inf)  # past the check that a new one would meet
        with pytest.raises(FileProblem, match=r"env\.episode_s is inf"):
            config_file.save(config, path)
        assert list(path.parent.iterdir()) == []

    def test_unwritable(self, tmp_path: Path) -> None:
        (tmp_path / "file").touch()
        with pytest.raises(FileProblem, match="cannot be written"):
            config_file.save(preset("cpu"), tmp_path / "file" / "config.yaml")


class TestDifferences:
    def test_none(self) -> None:
        assert differences(preset("cpu"), preset("cpu")) == []

    def test_names_are_dotted_and_in_order(self) -> None:
        base = TrainConfig()
        other = replace(
            base,
            seed=3,
            timing=Path("curves.json"),
            env=replace(base.env, commands=CommandConfig(gaits=("trot",), velocity_again_s=(1.0, 2.0))),
            ppo=replace(base.ppo, hidden=(64,)),
        )
        wanted = ["seed", "timing", "env.commands.gaits", "env.commands.velocity_again_s", "ppo.hidden"]
        assert differences(base, other) == wanted
        assert differences(other, base) == wanted
