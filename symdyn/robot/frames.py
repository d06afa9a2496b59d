"""Rotations between the world (w), body (b) and heading (h) frames, on arrays of any array-API namespace.

Quaternions are (w, x, y, z) of the body in the world. The heading frame is the world turned about the vertical by the
body's yaw: its x axis points where the robot heads, its z axis up.
"""

from __future__ import annotations

from array_api_compat import array_namespace

from symdyn.arrays import Array


def rotate_inverse(quat_w: Array, vector_w: Array) -> Array:
    """A world vector in the body frame, R(q)^T v.

    Args:
        quat_w: (..., 4).
        vector_w: (..., 3).

    Returns:
        (..., 3).
    """
    xp = array_namespace(quat_w, vector_w)
    w, x, y, z = (quat_w[..., i] for i in range(4))
    a, b, c = (vector_w[..., i] for i in range(3))
    # t = 2 v x u (u the vector part): R^T v = v + w t - u x t ... written out with u x v
    tx, ty, tz = 2.0 * (b * z - c * y), 2.0 * (c * x - a * z), 2.0 * (a * y - b * x)
    return xp.stack(
        [a + w * tx + (ty * z - tz * y), b + w * ty + (tz * x - tx * z), c + w * tz + (tx * y - ty * x)], axis=-1
    )


def projected_gravity(quat_w: Array) -> Array:
    """Unit vector of gravity in the body frame, (..., 3), from (..., 4)."""
    xp = array_namespace(quat_w)
    return xp.stack(gravity_components(*(quat_w[..., i] for i in range(4))), axis=-1)


def gravity_components(w: Array, x: Array, y: Array, z: Array) -> tuple[Array, Array, Array]:
    """x, y, z of :func:`projected_gravity`, from the quaternion's numbers; for one robot, floats are the fastest."""
    return -2.0 * (x * z - w * y), -2.0 * (y * z + w * x), 2.0 * (x * x + y * y) - 1.0


def yaw(quat_w: Array) -> Array:
    """Heading angle, rad, (...,), from (..., 4)."""
    xp = array_namespace(quat_w)
    w, x, y, z = (quat_w[..., i] for i in range(4))
    return xp.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def to_heading(quat_w: Array, vector_w: Array) -> Array:
    """A world vector in the heading frame, (..., 3)."""
    xp = array_namespace(quat_w, vector_w)
    angle = yaw(quat_w)
    cos, sin = xp.cos(angle), xp.sin(angle)
    x, y = vector_w[..., 0], vector_w[..., 1]
    return xp.stack([cos * x + sin * y, cos * y - sin * x, vector_w[..., 2]], axis=-1)
