"""The reward of the paper: Table II and the symmetry terms of section III-D; and three terms that are not in it.

Every term is a pure function of tensors to (N,), at most zero and bounded by its weight; weights and shapes stand in
:class:`rl.task.settings.RewardConfig`. Velocities are those of the heading frame (symdyn.robot.frames): forward,
lateral, and the yaw rate.
"""

from __future__ import annotations

import numpy as np
import torch

from symdyn.gait.symmetry import PAIRS, pair_joint_signs, pairs_in_phase
from symdyn.robot.legs import JOINTS, LEG_JOINTS, LEGS

_HIPS = [JOINTS.index(f"{leg}_hip") for leg in LEGS]
_FIRST, _SECOND = (list(side) for side in zip(*PAIRS, strict=True))


def saturating(amount: torch.Tensor, rate: float) -> torch.Tensor:
    """1 - exp(-rate * amount): the shape that every term shares. In [0, 1) for amount >= 0."""
    return -torch.expm1(-rate * amount)


def velocity_error(actual: torch.Tensor, command: torch.Tensor, rate: float) -> torch.Tensor:
    """Tracking of one velocity. (N,), (N,) -> (N,)."""
    return -saturating((actual - command).abs(), rate)


def base_height(height: torch.Tensor, band: tuple[float, float], rate: float) -> torch.Tensor:
    """d_h of the paper: distance of the trunk from its band. (N,) m -> (N,)."""
    low, high = band
    return -saturating((low - height).clamp(min=0.0) + (height - high).clamp(min=0.0), rate)


def torque_change(torque: torch.Tensor, previous: torch.Tensor, rate: float) -> torch.Tensor:
    """1-norm of the change of joint torques over a control step. (N, 12) N m -> (N,)."""
    return -saturating((torque - previous).abs().sum(dim=1), rate)


def hip_action(action: torch.Tensor, rate: float) -> torch.Tensor:
    """Softmax-weighted magnitude of the hip actions. (N, 12) -> (N,)."""
    magnitude = action[:, _HIPS].abs()
    return -saturating((torch.softmax(magnitude, dim=1) * magnitude).sum(dim=1), rate)


def clearance(
    sole_height: torch.Tensor, swing: torch.Tensor, progress: torch.Tensor, wanted: float, rate: float
) -> torch.Tensor:
    """c_foot of the paper: shortfall of the height of the swinging feet, weighted by w(s) = (1 + sin(pi s)) / 2.

    The paper writes I_swing(phi_i) outside a sum over i; here it stands inside, the only reading with one c_foot.

    Args:
        sole_height: (N, 4) lowest point of each foot, m.
        swing: (N, 4) bool, commanded.
        progress: (N, 4) s_i in [0, 1].
        wanted: m.
        rate: per m.
    """
    weight = 0.5 * (1.0 + torch.sin(np.pi * progress))
    shortfall = swing * weight * (wanted - sole_height).clamp(min=0.0)
    return -saturating(shortfall.sum(dim=1), rate)


def temporal(
    force: torch.Tensor, speed: torch.Tensor, expected_swing: torch.Tensor, force_rate: float, speed_rate: float
) -> torch.Tensor:
    """R_tem: force on feet that should swing, speed of feet that should stand; summed over legs.

    Args:
        force: (N, 4) magnitude of the ground reaction force, N.
        speed: (N, 4) of the feet, m/s.
        expected_swing: (N, 4) E[I_swing].
        force_rate: per N.
        speed_rate: per m/s.
    """
    swing = expected_swing * saturating(force, force_rate)
    stance = (1.0 - expected_swing) * saturating(speed, speed_rate)
    return -(swing + stance).sum(dim=1)


def pair_difference(joint_pos: torch.Tensor, offsets: torch.Tensor) -> torch.Tensor:
    """d(G_sigma) of the paper: summed joint differences of legs that share an offset, rad. (N, 12), (N, 4) -> (N,).

    Mirror images are compared for legs of opposite sides: symdyn.gait.symmetry.pair_joint_signs.
    """
    q = joint_pos.view(-1, len(LEGS), len(LEG_JOINTS))
    signs = torch.as_tensor(pair_joint_signs(), dtype=q.dtype, device=q.device)
    differences = (q[:, _FIRST] - signs * q[:, _SECOND]).abs().sum(dim=2)
    return (differences * pairs_in_phase(offsets)).sum(dim=1)


def morphological(joint_pos: torch.Tensor, offsets: torch.Tensor, rate: float) -> torch.Tensor:
    """R_mor: :func:`pair_difference`, saturated. (N, 12), (N, 4) -> (N,)."""
    return -saturating(pair_difference(joint_pos, offsets), rate)


def joint_speed(joint_vel: torch.Tensor, free: torch.Tensor, rate: float) -> torch.Tensor:
    """Summed joint speed beyond what is free, (12,) rad/s. (N, 12) -> (N,)."""
    return -saturating((joint_vel.abs() - free).clamp(min=0.0).sum(dim=1), rate)


def stance(joint_pos_rel: torch.Tensor, standing: torch.Tensor, rate: float) -> torch.Tensor:
    """Summed deviation from the nominal stance of robots that are told to stand. (N, 12), (N,) -> (N,)."""
    return -saturating(joint_pos_rel.abs().sum(dim=1), rate) * standing


def total(terms: dict[str, torch.Tensor], exp_share: float, softness: float = 0.0) -> torch.Tensor:
    """The reward from the weighted terms, (N,): max(0, 1 + sum), softened; exp(sum); or their mixture."""
    penalty = torch.stack(list(terms.values())).sum(dim=0)
    if softness > 0.0:
        clipped = softness * torch.nn.functional.softplus((1.0 + penalty) / softness)
    else:
        clipped = (1.0 + penalty).clamp(min=0.0)
    return clipped if exp_share == 0.0 else torch.lerp(clipped, torch.exp(penalty), exp_share)
