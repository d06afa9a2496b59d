"""T(v) and beta(v) against numbers worked out by hand from the paper's equation 1, and against bad files."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.errors import FileProblem, InvalidValue
from symdyn.gait.timing import TimingCurve
from tests.robots import GO2

PAPER = TimingCurve()


def period(v: float, delta: float = 0.0, curve: TimingCurve = PAPER) -> float:
    return float(curve.period(np.array([v]), 0.40, delta)[0])


def duty(v: float, delta: float = 0.0, curve: TimingCurve = PAPER) -> float:
    return float(curve.duty(np.array([v]), 0.40, delta)[0])


def test_constants_are_the_papers() -> None:
    assert (PAPER.a_T, PAPER.b_T, PAPER.c_T) == (2.55, 0.20, 0.975)
    assert (PAPER.a_beta, PAPER.b_beta, PAPER.c_beta) == (0.5588, 0.20, 0.681)
    assert GO2.leg_length == 0.40
    assert "calibrated" in PAPER.source  # and not derived from the passive model


@pytest.mark.parametrize(("v", "seconds"), [(0.0, 0.515), (0.5, 0.403), (2.0, 0.193)])
def test_period_at_the_speeds_that_design_names(v: float, seconds: float) -> None:
    # design.md prints three digits; the last of T(2) = 0.1924 is rounded up there
    assert period(v) == pytest.approx(seconds, abs=1e-3)
    assert period(-v) == period(v)


@pytest.mark.parametrize("delta", [-1.0, 0.0, 0.6, 1.0])
@pytest.mark.parametrize("v", [0.0, 0.3, -0.7, 1.2, -2.0])
def test_equation_1(v: float, delta: float) -> None:
    v_star = abs(v) / (9.81 * 0.40) ** 0.5
    assert duty(v, delta) == pytest.approx(0.5588 * (1.0 + 0.20 * delta * v_star) * math.exp(-0.681 * v_star))
    t_star = 2.55 * (1.0 + 0.20 * delta * v_star) * math.exp(-0.975 * v_star)
    assert period(v, delta) == pytest.approx(t_star * (0.40 / 9.81) ** 0.5)


def test_each_robot_has_its_own_delta() -> None:
    v, delta = np.array([1.0, 1.0, 0.0]), np.array([-1.0, 1.0, 1.0])
    got = PAPER.period(v, 0.40, delta)
    assert got[0] < period(1.0) < got[1]
    assert got[2] == pytest.approx(period(0.0))  # the spread vanishes at rest


def test_clamps() -> None:
    assert period(20.0) == 0.1
    assert duty(20.0) == 0.1
    assert duty(0.0, curve=replace(PAPER, a_beta=1.0)) == 0.9


@given(st.floats(-1e3, 1e3), st.floats(-1.0, 1.0))
def test_always_within_the_clamps(v: float, delta: float) -> None:
    assert 0.1 <= period(v, delta) < 1.0
    assert 0.1 <= duty(v, delta) <= 0.9


@given(st.floats(0.0, 1.2), st.floats(0.01, 1.0))
def test_a_faster_robot_strides_sooner_and_stands_less(v: float, more: float) -> None:
    assert period(v + more) < period(v)
    assert duty(v + more) < duty(v)


def test_longer_legs_stride_more_slowly_at_rest() -> None:
    # dynamic similarity: time goes with the square root of length
    ratio = PAPER.period(np.zeros(1), 0.80) / PAPER.period(np.zeros(1), 0.40)
    assert float(ratio[0]) == pytest.approx(math.sqrt(2.0))


def test_numpy_and_torch_give_the_same() -> None:
    v, delta = np.linspace(-2.0, 2.0, 41), np.linspace(-1.0, 1.0, 41)
    for curve in (PAPER.period, PAPER.duty):
        theirs = curve(torch.from_numpy(v), 0.40, torch.from_numpy(delta))
        assert isinstance(theirs, torch.Tensor)
        np.testing.assert_allclose(theirs.numpy(), curve(v, 0.40, delta), rtol=1e-15)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("a_T", 0.0),
        ("a_T", -2.55),
        ("b_T", 1.5),
        ("c_T", math.nan),
        ("a_beta", 1.2),
        ("c_beta", math.inf),
        ("a_T", "2"),
    ],
)
def test_absurd_constants_are_refused_by_name(name: str, value: Any) -> None:
    with pytest.raises(InvalidValue, match=f"{name} is .*a number in"):
        replace(PAPER, **{name: value})


@settings(max_examples=20)  # every write waits for the disk
@given(
    a_T=st.floats(0.1, 10.0), b_T=st.floats(0.0, 1.0), c_T=st.floats(-1.0, 5.0),
    a_beta=st.floats(0.05, 1.0), b_beta=st.floats(0.0, 1.0), c_beta=st.floats(-1.0, 5.0),
    source=st.text(st.characters(codec="utf-8"), max_size=40),
)  # fmt: skip
def test_round_trip_of_the_file_is_exact(tmp_path_factory: pytest.TempPathFactory, **constants: Any) -> None:
    curve = TimingCurve(**constants)
    path = tmp_path_factory.getbasetemp() / "round_trip.json"
    curve.save(path, name="mine")
    assert TimingCurve.load(path) == curve


def test_only_the_active_curve_of_a_file_counts(tmp_path: Path) -> None:
    other = replace(PAPER, a_T=3.0, source="other")
    document = {"format_version": 1, "active": "b", "curves": {"a": PAPER.as_dict(), "b": other.as_dict()}}
    (tmp_path / "curves.json").write_text(json.dumps(document))
    assert TimingCurve.load(tmp_path / "curves.json") == other


CURVE = {"curve": PAPER.as_dict()}


def document(**change: Any) -> dict[str, Any]:
    """A good curves file with constants of its only curve changed, or removed where None is given."""
    constants = {**PAPER.as_dict(), **change}
    kept = {name: value for name, value in constants.items() if value is not None}
    return {"format_version": 1, "active": "curve", "curves": {"curve": kept}}


BAD_FILES: dict[str, tuple[str, str]] = {
    "missing constant": (json.dumps(document(c_T=None, a_beta=None)), "lacks the timing constants c_T, a_beta"),
    "missing source": (json.dumps(document(source=None)), "lacks the timing constants source"),
    "absurd": (json.dumps(document(a_T=2550.0)), "a_T is 2550.0"),
    "negative": (json.dumps(document(a_beta=-0.5)), "a_beta is -0.5"),
    "NaN": (json.dumps(document(c_beta=math.nan)), "c_beta is nan"),
    "infinite": (json.dumps(document(c_beta=math.inf)), "c_beta is inf"),
    "text for a number": (json.dumps(document(b_T="0.2")), "b_T is '0.2'"),
    "truth for a number": (json.dumps(document(b_T=True)), "b_T is True"),
    "list for a number": (json.dumps(document(b_T=[0.2])), "b_T is "),
    "no JSON": ('{"format_version": 1,', "is not valid JSON"),
    "empty": ("", "is not valid JSON"),
    "a list": ("[]", "not a curves file with format_version 1"),
    "other version": (json.dumps({**document(), "format_version": 2}), "not a curves file with format_version 1"),
    "no version": (json.dumps({"active": "curve", "curves": CURVE}), "not a curves file with format_version 1"),
    "active curve missing": (json.dumps({**document(), "active": "other"}), "names 'other' as its active curve"),
    "no active curve": (json.dumps({"format_version": 1, "curves": CURVE}), "names None as its active"),
    "curves no table": (json.dumps({**document(), "curves": ["curve"]}), "names 'curve' as its active curve"),
    "curve no table": (
        json.dumps({**document(), "curves": {"curve": [1, 2]}}),
        "contains list instead of timing",
    ),
}


@pytest.mark.parametrize("what", BAD_FILES)
def test_bad_file(tmp_path: Path, what: str) -> None:
    text, complaint = BAD_FILES[what]
    path = tmp_path / "curves.json"
    path.write_text(text)
    with pytest.raises(FileProblem) as error:
        TimingCurve.load(path)
    assert str(path) in str(error.value)
    assert complaint in str(error.value)


def test_binary_file(tmp_path: Path) -> None:
    path = tmp_path / "curves.json"
    path.write_bytes(b"\x93NUMPY\xff\xfe")
    with pytest.raises(FileProblem, match="is not valid JSON"):
        TimingCurve.load(path)


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileProblem, match="cannot be read"):
        TimingCurve.load(tmp_path / "none.json")
    with pytest.raises(FileProblem, match="cannot be read"):
        TimingCurve.load(tmp_path)


def test_active_curve_that_is_no_name(tmp_path: Path) -> None:
    path = tmp_path / "curves.json"
    path.write_text(json.dumps({**document(), "active": ["curve"]}))
    with pytest.raises(FileProblem):
        TimingCurve.load(path)


def test_constant_too_large_for_a_float(tmp_path: Path) -> None:
    path = tmp_path / "curves.json"
    path.write_text(json.dumps(document(a_T=10**400)))
    with pytest.raises(FileProblem):
        TimingCurve.load(path)


def test_deeply_nested_file(tmp_path: Path) -> None:
    path = tmp_path / "curves.json"
    path.write_text("[" * 100_000)
    with pytest.raises(FileProblem):
        TimingCurve.load(path)
