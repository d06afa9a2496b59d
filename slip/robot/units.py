"""From a robot in SI units to the dimensionless model and back.

**The unit of length is the torso length D**, hind hip to front hip. The model leaves no choice: its hips stand at -l_b
and 1 - l_b, so that its torso is one unit long whatever the robot. The leg is then l = leg length / D units long, which
for the Go2 is 1.034. With the robot's mass as the unit of mass and gravity as that of acceleration:

    k = K D / (m g),   J = I / (m D^2),   k_s = (omega l)^2 D / g   (the model swings with sqrt(k_s) / l)

**The timing curves use the leg**: v* = v / sqrt(g l_leg), T* = T / sqrt(l_leg / g). A speed or a period of the model
becomes starred by the same factor, v* = v_model / sqrt(l) and T* = T_model / sqrt(l); a duty factor is what it is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Literal

from slip.model.parameters import SlipParameters
from slip.robot.body import RobotBody
from symdyn.errors import InvalidValue
from symdyn.gait.timing import GRAVITY

Swing = Literal["gains", "pendulum"]
"""What swings the legs: the joints' position gain, or gravity alone."""


@dataclass(frozen=True)
class DimensionalSlip:
    """The model in SI units: what :class:`slip.model.parameters.SlipParameters` is for a given robot.

    Attributes:
        mass: kg.
        torso_length: D, hind hip to front hip, m.
        leg_length: rest length of a leg, m.
        leg_stiffness: K, mean of hind and front, N/m.
        stiffness_ratio: hind over front leg stiffness.
        swing_frequency: omega, of a leg about its hip in flight, rad/s.
        pitch_inertia: I, about the centre of mass, kg m^2.
        hind_distance: from the hind hip to the centre of mass, as a fraction of D.
        resting_angle: of a leg that swings out, from the torso's normal, positive forwards, rad.
        gravity: m/s^2.

    Raises:
        InvalidValue: if a length, mass, stiffness, frequency or inertia is not positive and finite.
    """

    mass: float
    torso_length: float
    leg_length: float
    leg_stiffness: float
    stiffness_ratio: float
    swing_frequency: float
    pitch_inertia: float
    hind_distance: float
    resting_angle: float = 0.0
    gravity: float = GRAVITY

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name != "resting_angle" and not (math.isfinite(value) and value > 0.0):
                raise InvalidValue(field.name, value, "a finite number > 0")

    @classmethod
    def of_body(
        cls, body: RobotBody, leg_stiffness: float | None = None, swing: Swing = "gains", resting_angle: float = 0.0
    ) -> DimensionalSlip:
        """The spring-loaded model of a robot.

        Args:
            body: the robot.
            leg_stiffness: mean of hind and front, N/m; that of the gains if left out.
            swing: what swings the legs.
            resting_angle: rad. Zero by default: where the legs lean in the nominal stance is the controller's choice,
                and legs that lean in opposite directions (ANYmal) have no common angle.

        Raises:
            InvalidValue: if ``swing`` is neither or the given stiffness is not positive.
        """
        frequencies = {"gains": body.swing_frequency, "pendulum": body.pendulum_frequency}
        if swing not in frequencies:
            raise InvalidValue("swing", swing, f"one of {', '.join(frequencies)}")
        return cls(
            mass=body.mass,
            torso_length=body.torso_length,
            leg_length=body.leg_length,
            leg_stiffness=body.mean_stiffness if leg_stiffness is None else leg_stiffness,
            stiffness_ratio=body.stiffness_ratio,
            swing_frequency=frequencies[swing],
            pitch_inertia=body.pitch_inertia,
            hind_distance=body.hind_distance,
            resting_angle=resting_angle,
        )

    @classmethod
    def of_parameters(
        cls, parameters: SlipParameters, mass: float, torso_length: float, gravity: float = GRAVITY
    ) -> DimensionalSlip:
        """What the parameters mean for a robot of this mass (kg) and torso length (m). Raises InvalidValue."""
        length = parameters.rest_length
        return cls(
            mass=mass,
            torso_length=torso_length,
            leg_length=length * torso_length,
            leg_stiffness=parameters.stiffness * mass * gravity / torso_length,
            stiffness_ratio=parameters.stiffness_ratio,
            swing_frequency=math.sqrt(parameters.swing_stiffness * gravity / torso_length) / length,
            pitch_inertia=parameters.pitch_inertia * mass * torso_length**2,
            hind_distance=parameters.hind_distance,
            resting_angle=parameters.resting_angle,
            gravity=gravity,
        )

    def parameters(self) -> SlipParameters:
        """The dimensionless parameters. Raises InvalidValue."""
        length, gravity = self.torso_length, self.gravity
        rest_length = self.leg_length / length
        return SlipParameters(
            stiffness=self.leg_stiffness * length / (self.mass * gravity),
            swing_stiffness=(self.swing_frequency * rest_length) ** 2 * length / gravity,
            pitch_inertia=self.pitch_inertia / (self.mass * length**2),
            rest_length=rest_length,
            resting_angle=self.resting_angle,
            hind_distance=self.hind_distance,
            stiffness_ratio=self.stiffness_ratio,
        )

    @property
    def units(self) -> Units:
        """Of the dimensionless model."""
        return Units(self.mass, self.torso_length, self.gravity)


@dataclass(frozen=True)
class Units:
    """What one unit of the dimensionless model is in SI: multiply to get SI, divide to get the model's number.

    Attributes:
        mass: kg.
        length: m, the torso length.
        acceleration: m/s^2, gravity.
    """

    mass: float
    length: float
    acceleration: float = GRAVITY

    @property
    def time(self) -> float:
        """sqrt(D / g), s."""
        return math.sqrt(self.length / self.acceleration)

    @property
    def speed(self) -> float:
        """sqrt(g D), m/s."""
        return math.sqrt(self.acceleration * self.length)

    @property
    def force(self) -> float:
        """m g, N."""
        return self.mass * self.acceleration

    @property
    def energy(self) -> float:
        """m g D, J."""
        return self.force * self.length


def slip_parameters(
    body: RobotBody, leg_stiffness: float | None = None, swing: Swing = "gains", resting_angle: float = 0.0
) -> SlipParameters:
    """Dimensionless parameters of a robot: those of :meth:`DimensionalSlip.of_body`, whose arguments these are."""
    return DimensionalSlip.of_body(body, leg_stiffness, swing, resting_angle).parameters()


def starred(speed_or_period: float, parameters: SlipParameters) -> float:
    """A speed or stride period of the model in the timing curves' units, v* or T* (they scale alike).

    Args:
        speed_or_period: in the model's units.
        parameters: of the model.
    """
    return speed_or_period / math.sqrt(parameters.rest_length)


def unstarred(speed_or_period: float, parameters: SlipParameters) -> float:
    """The inverse of :func:`starred`: a v* or T* of the timing curves in the model's units."""
    return speed_or_period * math.sqrt(parameters.rest_length)
