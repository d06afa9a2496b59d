"""Logs of sessions whose truth is known: written from a recording, or by the controller on a simulated robot."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from hardware.control.settings import TICK_HZ
from hardware.robot_sim.lockstep import SENDER
from hardware.running.deadline_loop import DeadlineLoop
from hardware.running.session import Session, sha256
from hardware.running.tick_record import record
from hardware.wire.channels import IMU, JOINTS, SESSION, TARGETS, TICK, TRUTH
from hardware.wire.event_log import LogWriter
from hardware.wire.messages import controller_tick_lcmt, leg_control_data_lcmt, state_estimator_lcmt
from hardware.wire.sdk_order import JOINTS_TO_SDK, LEGS_TO_SDK
from rl.pretrained import policy_path
from symdyn.analysis.recording import Recording
from tests.hardware.control.lockstep import world

BEGIN = 1234.5
"""s of the monotonic clock at the first sample."""


def joints_of(recording: Recording, k: int) -> leg_control_data_lcmt:
    """What the bridge says of the joints in sample k."""
    message = leg_control_data_lcmt()
    order = list(JOINTS_TO_SDK)
    message.q = recording.joint_pos[k][order].tolist()
    message.qd = recording.joint_vel[k][order].tolist()
    message.tau_est = recording.joint_torque[k][order].tolist()
    return message


def imu_of(recording: Recording, k: int) -> state_estimator_lcmt:
    """What the bridge says of the trunk in sample k."""
    message = state_estimator_lcmt()
    message.quat = recording.base_quat_w[k].tolist()
    message.aBody = [0.0, 0.0, 9.81]
    message.contact_estimate = (60.0 * recording.contact[k])[list(LEGS_TO_SDK)].tolist()
    return message


def truth_of(recording: Recording, k: int) -> state_estimator_lcmt:
    """What the simulated robot says of the truth in sample k; heading along x."""
    message = state_estimator_lcmt()
    v_x, v_y, yaw_rate = recording.velocity_h[k].tolist()
    message.quat, message.vWorld, message.omegaWorld = [1.0, 0.0, 0.0, 0.0], [v_x, v_y, 0.0], [0.0, 0.0, yaw_rate]
    message.p = recording.base_pos_w[k].tolist()
    message.contact_estimate = recording.contact[k][list(LEGS_TO_SDK)].astype(float).tolist()
    return message


def tick_of(recording: Recording, k: int, gait: str, number: int) -> controller_tick_lcmt:
    """What the deployer notes of sample k, having gone by the messages of that number."""
    message = controller_tick_lcmt()
    message.tick, message.time = k + 1, BEGIN + k * recording.dt
    message.joints_number = message.imu_number = number
    message.state, message.gait = "run", gait
    message.velocity_command = recording.velocity_command[k].tolist()
    message.velocity_estimate_h = recording.velocity_h[k].tolist()
    message.phase, message.period = float(recording.stride_phase[k]), float(recording.period[k])
    message.duty = float(recording.duty[k])
    message.contact = recording.contact[k].tolist()
    message.desired_stance = recording.desired_stance[k].tolist()
    message.state_age, message.compute = 0.001, 0.0005
    return message


def write_session(
    path: Path,
    recording: Recording,
    gaits: str | Sequence[str],
    states: Sequence[str] | None = None,
    faults: Sequence[str] | None = None,
    lost: Collection[int] = (),
    late: np.ndarray | None = None,
    truth: Recording | None = None,
) -> Path:
    """A deployer's log of a recording, a tick a sample. Between the messages that a tick goes by stand others.

    Args:
        path: of the log.
        recording: what happened.
        gaits: of every sample, or of all.
        states: of every sample; all of them run if None.
        faults: of every sample; none if None.
        lost: samples without a tick.
        late: (S,) how much later than its time each tick is, s.
        truth: what the simulated robot says, a message every other sample; None for a real robot.
    """
    other = leg_control_data_lcmt()
    other.q = [9.0] * len(other.q)
    with LogWriter(path, overwrite=True) as log:
        for k in range(len(recording.time)):
            now = BEGIN + k * recording.dt
            for place, message in enumerate((other, joints_of(recording, k), other)):
                log.append(JOINTS, message.encode(), now - 0.003 + 0.001 * place)
            for place, message in enumerate((state_estimator_lcmt(), imu_of(recording, k), state_estimator_lcmt())):
                log.append(IMU, message.encode(), now - 0.003 + 0.001 * place)
            if truth is not None and k % 2 == 0:
                log.append(TRUTH, truth_of(truth, k).encode(), now)
            if k in lost:
                continue
            tick = tick_of(recording, k, gaits if isinstance(gaits, str) else gaits[k], 3 * k + 2)
            tick.state = "run" if states is None else states[k]
            tick.fault = "" if faults is None else faults[k]
            tick.time += 0.0 if late is None else float(late[k])
            log.append(TICK, tick.encode(), tick.time)
    assert log.failure is None
    return path


def lockstep_session(path: Path, seconds: float, scenario: str = "run") -> Path:
    """The log of the shipped policy on a simulated robot, as the deployer would have written it, in simulated time."""
    both = world(scenario)
    session = Session(str(policy_path()), sha256(policy_path()), both.controller.settings, False, SENDER, "unknown")
    loop, sent = DeadlineLoop(1.0 / TICK_HZ), 0
    with LogWriter(path) as log:
        log.append(SESSION, session.message().encode(), 0.0)
        publish = both.rig.tick

        def logged(now: float) -> list[tuple[str, bytes]]:
            messages = publish(now)
            for channel, data in messages:
                log.append(channel, data, now)
            return messages

        both.rig.tick = logged
        for moment in both.ticks(seconds):
            loop.ticks += 1
            if moment.tick.targets is not None:
                sent += 1
                log.append(TARGETS, moment.tick.targets.message(sent, SENDER).encode(), moment.time)
            log.append(TICK, record(moment.time, moment.inputs, moment.tick, loop, sent, 0.0).encode(), moment.time)
    assert log.failure is None
    return path
