"""``symdyn fit-curves`` and ``symdyn study`` as a user runs them: files, training with them, kills, bad input."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from symdyn.analysis import trials
from symdyn.analysis.trials import Trial
from symdyn.gait.timing import TimingCurve
from tests.e2e.command_in_process import symdyn

QUICK = ("--reference", "--speeds", "0", "0.3", "--no-trot", "--no-carry")
"""The literature's pronk, only as far as it takes to fit: seconds."""


@pytest.fixture(autouse=True)
def own_cache(slip_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYMDYN_CACHE", str(slip_cache))


def table(path: Path, a_T: float = 2.2, **change: object) -> Path:
    """Trials whose cheapest timings lie on a curve with this a_T, and else the paper's."""
    rows = []
    for v in (-1.5, -1.0, -0.5, 0.5, 1.0, 1.5):
        T, beta = float(TimingCurve().period(np.array([v]), 0.4)[0]), float(TimingCurve().duty(np.array([v]), 0.4)[0])
        for factor in (0.8, 0.9, 1.0, 1.1):
            period = T * a_T / 2.55 * factor
            row = Trial(v, period, beta, 0.5 + abs(factor - 1.0), 0.05, 1.0, gait="trot", leg_length=0.4)
            rows.append(row.as_dict() | change)
    path.write_text(trials.as_csv(rows))
    return path


def test_without_trials_the_file_has_two_curves_and_training_takes_the_papers(tmp_path: Path) -> None:
    done = symdyn("fit-curves", *QUICK, "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    said = " ".join(done.stdout.split())
    assert "The active curve is 'paper'" in said and "No trials were given" in said
    data = json.loads((tmp_path / "out" / "curves.json").read_text())
    assert set(data["curves"]) == {"passive", "paper"}
    assert data["curves"]["passive"]["a_T"] == pytest.approx(1.57, abs=0.01)
    assert data["curves"]["passive"]["data"]["families"] == ["PK"]
    assert TimingCurve.load(tmp_path / "out" / "curves.json") == TimingCurve()
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["curves.json", "curves.md", "curves.png"]
    assert (tmp_path / "out" / "curves.png").read_bytes().startswith(b"\x89PNG")
    assert "| a_T | 1.56" in (tmp_path / "out" / "curves.md").read_text()


def test_with_trials_training_runs_with_the_calibrated_curve(tmp_path: Path) -> None:
    table(tmp_path / "trials.csv")
    flags = ("--trials", "trials.csv", "--bootstrap", "20", "--out", "out")
    done = symdyn("fit-curves", *QUICK, *flags, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "1 gaits are too few for a bootstrap: the intervals come from" in " ".join(done.stdout.split())
    data = json.loads((tmp_path / "out" / "curves.json").read_text())
    assert data["active"] == "calibrated"
    assert data["curves"]["calibrated"]["a_T"] == pytest.approx(2.2, rel=1e-6)
    assert data["curves"]["calibrated"]["data"]["trials"] == 24
    assert data["curves"]["passive"]["a_T"] == pytest.approx(1.57, abs=0.01), "trials change nothing in the passive fit"
    flags = ("--preset", "smoke", "--num-envs", "4", "--iterations", "1", "--ppo.hidden", "16", "16")
    done = symdyn("train", *flags, "--timing", "out/curves.json", "--out", "run", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    kept = TimingCurve.load(tmp_path / "run" / "timing.json")
    assert kept == TimingCurve.load(tmp_path / "out" / "curves.json")
    assert kept.source.startswith("calibrated: fitted to trials")


def test_identified_springs_are_said_to_be_chosen(tmp_path: Path) -> None:
    target = ("--target.period-star", "1.5645", "--target.duty", "0.3813")  # the literature's springs do this
    flags = ("--identify", *target, "--active", "passive", "--out", "out")
    done = symdyn("fit-curves", *QUICK, *flags, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    curve = TimingCurve.load(tmp_path / "out" / "curves.json")
    assert curve.a_T == pytest.approx(1.5645, abs=0.01)
    assert curve.c_T < 0.1, "the decay is the model's, not the paper's"
    data = json.loads((tmp_path / "out" / "curves.json").read_text())["curves"]["passive"]["data"]
    assert data["identified"] == {"period_star": 1.5645, "duty": 0.3813}
    assert data["slip_parameters"]["stiffness"] == pytest.approx(10.0, rel=0.01)
    assert "k and ks were chosen" in curve.source and curve.source.startswith("passive:")


def test_a_robot_is_measured(tmp_path: Path) -> None:
    done = symdyn(
        "fit-curves",
        "--robot",
        "solo12",
        "--speeds",
        "0",
        "0.3",
        "--no-trot",
        "--no-carry",
        "--out",
        "out",
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    data = json.loads((tmp_path / "out" / "curves.json").read_text())["curves"]["passive"]["data"]
    assert data["robot"] == "solo12"
    assert 0.1 < data["leg_length"] < 0.4


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--robot", "go22"), ("Unknown robot 'go22'", "Did you mean 'go2'")),
        (("--urdf", "nowhere.urdf"), ("nowhere.urdf",)),
        (("--reference", "--robot", "go2"), ("--reference", "left out")),
        (("--k", "-1"), ("stiffness is -1.0", "> 0")),
        (("--k", "nan"), ("stiffness is nan",)),
        (("--families", "PX"), ("Unknown family 'PX'",)),
        (("--speeds", "1", "0.5"), ("speeds", "the smaller first")),
        (("--speeds", "5"), ("speeds",)),
        (("--weights", "heavy"), ("heavy",)),
        (("--identify", "--k", "5"), ("--identify", "--k or --ks")),
        (("--identify", "--target.duty", "1.5"), ("duty", "(0, 1)")),
        (("--active", "calibrated"), ("--active", "no --trials")),
        (("--bootstrap", "-1"), ("--bootstrap",)),
        (("--trials", "nowhere.csv"), ("nowhere.csv", "No such file")),
        (("--trials", "bad.csv"), ("bad.csv", "line 2, column 'T'")),
        (("--trials", "fallen.csv"), ("0 of 24", "weaker limits")),
        (("--trials", "long.csv"), ("leg_length is 0.5", "0.4 m")),
        (("--tracking-limit", "0"), ("tracking_limit",)),
        (("--out", "/proc/nowhere"), ("/proc/nowhere",)),
    ],
)
def test_bad_input_is_one_sentence_and_writes_nothing(
    tmp_path: Path, arguments: tuple[str, ...], said: tuple[str, ...]
) -> None:
    table(tmp_path / "fallen.csv", fell=1)
    table(tmp_path / "long.csv", leg_length=0.5)
    table(tmp_path / "bad.csv", T="fast")
    before = set(tmp_path.iterdir())
    done = symdyn("fit-curves", *arguments, cwd=tmp_path)
    assert done.returncode == 2, (done.stdout, done.stderr)
    for words in said:
        assert words in " ".join(done.stderr.split()), done.stderr
    assert "Traceback" not in done.stderr
    assert set(tmp_path.iterdir()) == before


STUDY = ("study", "--k", "10", "--ks", "20", "21", "22", "--speeds", "0", "0.3", "--no-trot", "--out", "out")


def test_a_study_killed_and_run_again_has_every_model_once(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "symdyn", *STUDY, "--jobs", "1"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    cells = tmp_path / "out" / "cells"
    deadline = time.monotonic() + 300
    while not cells.is_dir() or not list(cells.glob("k*.json")):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    kept = {path.name: path.read_bytes() for path in cells.glob("k*.json")}
    assert 1 <= len(kept) < 3
    done = symdyn(*STUDY, "--jobs", "2", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert {name: (cells / name).read_bytes() for name in kept} == kept
    with (tmp_path / "out" / "study.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["k"], row["ks"]) for row in rows] == [(k, ks) for k in ("10.0",) for ks in ("20.0", "21.0", "22.0")]
    reference = next(row for row in rows if row["name"] == "k10.0_ks20.0")
    assert float(reference["a_T"]) == pytest.approx(1.57, abs=0.01)
    assert {row["status"] for row in rows} == {"done"}
    again = symdyn(*STUDY[:-1], "out", "--families", "TR", cwd=tmp_path)
    assert again.returncode == 0
    assert "3 without curves" in again.stdout and "no fit: The number of selected orbits is 0" in again.stdout
    assert not (again.stderr)
    refused = symdyn(*STUDY, "--speeds", "0", "0.4", cwd=tmp_path)
    assert refused.returncode == 2
    assert "a different fastest" in refused.stderr


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--k", "0"), ("k is (0.0,)",)),
        (("--k", "5", "5"), ("without duplicates",)),
        (("--J", "nan"), ("J is", "finite")),
        (("--robot", "go22"), ("Unknown robot 'go22'",)),
        (("--jobs", "-1"), ("jobs is -1",)),
        (("--backend", "slurm"), ("slurm",)),
        (("--out", "/proc/nowhere"), ("/proc/nowhere",)),
    ],
)
def test_bad_study(tmp_path: Path, arguments: tuple[str, ...], said: tuple[str, ...]) -> None:
    done = symdyn("study", *arguments, cwd=tmp_path)
    assert done.returncode == 2, (done.stdout, done.stderr)
    for words in said:
        assert words in " ".join(done.stderr.split()), done.stderr
    assert list(tmp_path.iterdir()) == []
