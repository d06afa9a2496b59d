"""A robot in MuJoCo behind the protocol of the real one's bridge. Only this part of ``hardware`` imports mujoco."""
