"""Commands that reach the motors late."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class DelayLine:
    """The last commands of N robots, and which of them acts at each physics step of a control step.

    Args:
        num_envs: N.
        width: numbers in a command.
        substeps: physics steps of a control step.

    Attributes:
        kept: (depth, N, width) commands, newest first.
    """

    def __init__(self, num_envs: int, width: int, substeps: int) -> None:
        self._substeps = substeps
        self._rows = np.arange(num_envs)
        self.kept = np.zeros((1, num_envs, width))
        self.set_delay(np.zeros(num_envs, dtype=np.int64))

    def set_delay(self, steps: NDArray[np.int64]) -> None:
        """Delay of each robot's commands in physics steps, (N,), each >= 0."""
        # at physics step s of a control step, a command given j control steps ago is s + j * substeps old
        steps_ago = -(-(steps - np.arange(self._substeps)[:, None]) // self._substeps)
        self._steps_ago = np.clip(steps_ago, 0, None)
        depth = int(self._steps_ago.max()) + 1
        oldest = np.repeat(self.kept[-1:], max(depth - len(self.kept), 0), axis=0)
        self.kept = np.concatenate([self.kept, oldest])[:depth]
        self._late = depth > 1

    def push(self, commands: Floats) -> None:
        """New commands, (N, width)."""
        if self._late:
            self.kept[1:] = self.kept[:-1]
        self.kept[0] = commands

    def fill(self, ids: NDArray[np.int64], commands: Floats) -> None:
        """Some robots have had these commands, (n, width), for ever."""
        self.kept[:, ids] = commands

    def at(self, substep: int) -> Floats:
        """The commands that act during this physics step of the control step, (N, width)."""
        return self.kept[self._steps_ago[substep], self._rows] if self._late else self.kept[0]
