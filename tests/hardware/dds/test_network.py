"""What is said of an interface, a domain or a cyclonedds that will not do."""

from __future__ import annotations

import pytest

import hardware.dds.version
from hardware.dds.network import check_domain, configuration
from hardware.dds.version import TESTED, check_version
from symdyn.errors import InvalidValue, ResourceProblem


def test_an_interface_that_is_not_there_is_named_with_those_that_are():
    with pytest.raises(InvalidValue, match=r"'eth77'.*lo \(127\.0\.0\.1\)"):
        configuration("eth77")


def test_loopback_asks_its_own_computer_and_nobody_else():
    config = configuration("lo")
    assert config is not None
    assert 'name="lo"' in config and "<AllowMulticast>false<" in config and 'address="localhost"' in config


def test_without_an_interface_the_choice_is_left_to_cyclonedds():
    assert configuration(None) is None


@pytest.mark.parametrize("domain", [-1, 233])
def test_a_domain_that_dds_does_not_have_is_refused(domain):
    with pytest.raises(InvalidValue, match="--domain"):
        check_domain(domain)


@pytest.mark.parametrize("version", ["0.10.2", "0.10.5", "11.0.2"])
def test_a_version_that_was_not_tested_is_refused_with_the_command_that_helps(monkeypatch, version):
    monkeypatch.setattr(hardware.dds.version, "version", lambda name: version)
    with pytest.raises(ResourceProblem, match=rf"{version} was not tested.*cyclonedds=={TESTED[-1]}"):
        check_version()


def test_the_version_that_is_installed_was_tested():
    check_version()
