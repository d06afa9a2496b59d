"""The page about the robot says what the code does."""

from __future__ import annotations

import re
from pathlib import Path

from hardware.control import controller as controller_module
from hardware.control import health
from hardware.control.faults import FAULTS, table_rows
from hardware.control.settings import SafetyConfig
from hardware.running import deployer
from symdyn.io.markdown import table

PAGE = Path(__file__).parents[3] / "docs" / "robot.md"


def test_the_page_has_the_table_of_faults_as_the_code_has_it() -> None:
    rows = table(["fault", "raised when", "usual cause", "what to do"], table_rows(vars(SafetyConfig())))
    assert "\n".join(rows) in PAGE.read_text()


def test_every_fault_of_the_table_is_raised_somewhere_and_every_one_raised_is_in_it() -> None:
    from hardware.control import stand_up

    source = "".join(Path(m.__file__).read_text() for m in (controller_module, deployer, health, stand_up))
    raised = set(re.findall(r'Fault\(\s*"(\w+)"', source)) | set(controller_module.REQUEST_FAULTS.values())
    assert raised == set(FAULTS)
