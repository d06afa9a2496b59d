"""The velocity filter against motions known exactly, against what symmetry demands, and on the simulated robot."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Sequence
from dataclasses import fields, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hardware.estimation.contact import FootContact
from hardware.estimation.settings import ContactConfig, EstimatorConfig
from hardware.estimation.velocity import Estimate, VelocityEstimator
from hardware.wire.readings import Imu, Joints
from symdyn.errors import InvalidValue
from symdyn.gait.library import PAPER_GAITS
from symdyn.robot.frames import to_heading
from symdyn.robot.legs import LEGS
from tests.hardware.estimation.rolling_walk import Motion, Sample, legs, turned, walk
from tests.hardware.robot_sim.robot_sim_runs import Run, driven

ALL = np.ones(len(LEGS), dtype=bool)
NONE = ~ALL
DT = 0.005
SECONDS = 2.0


@pytest.fixture(scope="module")
def swaying() -> list[Sample]:
    return walk(Motion(), SECONDS, DT)


def estimates(
    samples: Sequence[Sample], contact: np.ndarray = ALL, config: EstimatorConfig | None = None, dt: float = DT
):
    estimator = VelocityEstimator(legs(), config)
    return [estimator.update(dt, s.imu, s.joints, contact) for s in samples]


def velocity_errors(samples: Iterable[Sample], found: Iterable[Estimate]) -> np.ndarray:
    """(N, 3), m/s."""
    return np.array([e.velocity_w - s.velocity_w for s, e in zip(samples, found, strict=True)])


def settled(errors: np.ndarray) -> np.ndarray:
    """The second half."""
    return errors[len(errors) // 2 :]


def test_converges_to_the_exact_velocity(swaying: list[Sample]) -> None:
    found = estimates(swaying)
    errors = velocity_errors(swaying, found)
    assert np.abs(swaying[0].velocity_w).max() > 0.1  # the filter begins with 0
    assert np.abs(settled(errors)).max() < 1e-4
    heights = [e.height - s.position_w[2] for s, e in zip(swaying, found, strict=True)]
    assert np.abs(settled(np.array(heights))).max() < 1e-5


def test_the_error_that_is_left_is_one_of_the_step(swaying: list[Sample]) -> None:
    worst = []
    for dt in (4 * DT, 2 * DT, DT):
        samples = walk(Motion(), SECONDS, dt)
        errors = velocity_errors(samples, estimates(samples, dt=dt))
        worst.append(np.sqrt((settled(errors) ** 2).mean()))
    for coarse, fine in pairwise(worst):
        assert coarse > 2.5 * fine  # between first and second order


def test_a_foot_that_rolls_is_no_foot_that_slips(swaying: list[Sample]) -> None:
    # as if feet were points: the velocity of the centres, taken for that of the trunk, is several percent too small
    samples = walk(Motion(velocity=(0.3, 0.0, 0.0), sway=(0.0, 0.0, 0.0), tilt=(0.0, 0.0, 0.0)), 0.5, DT)
    last = samples[-1]
    feet = legs().feet(last.joints.pos)
    of_points = -(feet.centre_jacobian_b @ last.joints.vel.reshape(len(LEGS), -1, 1))[:, 0, 0]
    assert of_points == pytest.approx(0.3 * np.ones(len(LEGS)), rel=0.1)
    assert np.abs(of_points - 0.3).min() > 0.01
    assert estimates(samples)[-1].velocity_w[0] == pytest.approx(0.3, abs=1e-4)


@pytest.mark.parametrize("angle", [0.7, math.pi / 2, 3.0, -2.0])
def test_a_turned_world_gives_the_turned_estimate(swaying: list[Sample], angle: float) -> None:
    one, other = estimates(swaying), estimates([turned(s, angle) for s in swaying])
    turn = Rotation.from_rotvec([0.0, 0.0, angle])
    for e, t in zip(one, other, strict=True):
        np.testing.assert_allclose(t.velocity_w, turn.apply(e.velocity_w), atol=1e-9)
        np.testing.assert_allclose(t.position_w, turn.apply(e.position_w), atol=1e-9)
        for name in ("velocity_b", "velocity_h", "deviation_w", "trust"):
            np.testing.assert_allclose(getattr(t, name), getattr(e, name), atol=1e-9, err_msg=name)


def test_a_mirrored_robot_gives_the_mirrored_estimate(swaying: list[Sample], by_hand: Any) -> None:
    mirror = np.array([1.0, -1.0, 1.0])
    images = [
        replace(
            s,
            imu=Imu(
                quat_w=s.imu.quat_w * [1.0, -1.0, 1.0, -1.0],
                angular_velocity_b=-s.imu.angular_velocity_b * mirror,
                acceleration_b=s.imu.acceleration_b * mirror,
                foot_force=by_hand.legs(s.imu.foot_force),
            ),
            joints=Joints(*(by_hand.joints(a) for a in (s.joints.pos, s.joints.vel, s.joints.torque))),
        )
        for s in swaying
    ]
    contact = np.array([True, False, True, True])
    for e, m in zip(estimates(swaying, contact), estimates(images, by_hand.legs(contact)), strict=True):
        # the feet's meshes are 0.04 mm off their middle
        np.testing.assert_allclose(m.velocity_w, e.velocity_w * mirror, atol=1e-3)
        np.testing.assert_allclose(m.velocity_h, e.velocity_h * [1.0, -1.0, -1.0], atol=1e-3)


def test_frames_agree_with_each_other(swaying: list[Sample]) -> None:
    for sample, e in zip(swaying, estimates(swaying), strict=True):
        attitude = Rotation.from_quat(sample.imu.quat_w, scalar_first=True)
        np.testing.assert_allclose(attitude.apply(e.velocity_b), e.velocity_w, atol=1e-12)
        np.testing.assert_allclose(e.velocity_h[:2], to_heading(sample.imu.quat_w, e.velocity_w)[:2], atol=1e-12)
        assert e.velocity_h[2] == pytest.approx(attitude.apply(sample.imu.angular_velocity_b)[2], abs=1e-12)


def test_rate_hardly_matters() -> None:
    """2.5 times the samples with the same errors for as long tell nothing new."""
    deviations = [estimates(walk(Motion(), 1.0, dt), dt=dt)[-1].deviation_w for dt in (0.005, 0.002)]
    np.testing.assert_allclose(*deviations, rtol=0.05)


def test_a_constant_bias_of_the_accelerometer_moves_the_velocity_by_little(swaying: list[Sample]) -> None:
    """It cannot be observed apart from tilt, and there is no state for it; the legs hold it down."""
    bias = 0.3
    tilted = [replace(s, imu=replace(s.imu, acceleration_b=s.imu.acceleration_b + bias)) for s in swaying]
    errors = settled(velocity_errors(swaying, estimates(tilted)))
    assert 0.001 < np.abs(errors).max() < 0.03
    # by a tenth of a second's worth: without legs it would be bias * time
    assert bias * SECONDS > 10 * np.abs(errors).max()


def test_legs_tell_of_velocity_but_not_of_where_one_is() -> None:
    standing = walk(Motion(sway=(0.0, 0.0, 0.0), tilt=(0.0, 0.0, 0.0)), 4.0, DT)
    estimator = VelocityEstimator(legs())
    seen = []
    for s in standing:
        estimator.update(DT, s.imu, s.joints, ALL)
        variance = np.diagonal(estimator._covariance, axis1=1, axis2=2)
        seen.append((variance[0, 0], variance[2, 0], variance[0, 1]))
    along, height, velocity = np.array(seen).T
    late = slice(len(seen) // 2, None)
    assert (np.diff(along[late]) > 0.0).all()
    assert np.ptp(height[late]) < 0.05 * height[-1]
    assert np.ptp(velocity[late]) < 0.01 * velocity[-1]


def test_a_flight_is_carried_by_the_accelerometer() -> None:
    """Thrown up from a stand: legs that hang tell nothing, gravity all."""
    stand = walk(Motion(velocity=(0.2, 0.0, 0.0), sway=(0.0, 0.0, 0.0), tilt=(0.0, 0.0, 0.0)), 0.5, DT)
    estimator, last = VelocityEstimator(legs()), stand[-1]
    for s in stand:
        estimator.update(DT, s.imu, s.joints, ALL)
    thrown, count = 40.0, 10  # m/s^2 above gravity for 0.05 s; then free
    up, free = (replace(last.imu, acceleration_b=np.array([0.0, 0.0, a])) for a in (thrown + 9.81, 0.0))
    still = replace(last.joints, vel=np.zeros(12))
    for _ in range(count):
        estimator.update(DT, up, still, NONE)
    flight = [estimator.update(DT, free, still, NONE) for _ in range(40)]
    slopes = np.diff([e.velocity_w for e in flight], axis=0) / DT
    # to a hair: feet that may go anywhere still tell that they do not go at any speed
    np.testing.assert_allclose(slopes[1:], np.tile([0.0, 0.0, -9.81], (38, 1)), atol=2e-3)
    assert flight[0].velocity_w[0] == pytest.approx(0.2, abs=1e-3)
    assert (np.diff([e.deviation_w[0] for e in flight]) > 0.0).all()


def test_a_robot_held_in_the_air_does_not_take_off() -> None:
    hung = walk(Motion(sway=(0.0, 0.0, 0.0), tilt=(0.0, 0.0, 0.0)), 0.1, DT)[-1]
    leaning = replace(hung.imu, acceleration_b=np.array([0.3, 0.0, 9.81]))
    estimator = VelocityEstimator(legs())
    speeds = [np.linalg.norm(estimator.update(DT, leaning, hung.joints, NONE).velocity_w) for _ in range(1000)]
    assert max(speeds) < 0.3 and speeds[-1] < 0.1
    without = VelocityEstimator(legs(), EstimatorConfig(longest_flight=1e6))
    for _ in range(1000):
        away = without.update(DT, leaning, hung.joints, NONE)
    assert np.linalg.norm(away.velocity_w) > 1.2  # all but 0.3 m/s^2 for 5 s


def slipping(samples: Sequence[Sample], leg: str, speed: float) -> list[Sample]:
    """One foot's joints move as if it slid at that speed, m/s, from 1 s on."""
    found, i = [], LEGS.index(leg)
    for s in samples:
        jacobian = legs().feet(s.joints.pos).centre_jacobian_b[i]
        vel = s.joints.vel.copy().reshape(len(LEGS), -1)
        if s.time > 1.0:
            vel[i] += np.linalg.solve(jacobian, [speed, 0.0, 0.0])
        found.append(replace(s, joints=replace(s.joints, vel=vel.ravel())))
    return found


@pytest.mark.parametrize("leg", LEGS)
def test_a_foot_that_slips_is_not_believed(swaying: list[Sample], leg: str) -> None:
    samples = slipping(swaying, leg, speed=1.0)
    robust, trusting = (estimates(samples, config=EstimatorConfig(tail=tail)) for tail in (2.0, 1e9))
    error, naive = (np.abs(settled(velocity_errors(swaying, e))).max() for e in (robust, trusting))
    assert error < 0.05 < 0.15 < naive
    assert robust[-1].trust[LEGS.index(leg)] < 0.1
    others = np.delete(robust[-1].trust, LEGS.index(leg))
    assert (others > 0.9).all()


def test_all_feet_are_believed_in_the_end(swaying: list[Sample]) -> None:
    """A wrong estimate does not lock itself in: here the world gets a velocity that the accelerometer did not see."""
    estimator = VelocityEstimator(legs())
    for s in swaying[:100]:
        estimator.update(DT, s.imu, s.joints, ALL)
    estimator._state[:, 1] += 2.0
    for s in swaying[100:]:
        found = estimator.update(DT, s.imu, s.joints, ALL)
    assert np.abs(found.velocity_w - swaying[-1].velocity_w).max() < 0.02


def test_trust_rises_after_touchdown(swaying: list[Sample]) -> None:
    estimator = VelocityEstimator(legs(), EstimatorConfig(trust_rise=0.05))
    for s in swaying[:100]:
        estimator.update(DT, s.imu, s.joints, ALL)
    lifted = np.array([leg != "LF" for leg in LEGS])
    for s in swaying[100:120]:
        assert estimator.update(DT, s.imu, s.joints, lifted).trust[LEGS.index("LF")] == 0.0
    trust = [estimator.update(DT, s.imu, s.joints, ALL).trust[LEGS.index("LF")] for s in swaying[120:135]]
    np.testing.assert_allclose(trust, np.minimum(np.arange(1, 16) * DT / 0.05, 1.0), atol=1e-9)


def spoilt(sample: Sample, term: str, value: float) -> tuple[Imu, Joints]:
    """Its messages with one number replaced."""
    imu, joints = sample.imu, sample.joints
    for message in (imu, joints):
        if hasattr(message, term):
            array = getattr(message, term).copy()
            array[1] = value
            changed = replace(message, **{term: array})
            return (changed, joints) if message is imu else (imu, changed)
    raise AssertionError(term)


USED = ("quat_w", "angular_velocity_b", "acceleration_b", "pos", "vel")


@pytest.mark.parametrize("term", USED)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e9])
def test_bad_input_leaves_no_trace(
    swaying: list[Sample], term: str, value: float, caplog: pytest.LogCaptureFixture
) -> None:
    estimator = VelocityEstimator(legs())
    with caplog.at_level(logging.WARNING):
        before = [estimator.update(DT, s.imu, s.joints, ALL) for s in swaying[:100]][-1]
        for s in swaying[100:103]:
            found = estimator.update(DT, *spoilt(s, term, value), ALL)
            assert not found.valid
            np.testing.assert_array_equal(found.velocity_w, before.velocity_w)
        found = [estimator.update(DT, s.imu, s.joints, ALL) for s in swaying[103:200]][-1]
        assert found.valid
    assert len(caplog.records) == 1 and "ignores invalid input" in caplog.text
    errors = found.velocity_w - swaying[199].velocity_w
    assert np.abs(errors).max() < 1e-3


@pytest.mark.parametrize("quat_w", [np.zeros(4), np.array([0.5, 0.0, 0.0, 0.0]), np.ones(4)])
def test_a_quaternion_that_is_none(swaying: list[Sample], quat_w: np.ndarray) -> None:
    """Zeros are what the bridge sends before it has data from the robot."""
    estimator, s = VelocityEstimator(legs()), swaying[0]
    assert not estimator.update(DT, replace(s.imu, quat_w=quat_w), s.joints, ALL).valid
    assert estimator.update(DT, s.imu, s.joints, ALL).valid


@pytest.mark.parametrize("dt", [0.0, -DT, math.nan, math.inf])
def test_a_time_step_that_is_none(swaying: list[Sample], dt: float) -> None:
    estimator, s = VelocityEstimator(legs()), swaying[0]
    first = estimator.update(DT, s.imu, s.joints, ALL)
    again = estimator.update(dt, s.imu, s.joints, ALL)
    assert not again.valid
    np.testing.assert_array_equal(again.velocity_w, first.velocity_w)


@pytest.mark.parametrize("gap", ["one long step", "bad input"])
def test_begins_anew_after_a_gap(swaying: list[Sample], gap: str, caplog: pytest.LogCaptureFixture) -> None:
    estimator = VelocityEstimator(legs())
    for s in swaying[:100]:
        estimator.update(DT, s.imu, s.joints, ALL)
    with caplog.at_level(logging.WARNING):
        if gap == "bad input":
            for s in swaying[100:140]:
                estimator.update(DT, *spoilt(s, "vel", math.nan), ALL)
        s = swaying[140]
        found = estimator.update(DT if gap == "bad input" else 0.205, s.imu, s.joints, ALL)
    assert "restarts" in caplog.text
    fresh = VelocityEstimator(legs()).update(DT if gap == "bad input" else 0.205, s.imu, s.joints, ALL)
    for field in fields(Estimate):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(fresh, field.name))


def test_reset_forgets_everything(swaying: list[Sample]) -> None:
    estimator = VelocityEstimator(legs())
    for _ in range(2):
        found = [estimator.update(DT, s.imu, s.joints, ALL) for s in swaying[:50]]
        np.testing.assert_array_equal(found[-1].velocity_w, estimates(swaying[:50])[-1].velocity_w)
        estimator.reset()


anything = st.floats(allow_nan=True, allow_infinity=True, width=32)
plausible = st.floats(-3.0, 3.0)


@given(data=st.data())
def test_whatever_comes_the_estimate_is_finite(data: st.DataObject) -> None:
    estimator = VelocityEstimator(legs())
    for _ in range(4):
        number = data.draw(st.sampled_from([plausible, anything]))

        def array(size: int, number: st.SearchStrategy[float] = number) -> np.ndarray:
            return np.array(data.draw(st.lists(number, min_size=size, max_size=size)))

        quat_w = array(4)
        if np.isfinite(quat_w).all() and 0.0 < np.linalg.norm(quat_w) < np.inf and data.draw(st.booleans()):
            quat_w = quat_w / np.linalg.norm(quat_w)
        imu = Imu(quat_w, array(3), array(3), array(4))
        joints = Joints(array(12), array(12), array(12))
        contact = np.array(data.draw(st.lists(st.booleans(), min_size=4, max_size=4)))
        with np.errstate(all="ignore"):
            found = estimator.update(data.draw(st.sampled_from([DT, 1e-9, 0.09, 0.0, math.nan])), imu, joints, contact)
        for field in fields(Estimate):
            assert np.isfinite(getattr(found, field.name)).all()
        assert np.abs(found.velocity_w).max() <= 10.0


def test_alternating_contacts_keep_the_filter_well_conditioned(swaying: list[Sample]) -> None:
    estimator = VelocityEstimator(legs())
    diagonal = np.array([leg in ("LH", "RF") for leg in LEGS])
    for k in range(2_000):
        s = swaying[k % 200]
        found = estimator.update(DT, s.imu, s.joints, diagonal if k % 40 < 20 else ~diagonal)
        assert found.valid
    eigenvalues = np.linalg.eigvalsh(estimator._covariance)
    assert eigenvalues.min() > 0.0
    np.testing.assert_array_equal(estimator._covariance, estimator._covariance.transpose(0, 2, 1))


@pytest.mark.parametrize("name", [field.name for field in fields(EstimatorConfig)])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_noise_that_is_none(name: str, value: float) -> None:
    with pytest.raises(InvalidValue, match=f"estimator.{name}"):
        EstimatorConfig(**{name: value})


def judged(run: Run, source: str) -> np.ndarray:
    """Errors of forward and lateral velocity and yaw rate, and of vertical velocity and height, (N, 5), at 200 Hz."""
    contact, estimator = FootContact(ContactConfig(source=source), legs()), VelocityEstimator(legs())
    errors = []
    for sample in run.samples:
        feet = contact.update(sample.imu, sample.joints, sample.dt)
        e = estimator.update(sample.dt, sample.imu, sample.joints, feet)
        truth = [*sample.velocity_h, sample.velocity_w[2], sample.position_w[2]]
        errors.append(np.array([*e.velocity_h, e.velocity_w[2], e.height]) - truth)
    return np.array(errors)


def rms(errors: np.ndarray) -> np.ndarray:
    return np.sqrt((errors**2).mean(axis=0))


@pytest.mark.parametrize("gait", PAPER_GAITS)
def test_velocity_of_the_simulated_robot(gait: str) -> None:
    """The demand: an RMS error of v_x of at most 0.1 m/s in every gait at 0.8 m/s."""
    run = driven(gait, (0.8, 0.0, 0.0), seed=PAPER_GAITS.index(gait))
    for source in ("force", "torque"):
        errors = judged(run, source)[run.running]
        forward, lateral, yaw_rate, vertical, height = rms(errors)
        assert forward < 0.1, source
        # what it was found to do, half as much again
        assert forward < 0.065 and lateral < 0.04 and yaw_rate < 0.05 and vertical < 0.08 and height < 0.01, source
        strides = np.convolve(errors[:, 0], np.ones(80) / 80, "valid")  # 0.4 s
        assert rms(strides) < 0.05, source


@pytest.mark.parametrize(
    ("gait", "command"),
    [("bound", (-0.8, 0.0, 0.0)), ("half_bound_left", (1.5, 0.0, 0.0)), ("rotary_gallop", (0.5, 0.0, 0.6))],
)
def test_velocity_of_the_simulated_robot_otherwise(gait: str, command: tuple[float, float, float]) -> None:
    run = driven(gait, command, seed=1)
    forward, lateral, *_ = rms(judged(run, "force")[run.running])
    assert forward < 0.1 and lateral < 0.1
