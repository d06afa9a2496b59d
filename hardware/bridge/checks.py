"""What must be so before the motors are told anything: a robot that answers, and nobody else who commands it."""

from __future__ import annotations

import logging
import time
from uuid import UUID

from hardware.dds.codec import BadMessage
from hardware.dds.messages import LOW_STATE_CODEC
from hardware.dds.motion_switcher import MotionSwitcher
from hardware.dds.network import ROBOT_DOMAIN, SIMULATOR_DOMAIN, named
from hardware.dds.node import LOW_CMD, LOW_STATE, Node, Publisher, Reader, Writer
from hardware.dds.types import LowState
from hardware.wire.channels import JOINTS, TARGETS
from hardware.wire.link import Link
from symdyn.errors import ResourceProblem

_ANSWER_S = 5.0
_LOOK_ELSEWHERE_S = 1.5
_LISTEN_S = 0.5
_POLL_S = 0.02
_ROBOT = "192.168.123.161"
_log = logging.getLogger(__name__)


def await_robot(node: Node, states: Reader) -> None:
    """Until a LowState with the right checksum has come.

    Raises:
        ResourceProblem: if none comes; says what was found instead, and what helps.
    """
    until, wrong = time.monotonic() + _ANSWER_S, 0
    while time.monotonic() < until:
        states.wait(_POLL_S)
        for sample in states.take():
            try:
                if LOW_STATE_CODEC.crc_fits(LOW_STATE_CODEC.decode(sample.data)):
                    _one_robot(node)
                    return
            except BadMessage:
                pass
            wrong += 1
    raise ResourceProblem(_why_silent(node, wrong))


def await_listener(commands: Writer) -> None:
    """Until somebody takes LowCmds. Raises ResourceProblem."""
    until = time.monotonic() + _ANSWER_S
    while time.monotonic() < until:
        if commands.readers:
            return
        time.sleep(_POLL_S)
    raise ResourceProblem(
        f"The robot publishes its state, but nothing reads commands on {LOW_CMD}. Is low-level control open (Go2 EDU)?"
    )


def release_service(node: Node) -> None:
    """Release the robot's own controller and see that it is off. Raises ResourceProblem."""
    name = MotionSwitcher(node).release()
    _log.info("No motion service is active%s.", f" any more; {name!r} was" if name else "")


def refuse_other_writers(node: Node, commands: Reader) -> None:
    """Listen for somebody else who commands the motors. Raises ResourceProblem."""
    commands.take()
    time.sleep(_LISTEN_S)
    taken = commands.take()
    if taken:
        who = who_wrote(node, commands.writer(taken[-1].handle))
        raise ResourceProblem(
            f"Another program commands the motors on {LOW_CMD}: {who}. End it first: two controllers would fight."
        )
    for one in node.publishers(LOW_CMD):
        if one.key not in node.own_writers:
            _log.warning("%s could command the motors on %s, but sends nothing now.", one.where, LOW_CMD)


def refuse_other_bridge(url: str) -> None:
    """Listen for another bridge, or a deployer that runs already. Raises ResourceProblem."""
    link = Link(url, [JOINTS, TARGETS])
    link.start()
    time.sleep(_LISTEN_S)
    link.close()
    if link.latest(JOINTS) is not None:
        raise ResourceProblem(
            f"Another bridge or a symdyn robot-sim already publishes at {url}. End it, or choose another --url."
        )
    if link.latest(TARGETS) is not None:
        raise ResourceProblem(f"A deployer already sends targets at {url}. End it, and start the bridge first.")


def who_wrote(node: Node, key: UUID | None) -> str:
    """The process of a writer of LowCmd in words."""
    return next((one.where for one in node.publishers(LOW_CMD) if one.key == key), "an unknown process")


def _one_robot(node: Node) -> None:
    robots = node.publishers(LOW_STATE)
    if len(robots) > 1:
        raise ResourceProblem(
            f"{len(robots)} programs publish as a robot on {LOW_STATE}: {_listed(robots)}. End all but one, or name "
            "another --interface or --domain."
        )


def _why_silent(node: Node, wrong: int) -> str:
    where = f"{named(node.interface)}, DDS domain {node.domain}"
    if wrong:
        return (
            f"{wrong} messages on {LOW_STATE} ({where}) came with a wrong checksum or length, and none with a right "
            "one: this is no Go2, or its firmware has another layout."
        )
    robots = node.publishers(LOW_STATE)
    others = [one for one in robots if not one.known_type]
    if others:
        return (
            f"{_listed(others)} announces {LOW_STATE} ({where}) with another type than a Go2's, so that no data pass. "
            "It is another robot, or a program with Unitree's SDK on cyclonedds 11, which must not run beside a robot."
        )
    if robots:
        return (
            f"{_listed(robots)} announces {LOW_STATE} ({where}), but nothing comes. A firewall, or another interface "
            "with the same network? Look for UDP from its address: sudo tcpdump -n udp"
        )
    elsewhere = _elsewhere(node)
    if elsewhere is not None:
        return f"No robot answers on {where}. One does on domain {elsewhere}: --domain {elsewhere}"
    found = node.participants()
    told = f"{found} other DDS programs are there, but no robot" if found else "nobody is there at all"
    return (
        f"No robot answers on {where}: {told}. Is it switched on, and the cable in? It must answer to: ping {_ROBOT} "
        "(this computer as 192.168.123.222/24). If it does, its multicast does not come through: name the cable's "
        "--interface, and let no firewall stop UDP to 239.255.0.1."
    )


def _elsewhere(node: Node) -> int | None:
    for domain in (ROBOT_DOMAIN, SIMULATOR_DOMAIN):
        if domain != node.domain:
            other = Node(node.interface, domain)
            other.topic(LOW_STATE, LowState)
            until = time.monotonic() + _LOOK_ELSEWHERE_S
            while time.monotonic() < until:
                if other.publishers(LOW_STATE):
                    return domain
                time.sleep(_POLL_S)
    return None


def _listed(publishers: list[Publisher]) -> str:
    return ", ".join(one.where for one in publishers)
