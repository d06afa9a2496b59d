"""Settings files of symdyn train, and flags that a stage would overrule."""

from __future__ import annotations

from pathlib import Path

import pytest

from rl.cli.arguments.train import parse
from rl.learning import config_file
from rl.learning.presets import preset
from symdyn.errors import FileProblem, InvalidValue


def test_a_settings_file_takes_the_place_of_a_preset(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    config_file.save(preset("smoke"), path)
    path.write_text(path.read_text().replace("env.rewards.temporal: 0.45", "env.rewards.temporal: 0.55"))
    args = parse(["--settings", str(path), "--seed", "7"])
    assert args.config.seed == 7
    assert args.config.in_stage(1).env.rewards.temporal == 0.55
    with pytest.raises(InvalidValue, match="left out with --settings"):
        parse(["--settings", str(path), "--preset", "cpu"])
    with pytest.raises(FileProblem, match=r"none\.yaml"):
        parse(["--settings", str(tmp_path / "none.yaml")])


def test_a_flag_that_a_stage_overrules_is_refused_and_others_are_not() -> None:
    with pytest.raises(InvalidValue, match=r"env\.rewards\.temporal.*stage 'keep time'"):
        parse(["--preset", "smoke", "--env.rewards.temporal", "0.3"])
    assert parse(["--preset", "smoke", "--env.rewards.hip-rate", "0.3"]).config.env.rewards.hip_rate == 0.3


def test_a_settings_file_whose_stages_cannot_end_is_refused_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    config_file.save(preset("smoke"), path)
    path.write_text(path.read_text().replace("samples: 128.0", "samples: null"))
    with pytest.raises(FileProblem, match=r"mine\.yaml.*only the last stage may last until the run ends"):
        parse(["--settings", str(path)])
