"""From wherever the joints are to the stance, slowly; then every joint is moved a little, to see what answers."""

from __future__ import annotations

import numpy as np

from hardware.control.faults import Fault
from hardware.control.least_jerk import least_jerk
from hardware.control.settings import SafetyConfig, StandConfig
from hardware.estimation.kinematics import LegKinematics
from hardware.estimation.leg_order import LegOrder
from hardware.wire.readings import Floats, Imu, Joints, Targets
from symdyn.robot.legs import JOINTS, LEGS

_KNEES = {f"{leg}_calf": leg for leg in LEGS}


class StandUp:
    """Targets over time, and a verdict at the end.

    Three parts: ``rise_s`` from the measured pose to the stance along a path without jerk at its ends, while the gains
    ramp up; ``settle_s`` of rest; then the target of each joint in turn goes ``wiggle`` up and back in ``wiggle_s``.

    On its feet the robot is a closed chain: the joint itself moves by a tenth to a half of the wiggle, and others with
    it. But the motor's law holds for every joint by itself, torque = kp (target - q) - kd qd, on the floor as in a
    harness. So the target that a joint obeys can be told from its state, q + (torque + kd qd) / kp; that of the wiggled
    joint must move as it was told, and no other. If state or commands come in another order than they go out, or with
    another sign, another joint answers, or none. What is exchanged in both alike shows in how the trunk tilts
    (:class:`hardware.estimation.leg_order.LegOrder`).

    Args:
        start: (12,) rad, the measured pose.
        stance: (12,) rad, where to end.
        config: times and gains.
        safety: size of the wiggle, and what counts as an answer.
        kinematics: of the robot.
    """

    def __init__(
        self, start: Floats, stance: Floats, config: StandConfig, safety: SafetyConfig, kinematics: LegKinematics
    ) -> None:
        self._start, self._stance = start.copy(), stance.copy()
        self._config, self._safety = config, safety
        self._wiggle_from = config.rise_s + config.settle_s
        self._seen: list[list[tuple[float, Floats]]] = [[] for _ in JOINTS]
        self._leg_order = LegOrder(kinematics, stance)

    @property
    def duration(self) -> float:
        """s from the start to the verdict."""
        return self._wiggle_from + len(JOINTS) * self._config.wiggle_s

    def targets(self, time: float) -> Targets:
        """Where the joints shall be ``time`` s after the start."""
        pos = self._start + least_jerk(time / self._config.rise_s) * (self._stance - self._start)
        wiggled, height = self._wiggle(time)
        if wiggled is not None:
            pos[wiggled] += height
        ramp = float(np.clip(time / self._config.ramp_s, 0.0, 1.0))
        ones = np.ones(len(JOINTS))
        return Targets(pos=pos, kp=ramp * self._config.kp * ones, kd=ramp * self._config.kd * ones)

    def observe(self, time: float, joints: Joints, imu: Imu) -> None:
        """Take note of joints and trunk ``time`` s after the start."""
        wiggled, height = self._wiggle(time)
        if wiggled is None:
            return
        obeyed = joints.pos + (joints.torque + self._config.kd * joints.vel) / self._config.kp
        self._seen[wiggled].append((height, obeyed))
        if JOINTS[wiggled] in _KNEES:
            self._leg_order.observe(_KNEES[JOINTS[wiggled]], joints, imu)

    def answers(self) -> Floats:
        """How much of each joint's wiggle each joint answered, (12, 12): [which was wiggled, which answered].

        The slope of what a joint obeyed over the height of the wiggle, by least squares.
        """
        slopes = np.zeros((len(JOINTS), len(JOINTS)))
        for wiggled, seen in enumerate(self._seen):
            if len(seen) > 2:
                height = np.array([h for h, _ in seen])
                height -= height.mean()
                slopes[wiggled] = height @ np.stack([obeyed for _, obeyed in seen]) / (height @ height)
        return slopes

    def verdict(self, joints: Joints) -> Fault | None:
        """What is wrong at the end, or None."""
        off = np.abs(joints.pos - self._stance)
        worst = int(np.argmax(off))
        if off[worst] > self._safety.stand_error:
            return Fault("not_standing", f"{JOINTS[worst]} is {off[worst]:.2f} rad off")
        answers = self.answers()
        for i, name in enumerate(JOINTS):
            own = answers[i, i]
            others = np.abs(answers[i])
            others[i] = 0.0
            loudest = int(np.argmax(others))
            if own < self._safety.wiggle_answer or others[loudest] > self._safety.wiggle_answer:
                return Fault(
                    "joint_order",
                    f"{name} answers {own:.0%} of its wiggle, {JOINTS[loudest]} {answers[i, loudest]:.0%}",
                )
        if (other := self._leg_order.other(self._safety.tilt_explained)) is not None:
            order, share = other
            named = [f"{LEGS[taken]} is {leg}" for leg, taken in zip(LEGS, order, strict=True) if LEGS[taken] != leg]
            return Fault("leg_order", f"as the trunk tilts, {', '.join(named)} ({share:.0%} explained)")
        return None

    def _wiggle(self, time: float) -> tuple[int | None, float]:
        """Which joint is wiggled, and by how much, rad."""
        number, part = divmod((time - self._wiggle_from) / self._config.wiggle_s, 1.0)
        if not 0 <= number < len(JOINTS):
            return None, 0.0
        return int(number), self._safety.wiggle * float(np.sin(np.pi * part)) ** 2
