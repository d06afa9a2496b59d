"""A leg with hidden parameters, simulated by itself, is identified; logs that tell nothing are refused by reasons."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from benchmarks.hung_legs import log_events, measured_turn
from benchmarks.identify import hidden
from hardware.cli.arguments.identify import IdentifyArguments
from hardware.cli.identify import run
from hardware.control.excitation import MOVE_S
from hardware.control.settings import Settings
from hardware.identification.checks import check
from hardware.identification.identify import WIDEST, identify_legs, measured
from hardware.identification.least_squares import Estimate, block_covariance
from hardware.identification.signals import PERIOD, Signals, signals_of
from hardware.wire.event_log import LogWriter
from symdyn.errors import FileProblem
from symdyn.robot.fit import QUANTITIES, Measured, load_fit
from symdyn.robot.legs import JOINTS, LEG_JOINTS, LEGS
from tests.robots import GO2

SEED, LEG = 3, 1
OWN = slice(len(LEG_JOINTS) * LEG, len(LEG_JOINTS) * (LEG + 1))


@cache
def turn() -> Signals:
    return measured_turn(GO2, hidden(SEED), LEG, SEED)


TURNS = 5
"""That follow each other in :func:`whole`: longer than an excitation."""


@cache
def whole() -> Signals:
    """As if all legs had been moved at once as that one was, again and again: for the checks, which ask for all."""
    its = turn()
    lasts = len(its.time) * PERIOD
    pos, torque = (np.tile(array[:, OWN], (TURNS, len(LEGS))) for array in (its.pos, its.torque))
    return replace(
        its,
        time=PERIOD * np.arange(TURNS * len(its.time)),
        pos=pos,
        torque=torque,
        sent=np.concatenate([its.sent, *(its.sent[1:] + k * lasts for k in range(1, TURNS))]),
        targets=np.tile(np.concatenate([its.targets[:, OWN], *[its.targets[1:, OWN]] * (TURNS - 1)]), (1, len(LEGS))),
    )


def test_what_is_hidden_in_a_leg_is_found() -> None:
    truth = hidden(SEED)
    found = identify_legs(turn(), GO2, (LEG,))
    inside = 0
    for joint, quantities in found.items():
        true = {name: getattr(truth.joints[joint], name).value for name in QUANTITIES}
        value = {name: quantities[name][0] for name in QUANTITIES}
        assert value["delay"] == pytest.approx(true["delay"], abs=0.002)
        assert value["strength"] == pytest.approx(true["strength"], rel=0.05)
        assert value["kp"] == pytest.approx(true["kp"], rel=0.05)
        assert value["friction"] == pytest.approx(true["friction"], abs=0.05)
        inside += sum(abs(true[name] - value[name]) <= quantities[name][1] for name in QUANTITIES)
    assert inside >= 20  # of 24, at 95% each


def test_on_its_feet_a_robot_tells_delays_and_gains_and_nothing_of_masses() -> None:
    standing = replace(turn().session, settings=Settings(identify="standing"))
    found = identify_legs(replace(turn(), session=standing), GO2, (LEG,))
    assert all(set(quantities) == {"delay", "kp", "kd"} for quantities in found.values())
    assert measured("strength", None, 1.0) == Measured(1.0, 1.0, 1.0, determined=False)


def test_what_is_too_wide_counts_as_not_determined_and_the_models_number_lies_in_its_interval() -> None:
    wide = measured("armature", (0.009, 2.0 * WIDEST["armature"]), 0.004)
    assert (wide.value, wide.determined) == (0.004, False)
    assert wide.low <= 0.004 <= wide.high
    assert measured("friction", (-0.01, 0.02), 0.0) == Measured(0.0, 0.0, 0.01)


def test_a_log_read_back_holds_what_was_sent_and_measured() -> None:
    events = list(log_events(GO2, hidden(SEED), SEED, (LEG,)))
    end = next(k for k, (_, _, time) in enumerate(events) if time > MOVE_S + 3.0)
    signals = signals_of(events[:end], "log")
    assert len(signals.time) == pytest.approx((MOVE_S + 3.0) / PERIOD, abs=5)
    straight, moved = turn(), signals.time > MOVE_S + 0.2
    since = signals.time[moved] - MOVE_S
    np.testing.assert_allclose(signals.commanded(signals.time)[moved], straight.commanded(since), atol=1e-9)
    true = np.stack([np.interp(since, straight.time, column) for column in straight.pos.T[OWN]], axis=1)
    assert np.std(signals.pos[moved][:, OWN] - true) < 0.004


def test_the_command_writes_the_fit_of_a_log_and_its_figure(tmp_path: Path) -> None:
    log = LogWriter(tmp_path / "hung.lcmlog")
    for event in log_events(GO2, hidden(SEED), SEED):
        log.append(*event)
    log.close()
    out = tmp_path / "fit.toml"
    assert run(IdentifyArguments(tmp_path / "hung.lcmlog", out=out)) == 0
    found = load_fit(out, GO2)
    for joint, truth in zip(found.joints, hidden(SEED).joints, strict=True):
        if joint.delay.determined:
            assert joint.delay.value == pytest.approx(truth.delay.value, abs=0.002)
        assert joint.strength.value == pytest.approx(truth.strength.value, rel=0.05)
    assert sum(joint.delay.determined for joint in found.joints) >= 8
    assert out.with_suffix(".png").stat().st_size > 10_000


class TestRefusals:
    def test_a_log_that_is_too_short(self) -> None:
        with pytest.raises(FileProblem, match=r"too short: 10 s of the excitation, of which 120 s are needed"):
            check(whole().between(0, 5000), GO2, "log")

    def test_a_log_of_another_robot(self) -> None:
        with pytest.raises(FileProblem, match="is of a go2, not of a b1"):
            check(whole(), replace(GO2, name="b1"), "log")

    def test_a_log_in_which_a_joint_was_not_moved(self) -> None:
        targets = whole().targets.copy()
        targets[:, JOINTS.index("RF_calf")] = -1.5
        with pytest.raises(FileProblem, match=r"too little excitation.*each are RF_calf"):
            check(replace(whole(), targets=targets), GO2, "log")

    @pytest.mark.parametrize("what", ["pos", "torque"])
    def test_a_log_in_which_a_joint_is_cut_off(self, what: str) -> None:
        values = getattr(whole(), what).copy()
        values[:, JOINTS.index("LF_hip")] = np.median(values[:, JOINTS.index("LF_hip")])
        with pytest.raises(FileProblem, match="do not answer their targets, as if cut off: LF_hip"):
            check(replace(whole(), **{what: values}), GO2, "log")

    def test_a_log_without_an_excitation(self) -> None:
        with pytest.raises(FileProblem, match="holds no excitation of the joints: take a log of symdyn deploy"):
            signals_of([], "log")


def test_every_quantity_has_a_width_above_which_it_counts_as_not_determined() -> None:
    assert set(WIDEST) == set(QUANTITIES)


def test_intervals_hold_where_neighbouring_errors_are_alike() -> None:
    """A line through errors that are smoothed noise: its slope lies in 95% of the intervals.

    It would in half of them if the errors were taken for independent.
    """
    rng = np.random.default_rng(0)
    time = np.arange(2000) / 100.0
    jacobian = np.column_stack([np.sin(time), np.ones_like(time)])
    inside = []
    for _ in range(200):
        errors = np.convolve(rng.standard_normal(len(time) + 15), np.ones(16), mode="valid")
        value = np.linalg.lstsq(jacobian, errors)[0]
        covariance, blocks = block_covariance(jacobian, errors - jacobian @ value, (time / 0.5).astype(np.intp))
        inside.append(abs(value[0]) <= Estimate(value, covariance, blocks).half_width(np.array([1.0, 0.0])))
    assert 0.88 <= np.mean(inside) <= 0.99
