import pytest

from slip.cli.passive_model import PassiveModelArguments
from slip.model.parameters import REFERENCE, SlipParameters
from slip.robot.body import load_body
from slip.robot.units import DimensionalSlip
from symdyn.errors import InvalidValue, SymdynError, UnknownName


def test_the_literatures_by_default():
    model = PassiveModelArguments().load()
    assert model.parameters == REFERENCE
    assert model.units is None
    assert model.name == "reference"


def test_numbers_given():
    model = PassiveModelArguments(k=5.0, ks=30.0, J=1.5, rest_length=0.9, lb=0.45, kr=1.2, resting_angle=0.1).load()
    assert model.parameters == SlipParameters(5.0, 30.0, 1.5, 0.9, 0.1, 0.45, 1.2)
    assert model.name == "reference, changed"


def test_a_number_that_changes_nothing():
    assert PassiveModelArguments(k=10.0, J=2.0).load().name == "reference"


def test_a_robot_with_its_scale():
    model = PassiveModelArguments(robot="go2", lb=0.5).load()
    body = load_body("go2")
    scaled = DimensionalSlip.of_body(body)
    assert model.units == scaled.units
    assert model.units.length == pytest.approx(body.torso_length)
    assert model.parameters.stiffness == scaled.parameters().stiffness
    assert model.parameters.hind_distance == 0.5
    assert model.name == "go2, changed"


@pytest.mark.parametrize(
    ("arguments", "error", "said"),
    [
        ({"robot": "dog"}, UnknownName, "go2"),
        ({"k": 0.0}, InvalidValue, "stiffness"),
        ({"ks": float("nan")}, InvalidValue, "swing_stiffness"),
        ({"lb": 1.5}, InvalidValue, "hind_distance"),
        ({"feet": ("a", "b", "c", "d")}, InvalidValue, "--urdf"),
    ],
)
def test_bad(arguments, error, said):
    with pytest.raises(error, match=said):
        PassiveModelArguments(**arguments).load()


def test_robot_or_description_but_not_both(tmp_path):
    with pytest.raises(InvalidValue, match="--robot"):
        PassiveModelArguments(robot="go2", urdf=tmp_path / "x.urdf").load()
    with pytest.raises(SymdynError, match=r"x\.urdf"):
        PassiveModelArguments(urdf=tmp_path / "x.urdf").load()
