"""The deployer's mind with a simulated robot on one clock: what it does, and what it never does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hardware.control.controller import Controller, Inputs, Request, State
from hardware.control.faults import FAULTS
from hardware.control.health import tilt
from hardware.control.joystick import Buttons, JoystickConfig
from hardware.control.limits import target_range
from hardware.control.settings import TICK_HZ, Settings, StandConfig
from hardware.robot_sim.lockstep import Lockstep, Moment
from hardware.robot_sim.rig import PlannedFault, Rig
from hardware.robot_sim.scenarios import get_scenario
from hardware.wire.link import Received
from hardware.wire.messages import rc_command_lcmt
from hardware.wire.readings import Imu, Joints, Targets
from rl.judging.simulate import Script, Segment
from rl.judging.simulate import run as simulate
from symdyn.analysis import metrics
from symdyn.errors import InvalidValue
from symdyn.gait.library import PAPER_GAITS, get
from symdyn.gait.phase import advance
from symdyn.gait.symmetry import gait_by_name
from symdyn.policy.driver import PolicyDriver
from tests.hardware.control.lockstep import STANDS_AFTER, before, shipped, until, up_to, world
from tests.hardware.robot_sim.simulated import go2

QUICK = Settings(stand=StandConfig(rise_s=0.8, ramp_s=0.2, settle_s=0.2, wiggle_s=0.1))
"""For tests of what comes after the stand."""

SOON = replace(QUICK, stand=replace(QUICK.stand, wiggle_s=StandConfig().wiggle_s))
"""For tests of the stand's checks: quick up, but the joints are moved as usual."""

ORDER = [State.PASSIVE, State.STAND, State.RUN, State.DAMP, State.PASSIVE]


def states(moments: Sequence[Moment]) -> list[State]:
    """In the order in which they were gone through."""
    found: list[State] = []
    for moment in moments:
        if not found or found[-1] is not moment.tick.state:
            found.append(moment.tick.state)
    return found


def check_limits(world: Lockstep, moments: Sequence[Moment]) -> None:
    """Every target that was sent was within every limit for the state that it was computed from; none was missing."""
    limits, safety = world.controller.limits, world.controller.settings.safety
    for moment in moments:
        targets, inputs = moment.tick.targets, moment.inputs
        if moment.tick.state is State.PASSIVE:
            assert targets is None
            continue
        assert targets is not None, "silence outside Passive"
        assert all(np.isfinite(array).all() for array in (targets.pos, targets.kp, targets.kd))
        assert inputs.joints is not None
        joints = Joints.of(inputs.joints.message)
        if not joints.finite() or moment.time - inputs.joints.arrival > safety.stale_s:
            assert not targets.kp.any()
            continue
        torque = targets.kp * (targets.pos - joints.pos) - targets.kd * joints.vel
        assert (np.abs(torque) <= limits.torque + 1e-6).all()
        if targets.kp.any():
            low, high = target_range(joints, limits, safety.target_lead)
            assert ((targets.pos >= low - 1e-9) & (targets.pos <= high + 1e-9)).all()


@pytest.fixture(scope="module")
def gaits_run() -> tuple[Lockstep, list[Moment]]:
    """The paper's experiment on the robot, from lying down to lying down."""
    its = world("paper")
    return its, its.run(62.0)


class TestPaperExperiment:
    def test_goes_through_its_states_without_a_fault(self, gaits_run: tuple[Lockstep, list[Moment]]) -> None:
        its, moments = gaits_run
        assert states(moments) == ORDER
        assert its.rig.person.done
        assert its.rig.fell_at is None
        assert its.controller.fault is not None
        assert its.controller.fault.name == "emergency_stop"  # the person's own

    def test_every_target_was_within_its_limits(self, gaits_run: tuple[Lockstep, list[Moment]]) -> None:
        check_limits(*gaits_run)
        its, _ = gaits_run
        assert its.rig.monitor.torque_excesses == 0  # the robot's side agrees

    def test_the_policy_runs_in_every_fourth_tick_and_the_clock_turns_with_time(
        self, gaits_run: tuple[Lockstep, list[Moment]]
    ) -> None:
        its, moments = gaits_run
        running = [moment for moment in moments if moment.tick.state is State.RUN]
        acted = np.array([moment.tick.acted for moment in running])
        assert acted[::4].all()
        assert acted.sum() == -(-len(running) // 4)
        phase = running[0].tick.phase
        for earlier, moment in pairwise(running):
            # the period of the command before, and then the new command's clock: no jump with the command
            phase = float(advance(np.array([phase]), np.array([earlier.tick.period]), moment.time - earlier.time)[0])
            assert abs((phase - moment.tick.phase + 0.5) % 1.0 - 0.5) < 1e-9
        assert its.controller.policy.metadata.control_dt * TICK_HZ == 4

    def test_runs_each_gait_as_it_was_asked(self, gaits_run: tuple[Lockstep, list[Moment]]) -> None:
        _, moments = gaits_run
        # that of the evaluation in the trainer's simulator, where contacts are known
        scripts = [Script(name, (Segment(0.0, get(name), (0.8, 0.0, 0.0)),), 5.0) for name in PAPER_GAITS]
        for name, reference in zip(PAPER_GAITS, simulate(shipped(), scripts), strict=True):
            ticks = [m.tick for m in moments if m.tick.gait.name == name and m.tick.velocity_command[0] > 0.79]
            contact = np.array([tick.contact for tick in ticks[200:]])
            desired = np.array([tick.desired_stance for tick in ticks[200:]])
            its = reference.recording.between(1.0, 5.0)
            # 0.06: what the sensors cost
            assert metrics.gc_stance(contact, desired) < metrics.gc_stance(its.contact, its.desired_stance) + 0.06
            speed = np.mean([tick.estimate.velocity_h[0] for tick in ticks[200:] if tick.estimate is not None])
            assert abs(speed - 0.8) < 0.1

    def test_the_same_seed_twice_is_the_same_to_the_last_bit(self, gaits_run: tuple[Lockstep, list[Moment]]) -> None:
        second = world("paper").run(8.0)
        first = gaits_run[1][: len(second)]
        assert first[-1].time == second[-1].time
        assert second[-1].tick.state is State.RUN
        for a, b in zip(first, second, strict=True):
            assert a.tick.state is b.tick.state
            if a.tick.targets is not None and b.tick.targets is not None:
                assert np.array_equal(a.tick.targets.pos, b.tick.targets.pos)


class TestStand:
    def test_starts_where_the_joints_are_without_a_kick(self) -> None:
        its = world("stand")
        moments = [*until(its, State.STAND, 2.0), *its.run(0.05)]
        for moment in moments:
            if moment.tick.targets is not None and moment.inputs.joints is not None:
                joints = Joints.of(moment.inputs.joints.message)
                torque = moment.tick.targets.kp * (moment.tick.targets.pos - joints.pos)
                assert np.abs(torque).max() < 1.0  # N m

    def test_run_is_entered_from_a_checked_stand_only(self) -> None:
        its = world("stand")
        until(its, State.STAND, 2.0)
        ready = [moment.tick.ready for moment in its.run(STANDS_AFTER)]
        assert not ready[0]
        assert ready[-1]
        impatient = world("idle")
        joystick = rc_command_lcmt()
        impatient.rig.person.message = lambda seen: joystick  # type: ignore[method-assign]
        impatient.run(1.0)
        found = []
        for k in range(40):  # R1 again and again
            joystick.right_upper_switch = k % 2
            found += impatient.run(0.1)
        assert states(found) == [State.PASSIVE, State.STAND]

    @pytest.mark.parametrize("name", ["swapped_legs_state", "swapped_legs_command", "sign_flipped", "motor_dead"])
    def test_joints_that_answer_for_others_are_found_out(self, name: str) -> None:
        its = before(State.STAND, Settings(), PlannedFault(name, 2.0, "stand"))
        moments = [*until(its, State.DAMP, 8.0), *its.run(0.5)]
        assert State.RUN not in states(moments)
        assert its.controller.fault is not None
        assert its.controller.fault.name in ("joint_order", "joint_position", "not_standing")
        check_limits(its, moments)

    @pytest.mark.parametrize("name", ["swapped_legs_both", "quat_inverse"])
    def test_what_is_exchanged_alike_is_found_out_by_the_trunk(self, name: str) -> None:
        its = before(State.STAND, SOON, PlannedFault(name, 0.5))
        moments = [*until(its, State.DAMP, 7.0), *its.run(0.5)]
        assert State.RUN not in states(moments)
        assert its.controller.fault is not None
        assert its.controller.fault.name == "leg_order"
        check_limits(its, moments)

    @pytest.mark.parametrize("seed", range(2))
    def test_a_robot_in_a_harness_passes(self, seed: int) -> None:
        rig = Rig(go2(seed, start="hung"), get_scenario("stand"), seed=seed)
        its = Lockstep(Controller(shipped(), Settings()), rig)
        until(its, State.STAND, 2.0)
        assert its.run(STANDS_AFTER)[-1].tick.ready, its.controller.fault


class TestFaults:
    @pytest.mark.parametrize("settings", [QUICK, SOON, Settings()])
    def test_up_to_there_every_target_was_within_its_limits(self, settings: Settings) -> None:
        for state in (State.STAND, State.RUN):
            check_limits(before(state, settings), up_to(state, settings))

    @pytest.mark.parametrize("since", ["stand", "run"])
    @pytest.mark.parametrize(
        ("name", "struck"),
        [
            ("silent", "no_joint_state"),
            ("silent_joints", "no_joint_state"),
            ("silent_imu", "no_imu_state"),
            ("silent_joystick", "no_joystick"),
            ("frozen", "frozen_state"),
            ("joystick_estop", "emergency_stop"),
            ("nan_joint", "state_not_finite"),
            ("nan_quat", "state_not_finite"),
            ("nan_stick", "state_not_finite"),
            ("inf_velocity", "state_not_finite"),
            ("quat_zero", "quaternion"),
            ("quat_not_unit", "quaternion"),
            ("joint_out_of_range", "joint_position"),
            ("joint_velocity_spike", "joint_velocity"),
            ("torque_spike", "joint_torque"),
            ("tilt", "tilt"),
            ("second_deployer", "second_deployer"),
        ],
    )
    def test_damping_follows_and_goes_on(self, name: str, struck: str, since: str) -> None:
        state = {"stand": State.STAND, "run": State.RUN}[since]
        its = before(state, QUICK, PlannedFault(name, 0.5, since))  # type: ignore[arg-type]
        moments = until(its, State.DAMP, 12.0)
        began = its.rig.fault_began
        assert began is not None
        assert its.controller.fault is not None
        assert its.controller.fault.name == struck
        safety = its.controller.settings.safety
        allowed = {"no_joystick": safety.joystick_s, "frozen_state": safety.frozen_s, "joint_torque": safety.torque_s}
        if name != "tilt":  # which takes the time that the robot takes to fall
            assert moments[-1].time - began <= allowed.get(struck, safety.stale_s) + 2.0 / TICK_HZ + 1e-9
        after = its.run(1.0)
        assert states(after) == [State.DAMP]
        check_limits(its, [*moments, *after])

    @pytest.mark.parametrize(
        ("request_", "struck"),
        [
            (Request.STOP, "stop_requested"),
            (Request.RECEIVER_DEAD, "receiver_dead"),
            (Request.OVERRUN, "overrun"),
            (Request.SECOND_DEPLOYER, "second_deployer"),
            (Request.WATCHDOG, "watchdog"),
        ],
    )
    def test_requests_from_inside(self, request_: Request, struck: str) -> None:
        its = before(State.STAND, QUICK)
        until(its, State.STAND, 2.0)
        its.requests = request_
        (moment,) = its.run(1.0 / TICK_HZ)
        assert moment.tick.state is State.DAMP
        assert its.controller.fault is not None
        assert its.controller.fault.name == struck

    def test_a_policy_that_fails_or_gives_nan(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def fails(*_: object) -> None:
            raise RuntimeError("broken")

        for act in (fails, lambda self, *_: np.full((1, 12), np.nan)):
            its = before(State.RUN, QUICK)
            until(its, State.RUN, 2.0)
            with monkeypatch.context() as patch:
                patch.setattr(PolicyDriver, "act", act)
                moments = until(its, State.DAMP, 0.1)
            assert len(moments) <= 4
            assert its.controller.fault is not None
            assert its.controller.fault.name == "policy_failed"
            check_limits(its, moments)

    def test_a_push_a_payload_and_stray_messages_are_no_faults(self) -> None:
        for name in ("wrong_type", "payload", "dropouts"):
            its = before(State.RUN, QUICK, PlannedFault(name, 0.5, "run"))
            moments = [*until(its, State.RUN, 2.0), *its.run(3.0)]
            assert states(moments)[-1] is State.RUN, its.controller.fault
            check_limits(its, moments)

    def test_passive_only_by_the_operator(self) -> None:
        its = before(State.STAND, QUICK, PlannedFault("nan_joint", 0.2, "stand", lasts=0.05))
        until(its, State.DAMP, 3.0)
        assert states(its.run(3.0)) == [State.DAMP]  # the fault is over, and still it damps
        its.requests = Request.STOP | Request.LEAVE
        assert states(its.run(0.01))[-1] is State.PASSIVE

    def test_every_fault_of_the_table_can_be_described(self) -> None:
        fields = vars(Settings().safety)
        for kind in FAULTS.values():
            assert "{" not in kind.limit.format(**fields)


class TestCommands:
    def test_velocity_goes_no_faster_than_training_changes_it_and_stays_in_its_range(self) -> None:
        its = world("run", settings=replace(QUICK, joystick=JoystickConfig(max_speed=5.0)))
        until(its, State.RUN, 9.0)
        its.rig.person.message = lambda seen: _stick(1.0)  # type: ignore[method-assign]
        moments = its.run(2.5)
        speed = np.array([moment.tick.velocity_command[0] for moment in moments])
        meta = shipped().metadata
        low, high = meta.command_range["velocity_x"]
        shortest = meta.training["config"]["env"]["commands"]["velocity_again_s"][0]
        # the policy takes over a velocity with every action, and as much as the stick moved since the last one
        ticks = round(meta.control_dt * TICK_HZ)
        assert np.diff(speed).max() <= (high - low) / shortest * 0.006 * ticks + 1e-12
        assert speed.max() == high
        assert all((moment.tick.velocity_command[1:] == 0.0).all() for moment in moments)  # it learned no other

    def test_a_gait_of_another_class_is_refused(self) -> None:
        settings = Settings(joystick=JoystickConfig(buttons=Buttons(A="pronk")))
        with pytest.raises(InvalidValue, match="pronk"):
            Controller(shipped(), settings)

    def test_the_mirror_image_of_a_gait_takes_the_other_lead(self) -> None:
        for name in PAPER_GAITS:
            gait, image = gait_by_name(name), gait_by_name(f"{name}_mirrored")
            left, right = gait.by_leg(), image.by_leg()
            assert [left["LH"], left["LF"]] == [right["RH"], right["RF"]]


def _stick(forward: float) -> rc_command_lcmt:
    message = rc_command_lcmt()
    message.left_stick = [0.0, forward]
    return message


def test_a_dry_run_asks_nothing_of_the_robot() -> None:
    its = world("run", dry=True)
    limp = Targets(np.zeros(12), np.zeros(12), np.zeros(12)).message(1, 2)
    its.rig.receive = lambda now, message: its.rig.robot.command(limp)  # type: ignore[method-assign]
    joystick = rc_command_lcmt()
    its.rig.person.message = lambda seen: joystick  # type: ignore[method-assign]
    its.run(1.0)
    joystick.right_upper_switch = 1
    its.run(0.1)
    joystick.right_upper_switch = 0
    its.run(STANDS_AFTER)
    joystick.right_upper_switch = 1
    assert states(its.run(0.1))[-1] is State.RUN


def test_tilt_is_the_angle_of_a_known_rotation() -> None:
    for angle in (0.0, 0.3, 1.2, 3.0):
        for axis in (1, 2):
            quat = np.array([np.cos(angle / 2), 0.0, 0.0, 0.0])
            quat[axis] = np.sin(angle / 2)
            assert tilt(Imu(quat, np.zeros(3), np.zeros(3), np.zeros(4))) == pytest.approx(angle)


def test_before_anything_has_arrived_it_is_passive_and_says_why() -> None:
    controller = Controller(shipped(), Settings())
    tick = controller.tick(1.0, Inputs(None, None, None))
    assert tick.state is State.PASSIVE
    assert tick.targets is None
    assert tick.fault is not None
    assert tick.fault.name == "no_joint_state"
    held = Received(_stick(0.0), 1.0, 1)
    assert controller.tick(1.005, Inputs(None, None, held)).state is State.PASSIVE
