"""``python -m benchmarks.broken_deployer DEFECT ...``: symdyn deploy, of which a part breaks at the signal SIGUSR1."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np

from hardware.cli import deploy
from hardware.cli.arguments.deploy import parse
from hardware.control.controller import Controller
from hardware.control.settings import TICK_HZ
from hardware.wire import link
from symdyn.policy.driver import PolicyDriver

_TOO_LONG_S = 2.4 / TICK_HZ


def _fails(*_: object) -> NoReturn:
    raise RuntimeError("broken on purpose")


def _no_number(driver: PolicyDriver, *_: object) -> np.ndarray:
    return np.full_like(driver.action, np.nan)


def _slow_tick(controller: Controller, *arguments: Any) -> object:
    time.sleep(_TOO_LONG_S)
    return _TICK(controller, *arguments)


def _endless_tick(*_: object) -> NoReturn:
    while True:
        pass


def _tick_that_fails_once(controller: Controller, *_: object) -> NoReturn:
    Controller.tick = _TICK
    _fails()


_TICK = Controller.tick
_DEFECTS: dict[str, tuple[object, str, Callable[..., object]]] = {
    "receiving_thread_dies": (link, "decode", _fails),
    "policy_raises": (PolicyDriver, "act", _fails),
    "policy_not_finite": (PolicyDriver, "act", _no_number),
    "ticks_too_slow": (Controller, "tick", _slow_tick),
    "controller_raises": (Controller, "tick", _tick_that_fails_once),
    "tick_never_ends": (Controller, "tick", _endless_tick),
}
"""What is replaced by what."""

DEFECTS = tuple(_DEFECTS)


def main() -> int:
    """The deployer with the defect that the first argument names."""
    holder, name, broken = _DEFECTS[sys.argv[1]]
    signal.signal(signal.SIGUSR1, lambda *_: setattr(holder, name, broken))
    return deploy.run(parse(sys.argv[2:]))


if __name__ == "__main__":
    sys.exit(main())
