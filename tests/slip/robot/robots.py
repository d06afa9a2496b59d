"""Robots from their descriptions, loaded once a process."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from slip.robot.body import load_body
from slip.robot.known import KNOWN_ROBOTS
from slip.robot.urdf import load_robot
from symdyn.robot.descriptions import robots_folder

# by hand, from the descriptions: LH, LF, RF, RH
FEET = {
    "go2": ("RL_foot", "FL_foot", "FR_foot", "RR_foot"),
    "go1": ("RL_foot", "FL_foot", "FR_foot", "RR_foot"),
    "a1": ("RL_foot", "FL_foot", "FR_foot", "RR_foot"),
    "b1": ("RL_foot", "FL_foot", "FR_foot", "RR_foot"),
    "solo12": ("HL_FOOT", "FL_FOOT", "FR_FOOT", "HR_FOOT"),
    "anymal": ("LH_FOOT", "LF_FOOT", "RF_FOOT", "RH_FOOT"),
    "anymal_b": ("LH_FOOT", "LF_FOOT", "RF_FOOT", "RH_FOOT"),
    "anymal_c": ("LH_FOOT", "LF_FOOT", "RF_FOOT", "RH_FOOT"),
    "hyq": ("lh_foot", "lf_foot", "rf_foot", "rh_foot"),
}
every_robot = pytest.mark.parametrize("name", sorted(KNOWN_ROBOTS))

load_robot_once = cache(load_robot)
load_body_once = cache(load_body)


def other_urdf(folder: str, file: str) -> Path:
    return robots_folder() / folder / file
