"""symdyn play as a user meets it: the command's words, and the page in a browser, down to the simulation behind it."""

from __future__ import annotations

import base64
import io
import os
import signal
import subprocess
import sys
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pytest
from PIL import Image

from rl.pretrained import policy_path
from rl.viewer.live.runner import Runner
from rl.viewer.live.simulation import BUMPS, LiveSimulation
from rl.viewer.window.controls import Controls
from rl.viewer.window.live_view import LiveView
from rl.viewer.window.page import Page
from rl.viewer.window.server import serving, url
from symdyn.gait.library import get
from symdyn.policy.file import Policy
from tests.e2e.rl.browser import open_page
from tests.hardware.lcm_urls import multicast_url


@dataclass
class Played:
    """A page in a browser, and the simulation behind it."""

    page: object
    runner: Runner
    shown: Page

    @property
    def simulation(self) -> LiveSimulation:
        return self.runner.simulation

    def until(self, true: Callable[[], bool]) -> None:
        """Wait for something that takes a moment, or minutes where others work as well."""
        for _ in range(2400):
            if true():
                return
            for failure in (self.runner.failure, self.shown.failure):
                if failure is not None:
                    raise failure
            time.sleep(0.1)
        raise AssertionError("it did not come within four minutes")

    def button(self, name: str) -> None:
        self.page.get_by_role("button", name=name, exact=True).click()

    def slide(self, label: str, value: str) -> None:
        """Type into the box beside a slider."""
        row = self.page.get_by_text(label, exact=True).locator("xpath=ancestor::div[.//input][1]")
        row.locator("input").last.fill(value)

    def report(self) -> str:
        return self.page.locator("[data-report]").inner_text()

    def strip(self) -> str:
        return self.page.locator("[data-report] svg").first.inner_html()

    def canvas(self) -> np.ndarray:
        """The three-dimensional part as it is drawn, (height, width, 3)."""
        read = """() => new Promise(done => requestAnimationFrame(() => {
            const all = [...document.querySelectorAll('canvas')].sort((a, b) => b.width - a.width);
            done(all[0].toDataURL('image/png').split(',')[1]);
        }))"""
        with Image.open(io.BytesIO(base64.b64decode(self.page.evaluate(read)))) as image:
            return np.asarray(image.convert("RGB")).astype(int)


@pytest.fixture(scope="module")
def played() -> Iterator[Played]:
    policy = Policy.load(policy_path())
    with serving("127.0.0.1", 0) as server:
        runner = Runner(LiveSimulation(policy))
        page = Page(server, runner.simulation.robot, LiveView(runner), "What you tell it")
        Controls(server, runner, "go2.onnx")
        with open_page(url("127.0.0.1", server.get_port())) as browser:
            runner.start()
            page.start()
            try:
                browser.locator("[data-report]").wait_for()
                yield Played(browser, runner, page)
            finally:
                page.close()
                runner.close()


class TestPage:
    def test_it_loads_without_errors_and_says_what_it_shows(self, played):
        text = played.page.locator("body").inner_text()
        for words in ("What you tell it", "What it does", "go2.onnx", "rotary gallop", "pronk", "real-time factor"):
            assert words in text
        assert played.page.errors == []

    def test_a_gait_button_changes_the_gait_that_runs(self, played):
        assert played.simulation.gait == get("trot")
        played.button("rotary gallop")
        played.until(lambda: played.simulation.gait == get("rotary_gallop"))
        np.testing.assert_array_equal(played.simulation.driver.offsets[0], get("rotary_gallop").theta)
        played.until(lambda: played.report().startswith("rotary gallop"))
        played.button("walk")  # one that it was not trained on
        played.until(lambda: played.simulation.gait == get("walk"))
        played.button("trot")
        played.until(lambda: played.simulation.gait == get("trot"))

    def test_a_mixture_is_run(self, played):
        played.slide("share", "0.3")
        wanted = get("trot").towards(get("bound"), 0.3)
        played.until(lambda: played.simulation.gait == wanted)
        played.until(lambda: played.report().startswith("trot + 30% bound"))
        played.button("trot")
        played.until(lambda: played.simulation.gait == get("trot"))

    def test_the_speed_is_commanded_and_reached(self, played):
        played.slide("speed [m/s]", "1")
        played.until(lambda: played.simulation.velocity == (1.0, 0.0, 0.0))

        def reached() -> bool:
            recording = played.simulation.history.last(1.0)
            return recording is not None and abs(recording.velocity_h[:, 0].mean() - 1.0) < 0.15

        played.until(reached)

    def test_a_speed_beyond_the_training_is_not_commanded(self, played):
        played.slide("speed [m/s]", "9")
        highest = played.simulation.command_range["velocity_x"][1]
        played.until(lambda: played.simulation.velocity == (highest, 0.0, 0.0))
        played.slide("speed [m/s]", "0.5")
        played.until(lambda: played.simulation.velocity == (0.5, 0.0, 0.0))

    def test_the_strips_move(self, played):
        seen = {played.strip()}
        played.until(lambda: seen.add(played.strip()) or len(seen) > 3)

    def test_pause_stops_time_and_go_on_lets_it_run(self, played):
        played.button("Pause")
        played.until(lambda: played.runner.paused)
        stopped = played.simulation.time
        played.until(lambda: "Paused." in played.report())
        assert played.simulation.time == stopped
        played.button("Go on")
        played.until(lambda: played.simulation.time > stopped + 0.5)

    def test_a_push_changes_the_velocity(self, played):
        gained = []
        push = played.simulation.push

        def watched_push(momentum_h: tuple[float, float]) -> None:
            velocity = played.simulation.physics.batch.qvel[0, :3]  # of the trunk, a view
            before = velocity.copy()
            push(momentum_h)
            gained.append((momentum_h, velocity - before))

        played.simulation.push = watched_push
        played.button("left")
        played.until(lambda: bool(gained))
        del played.simulation.push
        momentum, change = gained[0]
        assert momentum == (0.0, 8.0)
        assert np.linalg.norm(change) == pytest.approx(8.0 / played.simulation.mass, rel=1e-6)

    def test_payload_friction_and_ground(self, played):
        played.slide("payload [kg]", "1.5")
        played.slide("friction", "0.4")
        played.until(lambda: (played.simulation.world.payload, played.simulation.world.friction) == (1.5, 0.5))
        played.page.get_by_label("uneven ground").click()
        played.until(lambda: played.simulation.world.terrain == BUMPS)
        played.until(lambda: played.simulation.time > 0.2 and bool(played.shown._scene._tiles))
        played.page.get_by_label("uneven ground").click()
        played.until(lambda: played.simulation.world.terrain is None)

    def test_slow_motion(self, played):
        played.page.get_by_label("time", exact=True).click()
        played.page.get_by_text("1/4", exact=True).click()
        played.until(lambda: played.runner.speed == 0.25)
        played.page.get_by_label("time", exact=True).click()
        played.page.get_by_role("option", name="real time").click()
        played.until(lambda: played.runner.speed == 1.0)

    def test_reset_resets(self, played):
        played.until(lambda: played.simulation.time > 0.5)
        starts = []
        played.runner.ask(lambda simulation: starts.append(simulation.driver))
        played.button("Reset")
        # another clock, another phase
        played.until(lambda: starts and played.simulation.driver is not starts[0])
        assert played.simulation.cause == "reset"

    def test_a_fall_is_told_and_mended(self, played):
        falls = played.simulation.falls
        played.runner.ask(lambda simulation: simulation.push((0.0, 150.0)))  # 10 m/s sideways
        played.until(lambda: played.simulation.falls > falls)
        played.until(lambda: played.simulation.cause == "fell")
        played.until(lambda: "fell" in played.report() or "Falls so far" in played.report())
        played.until(lambda: played.simulation.fell_at is None and played.simulation.time > 1.0)

    def test_the_robot_is_drawn(self, played):
        def colours() -> np.ndarray:
            return played.canvas().reshape(-1, 3)

        def drawn() -> bool:
            seen = colours()
            red, green, blue = seen.T
            # feet in the legs' colours, shaded: left front orange, right front vermilion, left hind blue
            warm = (red > 120) & (red > 1.8 * blue) & (red > 1.15 * green)
            cold = (blue > 120) & (blue > 1.5 * red)
            return len(np.unique(seen, axis=0)) > 500 and warm.sum() > 50 and cold.sum() > 50

        played.until(drawn)
        height, width, _ = played.canvas().shape
        assert min(height, width) > 100


class TestCommand:
    def start(self, *arguments: str) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, "-m", "symdyn", "play", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "COLUMNS": "200"},
        )

    def address(self, process: subprocess.Popen[str]) -> tuple[str, list[str]]:
        """Read on until the address is told; it, and the lines so far."""
        said = []
        assert process.stdout is not None
        for line in process.stdout:
            said.append(line)
            if "http://" in line:
                return next(word for word in line.split() if word.startswith("http://")), said
        raise AssertionError(f"no address: {said} {process.stderr.read() if process.stderr else ''}")

    @pytest.mark.parametrize("end", [signal.SIGINT, signal.SIGTERM])
    def test_it_says_where_the_page_is_and_ends_cleanly(self, end):
        process = self.start("--port", "0")
        try:
            address, said = self.address(process)
            with urllib.request.urlopen(address, timeout=60) as page:
                assert page.status == 200
            assert "go2.onnx" in said[0] and "Ctrl-C ends" in said[-1]
            process.send_signal(end)
            out, err = process.communicate(timeout=120)
        finally:
            process.kill()
        assert process.returncode == 0, err
        assert err == "" and out.strip() == "Ended."

    def test_a_host_for_others_has_a_word_of_warning(self):
        process = self.start("--port", "0", "--host", "0.0.0.0")
        try:
            address, _ = self.address(process)
            assert address.startswith("http://localhost:")
            assert process.stdout is not None
            assert "Anyone who can reach port" in process.stdout.readline()
        finally:
            process.kill()
            process.communicate()


class TestRobotSim:
    def test_the_robot_that_lcm_tells_of_is_shown(self):
        """The messages of symdyn robot-sim's robot, sent from here, reach the page."""
        from hardware.wire.channels import IMU, JOINTS, TRUTH
        from hardware.wire.link import Link
        from symdyn.io.console import make_console
        from symdyn_cli import play
        from tests.hardware.robot_sim.simulated import go2

        lcm_url = multicast_url()
        robot = go2(start="standing")
        args = play.PlayArguments(port=0, robot_sim=lcm_url)
        stop = threading.Event()
        with play._watched(args, make_console()) as page:
            watched = page._shown
            assert watched.pose() is None and "No messages arrive at" in watched.report(time.monotonic())
            sender = Link(lcm_url, ())

            def send(with_truth: bool) -> None:
                for _ in range(10):
                    robot.step()
                sender.send(JOINTS, robot.joints())
                sender.send(IMU, robot.imu())
                if with_truth:
                    sender.send(TRUTH, robot.truth())

            def until(true: Callable[[], bool], with_truth: bool) -> None:
                for _ in range(600):
                    send(with_truth)
                    if true():
                        return
                    stop.wait(0.05)
                raise AssertionError("nothing came within half a minute")

            until(lambda: watched.pose() is not None and watched.pose().base_pos_w is not None, True)
            pose = watched.pose()
            np.testing.assert_allclose(pose.joint_pos, robot.data.qpos[7:][_joint_order(robot)], atol=0.02)
            assert pose.base_pos_w[2] == pytest.approx(robot.height, abs=0.01)
            assert pose.contact.all()
            assert "heard of" in watched.report(time.monotonic())
            # without the simulator's truth, as on the real robot: orientation and feet are those of its sensors
            until(lambda: watched.pose().base_pos_w is None, False)
            assert np.linalg.norm(watched.pose().base_quat_w) == pytest.approx(1.0, abs=1e-3)
            assert watched.pose().contact.all()

    def test_the_command_says_what_it_listens_to(self):
        lcm_url = multicast_url()
        process = TestCommand().start("--port", "0", "--robot-sim", lcm_url)
        try:
            _, said = TestCommand().address(process)
            assert lcm_url in said[0]
            process.send_signal(signal.SIGINT)
            _, err = process.communicate(timeout=120)
        finally:
            process.kill()
        assert process.returncode == 0 and err == ""


def _joint_order(robot) -> list[int]:
    return [int(robot.model.joint(name).qposadr[0]) - 7 for name in robot.robot.joint_names]
