"""Bytes through DDS on loopback, and who is on the wire."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import pytest
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import uint8
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic

from benchmarks.dds_ear import free_domain
from hardware.dds.messages import LOW_CMD_CODEC, LOW_STATE_CODEC, damping
from hardware.dds.motion_switcher import MotionSwitcher, SimulatedMotionSwitcher
from hardware.dds.node import LOW_CMD, LOW_STATE, Node, Reader, Writer
from hardware.dds.types import LowCmd, LowState
from symdyn.errors import ResourceProblem


@pytest.fixture(scope="module")
def node() -> Node:
    return Node("lo", free_domain())


def wait_for(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + 30.0
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


def test_bytes_come_through_as_they_were_and_the_reader_knows_from_whom(node):
    reader, writer = Reader(node, LOW_CMD, LowCmd, depth=4), Writer(node, LOW_CMD, LowCmd)
    deaf = Reader(node, LOW_CMD, LowCmd, depth=4, ignore_own=True)
    wait_for(lambda: writer.readers >= 1)
    said = [LOW_CMD_CODEC.encode(damping(kd)) for kd in (1.0, 2.0, 3.0)]
    for data in said:
        writer.write(data)
    assert reader.wait(5.0)
    taken = reader.take()
    assert [sample.data for sample in taken] == said
    assert {reader.writer(sample.handle) for sample in taken} == {writer.key}
    assert not reader.wait(0.01) and not reader.take()
    assert not deaf.take()


def test_of_more_than_it_keeps_a_reader_has_the_newest(node):
    reader, writer = Reader(node, LOW_STATE, LowState), Writer(node, LOW_STATE, LowState)
    wait_for(lambda: writer.readers >= 1)
    record = LOW_STATE_CODEC.new()
    for tick in range(5):
        record["tick"] = tick
        writer.write(LOW_STATE_CODEC.encode(record))
    (sample,) = reader.take()
    assert LOW_STATE_CODEC.decode(sample.data)["tick"] == 4


def test_a_publisher_of_another_type_is_told_from_one_of_the_robots(node):
    @dataclass
    class Other(IdlStruct, typename="unitree_go.msg.dds_.LowState_"):
        head: uint8

    ours = Writer(node, LOW_STATE, LowState)
    theirs = DataWriter(node.participant, Topic(node.participant, LOW_STATE, Other))
    found = {one.key: one for one in node.publishers(LOW_STATE)}
    assert found[ours.key].known_type
    assert not found[theirs.get_guid()].known_type
    assert "on" in found[ours.key].where


@contextmanager
def answering(switcher: SimulatedMotionSwitcher) -> Iterator[None]:
    stop = threading.Event()

    def answer() -> None:
        while not stop.wait(0.01):
            switcher.answer()

    thread = threading.Thread(target=answer)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


def test_the_motion_service_is_released_and_that_is_verified(node):
    robot = SimulatedMotionSwitcher(node, "normal")
    with answering(robot):
        switcher = MotionSwitcher(node)
        assert switcher.active() == "normal"
        assert switcher.release() == "normal"
        assert robot.service == "" and switcher.release() == ""


def test_a_service_that_stays_active_is_an_error(node):
    class Stubborn(SimulatedMotionSwitcher):
        def answer(self) -> None:
            super().answer()
            self.service = "ai"

    with answering(Stubborn(node, "ai")), pytest.raises(ResourceProblem, match="'ai' stays active"):
        MotionSwitcher(node).release()


def test_a_switcher_that_does_not_answer_is_an_error_that_says_what_a_simulator_needs(node, monkeypatch):
    monkeypatch.setattr("hardware.dds.motion_switcher._ANSWER_S", 0.05)
    with pytest.raises(ResourceProblem, match=r"no answer.*--keep-service"):
        MotionSwitcher(node).release()
