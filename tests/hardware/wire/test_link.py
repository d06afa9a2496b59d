"""Links: within one process (memq) for what they do with messages, over real multicast for the rest."""

from __future__ import annotations

import gc
import shutil
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from hardware.wire import clock
from hardware.wire.channels import DEFAULT_URL, IMU, JOINTS, JOYSTICK, TARGETS, WrongMessage
from hardware.wire.link import Link, check_url
from hardware.wire.messages import leg_control_data_lcmt, pd_tau_targets_lcmt, rc_command_lcmt, state_estimator_lcmt
from symdyn.errors import InvalidValue, ResourceProblem
from tests.hardware.lcm_urls import multicast_url


@contextmanager
def running(url: str, *channels: str, on_message=None) -> Iterator[Link]:
    link = Link(url, channels, on_message)
    link.start()
    try:
        yield link
    finally:
        link.close()


def wait_for(condition, seconds: float = 10.0) -> bool:
    """Whether a condition came true; how long that takes is not judged."""
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.002)
    return condition()


def numbered(number: int) -> pd_tau_targets_lcmt:
    message = pd_tau_targets_lcmt()
    message.id = number
    return message


class TestTaking:
    def test_the_latest_message_is_at_hand_with_arrival_and_number(self):
        with running("memq://", TARGETS, JOINTS) as link:
            assert link.latest(TARGETS) is None
            before = clock.now()
            for number in range(1, 4):
                link.send(TARGETS, numbered(number))
            assert wait_for(lambda: (got := link.latest(TARGETS)) is not None and got.number == 3)
            received = link.latest(TARGETS)
            assert received is not None and received.message.id == 3
            assert before <= received.arrival <= clock.now()
            assert link.latest(JOINTS) is None

    def test_every_message_is_reported_in_order_from_the_receiving_thread(self):
        heard = []
        with running(
            "memq://", TARGETS, on_message=lambda *what: heard.append((*what, threading.current_thread().name))
        ) as link:
            sent = [link.send(TARGETS, numbered(number)) for number in range(50)]
            assert wait_for(lambda: len(heard) == 50)
            assert link.receiving
        assert [data for _, data, _, _, _ in heard] == sent
        assert [number for _, _, _, number, _ in heard] == list(range(1, 51))
        assert {(channel, thread) for channel, _, _, _, thread in heard} == {(TARGETS, "lcm")}
        assert not link.receiving

    def test_a_wrong_type_is_counted_and_what_was_there_stays(self):
        with running("memq://", JOINTS, IMU) as link:
            link.send(JOINTS, leg_control_data_lcmt())
            for stray in (rc_command_lcmt().encode(), b"", leg_control_data_lcmt().encode()[:-1]):
                link.send_bytes(JOINTS, stray)
            link.send_bytes(IMU, rc_command_lcmt().encode())
            assert wait_for(lambda: link.refused[JOINTS] == 3 and link.refused[IMU] == 1)
            received = link.latest(JOINTS)
            assert received is not None and received.number == 1
            assert link.latest(IMU) is None
            assert link.failure is None

    def test_a_foreign_channel_is_counted_and_ignored(self):
        with running("memq://", JOINTS) as link:
            for channel in ("another_robots_channel", f"{JOINTS}_2", "leg_control", "x"):
                link.send_bytes(channel, b"anything")
            # of this protocol, but not asked for
            link.send(JOYSTICK, rc_command_lcmt())
            link.send(JOINTS, leg_control_data_lcmt())
            assert wait_for(lambda: link.latest(JOINTS) is not None)
            assert link.foreign == 4
            assert not link.refused

    def test_what_must_not_be_sent_is_not(self):
        with running("memq://", TARGETS) as link:
            bad = numbered(1)
            bad.kp[0] = float("nan")
            for message in (bad, rc_command_lcmt()):
                with pytest.raises(WrongMessage):
                    link.send(TARGETS, message)
            link.send(TARGETS, numbered(2))
            assert wait_for(lambda: link.latest(TARGETS) is not None)
            received = link.latest(TARGETS)
            assert received is not None and (received.number, received.message.id) == (1, 2)

    def test_a_thread_that_dies_says_so(self):
        def fail(*_):
            raise RuntimeError("on purpose")

        with running("memq://", TARGETS, on_message=fail) as link:
            link.send(TARGETS, numbered(1))
            assert wait_for(lambda: not link.receiving)
            assert "on purpose" in str(link.failure)

    def test_a_link_that_was_never_started_closes(self):
        Link("memq://", [JOINTS]).close()


class TestMulticast:
    def test_closed_links_leave_no_open_files(self):
        def opened_and_closed(times: int) -> int:
            for _ in range(times):
                with running(multicast_url(), JOINTS):
                    pass
            gc.collect()
            return len(list(Path("/proc/self/fd").iterdir()))

        before = opened_and_closed(1)
        assert opened_and_closed(10) <= before + 2  # not several of each

    def test_two_links_hear_each_other(self):
        url = multicast_url()
        with running(url, TARGETS) as robot, running(url, JOINTS, IMU, JOYSTICK) as deployer:
            state = leg_control_data_lcmt()
            state.q[3] = 0.5
            deployer.send(TARGETS, numbered(9))
            robot.send(JOINTS, state)
            robot.send(IMU, state_estimator_lcmt())
            robot.send(JOYSTICK, rc_command_lcmt())
            assert wait_for(lambda: None not in [deployer.latest(c) for c in (JOINTS, IMU, JOYSTICK)])
            assert wait_for(lambda: robot.latest(TARGETS) is not None)
            assert robot.latest(TARGETS).message.id == 9  # type: ignore[union-attr]
            assert deployer.latest(JOINTS).message.q[3] == 0.5  # type: ignore[union-attr]
            # not even lcm's own test of the second link, which the first heard
            assert (robot.foreign, robot.refused) == (0, {})

    def test_another_port_is_not_heard(self):
        here, there = multicast_url(), multicast_url()
        with running(here, TARGETS) as a, running(there, TARGETS) as b, running(there, TARGETS) as c:
            c.send(TARGETS, numbered(1))
            assert wait_for(lambda: b.latest(TARGETS) is not None)
            assert a.latest(TARGETS) is None

    def test_a_burst_is_drained_to_the_last_message(self):
        # lcm's own queue holds 30; a receiver that is slow for a moment must not lose the newest
        url, burst = multicast_url(), 300
        slow = threading.Event()

        def hold_up(*_):
            if not slow.is_set():
                slow.set()
                time.sleep(0.2)

        with running(url, TARGETS, on_message=hold_up) as receiver, running(url) as sender:
            sender.send(TARGETS, numbered(0))
            assert slow.wait(10.0)
            for number in range(1, burst + 1):
                sender.send(TARGETS, numbered(number))
            assert wait_for(lambda: receiver.latest(TARGETS).message.id == burst)  # type: ignore[union-attr]
            assert receiver.latest(TARGETS).number == burst + 1  # type: ignore[union-attr]

    def test_a_port_that_another_program_keeps_to_itself_is_named_with_the_way_out(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as greedy:  # no SO_REUSEADDR
            greedy.bind(("", 0))
            port = greedy.getsockname()[1]
            with pytest.raises(ResourceProblem, match=rf"UDP port {port} .* another program holds it.*--url"):
                Link(f"udpm://239.255.76.67:{port}?ttl=0", [JOINTS])

    def test_a_port_that_is_shared_is_fine(self):
        url = multicast_url()
        with running(url, JOINTS), running(url, JOINTS):
            check_url(url)


@pytest.mark.skipif(shutil.which("unshare") is None, reason="no unshare, so no network namespace")
def test_no_route_for_multicast_is_named_with_the_command_that_helps():
    inside = f"from hardware.wire.link import check_url\ncheck_url({DEFAULT_URL!r})"
    alone = ["unshare", "--map-root-user", "--net"]
    if subprocess.run([*alone, "true"], capture_output=True).returncode != 0:
        pytest.skip("network namespaces are not allowed here")
    done = subprocess.run([*alone, sys.executable, "-c", inside], capture_output=True, text=True)
    assert "ResourceProblem: There is no route for multicast to 239.255.76.67" in done.stderr
    assert "sudo ip route add 224.0.0.0/4 dev lo" in done.stderr


@pytest.mark.parametrize(
    "url",
    [
        "", "udpm", "udpm://", "memq", "memq://x", "file:///etc/passwd", "tcpq://127.0.0.1:7667", "mpudpm://239.255.76.67:7667",
        "udpm://239.255.76.67", "udpm://239.255.76.67:", "udpm://239.255.76.67:0", "udpm://239.255.76.67:65536",
        "udpm://239.255.76.67:-1", "udpm://239.255.76.67:port", "udpm://239.255.76.67:7667:7668",
        "udpm://127.0.0.1:7667", "udpm://240.0.0.1:7667", "udpm://223.255.255.255:7667", "udpm://239.255.76:7667",
        "udpm://239.255.076.67:7667", "udpm://239.255.76.256:7667", "udpm://localhost:7667", "udpm://[ff02::1]:7667",
        "udpm://239.255.76.67:7667?ttl", "udpm://239.255.76.67:7667?ttl=", "udpm://239.255.76.67:7667?ttl=-1",
        "udpm://239.255.76.67:7667?ttl=256", "udpm://239.255.76.67:7667?ttl=one", "udpm://239.255.76.67:7667?ttl=0&ttl=1",
        "udpm://239.255.76.67:7667?time=0", "udpm://239.255.76.67:7667?recv_buf_size=big", "udpm://239.255.76.67:7667/",
        "UDPM://239.255.76.67:7667", "udpm://me@239.255.76.67:7667", "udpm://239.255.76.67:7667#here",
        " udpm://239.255.76.67:7667", "udpm://239.255.76.67:7667\n", "udpm://239.255.76.67 x:7667",
    ],
)  # fmt: skip
def test_a_malformed_url_is_refused_before_anything_is_opened(url):
    with pytest.raises(InvalidValue, match="The LCM URL"):
        Link(url, [JOINTS])


@pytest.mark.parametrize(
    "query", ["", "?ttl=0", "?ttl=1", "?ttl=255", "?recv_buf_size=100000", "?ttl=0&recv_buf_size=1"]
)
def test_a_sound_url_is_taken(query):
    port = multicast_url().split(":")[2].split("?")[0]
    check_url(f"udpm://239.255.76.67:{port}{query}")
