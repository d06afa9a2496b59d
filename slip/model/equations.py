"""Equations of motion of the quadrupedal SLIP, as CasADi expressions.

A planar rigid torso on four massless springy legs that swing as free oscillators (Gan et al. 2016; Ding & Gan 2024,
arXiv 2303.04857). M = 1, g = 1, torso length 1. The leg angle alpha is relative to the torso's normal, theta = alpha +
phi to the vertical, both positive when the foot is ahead of the hip. A foot on the ground is pinned, so the leg's
length is y_hip / cos(theta) and its angle follows from the torso; in the air the leg has its rest length.

States (13), see slip.model.unknowns: dx, y, dy, phi, dphi; alpha, dalpha of each leg.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca

from slip.model.unknowns import ALPHA, DALPHA, DPHI, DX, DY, FRONT, PHI, SLIP_LEGS, Y

Expression = Any  # casadi.SX; its operators are not in casadi's stubs


@dataclass(frozen=True)
class Leg:
    """What the equations need of one leg."""

    hip: Expression
    """Signed distance of the hip along the torso from the centre of mass."""
    stiffness: Expression
    alpha: Expression
    dalpha: Expression
    theta: Expression
    hip_height_w: Expression
    hip_velocity_w: tuple[Expression, Expression]
    rest_length: Expression

    @property
    def foot_height_w(self) -> Expression:
        """Height of the foot of a leg at rest length: zero at touchdown and lift-off."""
        return self.hip_height_w - self.rest_length * ca.cos(self.theta)

    @property
    def force(self) -> Expression:
        """Force along the leg if its foot is on the ground; positive pushes."""
        return self.stiffness * (self.rest_length - self.hip_height_w / ca.cos(self.theta))

    @property
    def stance_dtheta(self) -> Expression:
        """Rate of theta of a leg whose foot is pinned."""
        vx, vy = self.hip_velocity_w
        return -(ca.cos(self.theta) ** 2) * (vx + vy * ca.tan(self.theta)) / self.hip_height_w


def legs(state: Expression, parameters: Expression) -> list[Leg]:
    """The four legs, in the order of ``SLIP_LEGS``, at a state (13,) with parameters (7,)."""
    k, _, _, rest_length, _, lb, kr = ca.vertsplit(parameters)
    phi, dphi = state[PHI], state[DPHI]
    result = []
    for i in range(len(SLIP_LEGS)):
        front = i in FRONT
        hip = 1.0 - lb if front else -lb
        result.append(
            Leg(
                hip=hip,
                stiffness=2.0 * k / (1.0 + kr) * (1.0 if front else kr),
                alpha=state[ALPHA[i]],
                dalpha=state[DALPHA[i]],
                theta=state[ALPHA[i]] + phi,
                hip_height_w=state[Y] + hip * ca.sin(phi),
                hip_velocity_w=(state[DX] - hip * ca.sin(phi) * dphi, state[DY] + hip * ca.cos(phi) * dphi),
                rest_length=rest_length,
            )
        )
    return result


def vector_field(state: Expression, contact: Expression, parameters: Expression) -> Expression:
    """Rate of the state.

    Args:
        state: (13,).
        contact: (4,) in the order of ``SLIP_LEGS``, 1 where the foot is on the ground, 0 where the leg swings.
        parameters: (7,), the fields of SlipParameters.

    Returns:
        (13,).
    """
    _, ks, inertia, length, resting_angle, _, _ = ca.vertsplit(parameters)
    dphi = state[DPHI]
    all_legs = legs(state, parameters)
    force_x, force_y, torque = ca.SX(0.0), ca.SX(0.0), ca.SX(0.0)
    for on_ground, leg in zip(ca.vertsplit(contact), all_legs, strict=True):
        force = on_ground * leg.force
        force_x -= force * ca.sin(leg.theta)
        force_y += force * ca.cos(leg.theta)
        torque += force * leg.hip * ca.cos(leg.alpha)
    ddx, ddy, ddphi = force_x, force_y - 1.0, torque / inertia

    rate = [ca.SX(0.0)] * state.numel()
    rate[DX], rate[Y], rate[DY], rate[PHI], rate[DPHI] = ddx, state[DY], ddy, dphi, ddphi
    sin_phi, cos_phi = ca.sin(state[PHI]), ca.cos(state[PHI])
    for i, (on_ground, leg) in enumerate(zip(ca.vertsplit(contact), all_legs, strict=True)):
        sin, cos = ca.sin(leg.theta), ca.cos(leg.theta)
        # in the air: a point foot whose mass goes to zero, on a torsion spring of stiffness ks
        swing = -(
            ddphi * (1.0 + leg.hip * ca.sin(leg.alpha) / length)
            + (force_x * cos + force_y * sin) / length
            + ks * (leg.alpha - resting_angle) / length**2
            - leg.hip * dphi**2 * ca.cos(leg.alpha) / length
        )
        # on the ground: stance_dtheta and its derivative in time
        vx, vy = leg.hip_velocity_w
        ax = ddx - leg.hip * (sin_phi * ddphi + cos_phi * dphi**2)
        ay = ddy + leg.hip * (cos_phi * ddphi - sin_phi * dphi**2)
        dtheta = leg.stance_dtheta
        tan = ca.tan(leg.theta)
        ddtheta = 2.0 * cos * sin * dtheta * (vx + vy * tan) - cos**2 * (ax + ay * tan) - 2.0 * dtheta * vy
        ddtheta /= leg.hip_height_w
        rate[ALPHA[i]] = ca.if_else(on_ground, dtheta - dphi, leg.dalpha)
        rate[DALPHA[i]] = ca.if_else(on_ground, ddtheta - ddphi, swing)
    return ca.vertcat(*rate)


def energy(state: Expression, contact: Expression, parameters: Expression) -> Expression:
    """Kinetic, potential and elastic energy [M g torso length]; massless legs and swing springs hold none of it."""
    inertia = parameters[2]
    total = 0.5 * (state[DX] ** 2 + state[DY] ** 2 + inertia * state[DPHI] ** 2) + state[Y]
    for on_ground, leg in zip(ca.vertsplit(contact), legs(state, parameters), strict=True):
        total += on_ground * leg.force**2 / (2.0 * leg.stiffness)
    return total
