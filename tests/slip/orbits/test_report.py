import json
import math

import numpy as np
import pytest
from rich.console import Console

from slip.cli.orbit import show
from slip.model.unknowns import UNKNOWN_NAMES
from slip.orbits.report import OrbitReport
from slip.orbits.trajectory import sample
from slip.robot.units import Units
from tests.slip.orbits.stored_orbits import FAMILIES, hop, orbit

GO2_UNITS = Units(mass=15.0, length=0.387)


@pytest.fixture(scope="module", params=("PK", "BG", "GE"))
def report(request) -> OrbitReport:
    return OrbitReport.of(orbit(request.param), request.param)


def printed(report: OrbitReport) -> str:
    console = Console(width=200, record=True, file=open("/dev/null", "w"))  # noqa: SIM115, PTH123
    show(console, report, "title")
    return console.export_text()


class TestNumbers:
    def test_json_is_strict_and_complete(self, report):
        text = json.dumps(report.as_dict(), allow_nan=False)
        read = json.loads(text)
        assert list(read["unknowns"]) == list(UNKNOWN_NAMES)
        assert np.allclose(list(read["unknowns"].values()), report.orbit.unknowns, rtol=0, atol=0)
        assert read["residual"] < 1e-10
        assert read["energy_drift"] < 1e-11
        assert read["independent_check"] < 1e-8
        assert len(read["multipliers"]) == 11
        assert len(read["symmetry"]["elements"]) == 16

    def test_stability_agrees_with_the_multipliers(self, report):
        largest = max(math.hypot(*value) for value in report.as_dict()["multipliers"])
        assert report.stable == (largest <= 1.0 + 1e-6)
        assert report.stability().startswith("Stable" if report.stable else "Unstable")

    def test_si(self):
        plain, scaled = (OrbitReport.of(orbit("BG"), "BG", units) for units in (None, GO2_UNITS))
        rows = {name: (value, si) for name, value, si in scaled.numbers()}
        assert rows["speed at the apex"][1] == f"{orbit('BG').apex_speed * GO2_UNITS.speed:.5g} m/s"
        assert rows["stride period T"][1] == f"{orbit('BG').period * GO2_UNITS.time:.5g} s"
        assert all(si == "" for _, _, si in plain.numbers())
        assert scaled.as_dict()["units"] == {"mass": 15.0, "length": 0.387, "acceleration": 9.81}

    def test_other_events_are_null_and_said(self, report):
        other = OrbitReport(report.orbit, report.family, report.multipliers, math.nan, report.symmetry, None)
        assert other.as_dict()["independent_check"] is None
        assert "found different ones" in other.check_in_words


class TestShown:
    def test_says_what_it_is(self, report):
        text = printed(report)
        assert "largest residual" in text
        assert report.symmetry.footfall_class.describe() in text
        assert ("it is a gait" in text) == report.symmetry.reversible
        assert ("it is not a gait" in text) != report.symmetry.reversible

    @pytest.mark.parametrize("family", FAMILIES)
    def test_largest_forces(self, family):
        forces = np.linalg.norm(sample(orbit(family), 400).force_w, axis=-1).max(axis=0)
        text = printed(OrbitReport.of(orbit(family), family))
        assert all(f"{force:.4g} M g" in text for force in forces)

    def test_other_lead_and_other_direction(self):
        text = printed(OrbitReport.of(orbit("GG"), "GG"))
        assert "another lead" in text
        assert "runs the other way" in text

    def test_in_place_nothing_runs_the_other_way(self):
        report = OrbitReport.of(hop(), "PK")
        assert "runs the other way" not in printed(report)
        assert len(report.symmetry.group) == 16
