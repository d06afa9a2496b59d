"""curves.json: the trainer reads it, and none of its curves can pass for another."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rl.learning import run_dir
from slip.curves.file import FittedCurve, document, write
from slip.curves.fit import TimingPoints, fit_curves
from symdyn.errors import InvalidValue
from symdyn.gait.timing import TimingCurve
from symdyn.io.files import read_json
from tests.robots import GO2


def fitted(a_T: float, groups: tuple[str, str], summary: str, **more: Any) -> FittedCurve:
    v = np.tile(np.linspace(0.0, 1.0, 8), 2)
    spread = np.random.default_rng(0).uniform(-0.1, 0.1, 16) * v
    group = tuple(np.repeat(groups, 8).tolist())
    points = TimingPoints(group, v, a_T * (1.0 + spread) * np.exp(-0.1 * v), 0.4 * np.exp(-0.2 * v), np.ones(16))
    return FittedCurve(fit_curves(points), {"robot": "go2", "orbits": 16}, summary, **more)


PASSIVE = fitted(1.6, ("PK", "BG"), "16 orbits of PK, BG")
CALIBRATED = fitted(2.4, ("trot", "bound"), "16 of 560 trials of policy.onnx")


def saved(folder: Path, **content: Any) -> Path:
    path = folder / "curves.json"
    write(path, document(**content))
    return path


def test_without_trials_the_trainer_gets_the_papers_constants_and_the_file_says_so(tmp_path: Path) -> None:
    path = saved(tmp_path, passive=PASSIVE)
    assert TimingCurve.load(path) == TimingCurve()
    data = read_json(path)
    assert data["active"] == "paper"
    assert set(data["curves"]) == {"passive", "paper"}
    assert "'paper'" in data["note"] and "not derived from the SLIP" in data["note"]
    assert "No trials were given" in data["note"]


def test_with_trials_the_calibrated_curve_is_active(tmp_path: Path) -> None:
    path = saved(tmp_path, passive=PASSIVE, calibrated=CALIBRATED)
    assert TimingCurve.load(path) == CALIBRATED.timing("calibrated")
    assert TimingCurve.load(path).a_T == pytest.approx(2.4, rel=0.05)
    assert "No trials" not in read_json(path)["note"]


@pytest.mark.parametrize(("active", "a_T"), [("passive", 1.6), ("paper", 2.55), ("calibrated", 2.4)])
def test_another_may_be_asked_for(tmp_path: Path, active: Any, a_T: float) -> None:
    path = saved(tmp_path, passive=PASSIVE, calibrated=CALIBRATED, active=active)
    curve = TimingCurve.load(path)
    assert curve.a_T == pytest.approx(a_T, rel=0.05)
    assert f"'{active}' as asked for" in read_json(path)["note"]
    with pytest.raises(InvalidValue, match="The active curve is 'calibrated', but must be passive or paper"):
        document(PASSIVE, active="calibrated")


def test_the_source_that_travels_with_the_constants_says_which_they_are(tmp_path: Path) -> None:
    curves = read_json(saved(tmp_path, passive=PASSIVE, calibrated=CALIBRATED))["curves"]
    assert curves["passive"]["source"].startswith("passive: fitted to passive orbits")
    assert "no trial" in curves["passive"]["source"] and "PK, BG" in curves["passive"]["source"]
    assert curves["calibrated"]["source"].startswith("calibrated: fitted to trials")
    assert "not derived from the SLIP" in curves["calibrated"]["source"]
    assert curves["paper"]["source"] == TimingCurve().source
    assert len({json.dumps(curve["fit"]) for curve in curves.values()}) == 3


def test_a_caveat_travels_too(tmp_path: Path) -> None:
    caveat = "k and ks were chosen for its intercepts"
    path = saved(tmp_path, passive=replace(PASSIVE, caveat=caveat), active="passive")
    assert caveat in TimingCurve.load(path).source


def test_each_fit_has_its_own_data_and_goodness(tmp_path: Path) -> None:
    data = read_json(saved(tmp_path, passive=PASSIVE, calibrated=CALIBRATED))
    for name, groups in (("passive", {"PK": 8, "BG": 8}), ("calibrated", {"trot": 8, "bound": 8})):
        found = data["curves"][name]
        assert found["fit"]["groups"] == groups
        assert found["fit"]["T"]["a"]["low"] < found["a_T"] < found["fit"]["T"]["a"]["high"]
        assert 0.0 < found["fit"]["T"]["r_squared"] <= 1.0
        assert found["data"]["robot"] == "go2"
    assert data["curves"]["paper"]["fit"] is None
    assert set(data["made"]) == {"date", "commit"}


def test_a_training_run_takes_the_active_curve_and_keeps_a_copy(tmp_path: Path) -> None:
    path = saved(tmp_path, passive=PASSIVE, calibrated=CALIBRATED)
    curve = run_dir.timing(tmp_path / "run", path, GO2)
    assert curve == CALIBRATED.timing("calibrated")
    run_dir.begin(tmp_path / "run", GO2, curve, {"commit": "unknown"})
    path.unlink()
    assert run_dir.timing(tmp_path / "run", path, GO2) == curve


def test_absurd_constants_are_not_written(tmp_path: Path) -> None:
    with pytest.raises(InvalidValue, match="a_T"):
        saved(tmp_path, passive=fitted(50.0, ("PK", "BG"), "absurd"))
    assert list(tmp_path.iterdir()) == []
