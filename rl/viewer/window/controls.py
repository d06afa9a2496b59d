"""What a visitor can do to the live simulation: the panel of buttons and sliders."""

from __future__ import annotations

from html import escape

import viser

from rl.physics.model import DEFAULT_FRICTION
from rl.viewer.live.mixture import Mixture, gaits_of
from rl.viewer.live.runner import Runner
from rl.viewer.live.simulation import BUMPS, LiveSimulation, World
from rl.viewer.panel.report import paragraph, readable
from symdyn.policy.file import Policy
from symdyn.policy.metadata import COMMANDS

FIRST_SPEED = 0.6
"""m/s; what the robot is told first."""

SLOW_MOTION = {"real time": 1.0, "1/2": 0.5, "1/4": 0.25, "1/10": 0.1}
"""Simulated seconds for one on the wall, by what the choice is called."""

PUSHES = {"forward": (1.0, 0.0), "back": (-1.0, 0.0), "left": (0.0, 1.0), "right": (0.0, -1.0)}
"""Direction forwards and to the left, by the button's name."""

INTRODUCTION = (
    "A {robot} in MuJoCo, driven by the policy <b>{policy}</b>. Drag to rotate the view, scroll to zoom; "
    "click a gait to see it change."
)

HELP = """
**Footfalls.** A row a leg: left hind, left front, right front, right hind. Hollow bars are when the clock wants the
foot on the ground, solid ones when it is. The right edge is now. Feet and their prints have the colours of the rows.

**Gaits** differ in four numbers: how far the legs' cycles are apart. A mixture lies between two of them; the policy
gets the four numbers, and never a name.

**Timing.** How long a stride lasts, and for which share of it a foot stands (the duty factor), follow from the speed.

**GC_stance** is the share of the time that a foot is on the ground and should not be, or the reverse. **Cost of
transport** is the work of the joints for each newton of weight and metre of way.

Lines with more to say show it when the mouse rests on them.
"""

_LABELS = {
    "velocity_x": ("speed [m/s]", "Forward velocity. Negative is backwards."),
    "velocity_y": ("sideways [m/s]", "Velocity to the left. Negative is to the right."),
    "yaw_rate": ("turn [rad/s]", "Yaw rate to the left. Negative is to the right."),
}
_PAYLOAD = (-3.0, 5.0)  # kg
_FRICTION = (0.1, 1.6)  # of foot on floor
_PUSH = (0.0, 20.0)  # N s
_FIRST_PUSH = 8.0  # N s; half a metre per second for a Go2


class Controls:
    """The panel. Whoever visits the page shares it with all others who do.

    Args:
        server: of the page.
        runner: of the simulation that is controlled.
        name: of the policy.
    """

    def __init__(self, server: viser.ViserServer, runner: Runner, name: str) -> None:
        self._runner = runner
        self._policy: Policy = runner.simulation.policy
        self._gaits = gaits_of(self._policy)
        self._first = next(iter(self._gaits))
        gui = server.gui
        robot = runner.simulation.robot.name.capitalize()
        gui.add_html(paragraph(INTRODUCTION.format(robot=robot, policy=escape(name))))
        self._add_time(gui)
        with gui.add_folder("Gait"):
            self._add_gaits(gui)
        with gui.add_folder("Speed"):
            self._add_speeds(gui)
        with gui.add_folder("Push"):
            self._add_push(gui)
        with gui.add_folder("World"):
            self._add_world(gui)
        with gui.add_folder("How to read this", expand_by_default=False):
            gui.add_markdown(HELP)
        self._tell_gait()
        self._tell_velocity()

    # viser calls back from several threads; what is told is read from the panel then, so that the last call tells all

    def _add_time(self, gui: viser.GuiApi) -> None:
        self._pause = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, hint="Let time stand still.")
        self._pause.on_click(lambda _: self._toggle_pause())
        reset = gui.add_button("Reset", icon=viser.Icon.REFRESH, hint="Put the robot on its feet in the middle.")
        reset.on_click(lambda _: self._runner.ask(LiveSimulation.reset))
        slow = gui.add_dropdown("time", tuple(SLOW_MOTION), hint="Slow motion shows how a gallop works.")

        @slow.on_update
        def _(_: object) -> None:
            self._runner.speed = SLOW_MOTION[slow.value]

    def _toggle_pause(self) -> None:
        paused = self._pause.label == "Pause"
        self._pause.label = "Go on" if paused else "Pause"
        self._pause.icon = viser.Icon.PLAYER_PLAY if paused else viser.Icon.PLAYER_PAUSE
        self._runner.paused = paused

    def _add_gaits(self, gui: viser.GuiApi) -> None:
        trained = tuple(self._policy.gaits)
        others = tuple(name for name in self._gaits if name not in trained)
        self._add_buttons(gui, "trained", trained, "Gaits that the policy was trained on.")
        if others:
            self._add_buttons(gui, "untrained", others, "Gaits that the policy never saw: it may stumble.")
        names = {readable(name): name for name in self._gaits}
        self._second = gui.add_dropdown(
            "mix with",
            tuple(names),
            initial_value=tuple(names)[min(1, len(names) - 1)],
            hint="Every leg's phase offset goes from that of the chosen gait to that of this one, the shorter way.",
        )
        self._share = gui.add_slider(
            "share", 0.0, 1.0, 0.01, 0.0, hint="0 is the chosen gait alone, 1 the one that is mixed with it."
        )
        self._second.on_update(lambda _: self._tell_gait())
        self._share.on_update(lambda _: self._tell_gait())

    def _add_buttons(self, gui: viser.GuiApi, label: str, gaits: tuple[str, ...], hint: str) -> None:
        names = {readable(name): name for name in gaits}
        buttons = gui.add_button_group(label, tuple(names), hint=hint)

        @buttons.on_click
        def _(_: object) -> None:
            self._first = names[buttons.value]
            self._share.value = 0.0
            self._tell_gait()  # viser does not call back for a value that stays the same

    def _tell_gait(self) -> None:
        second = next(name for name in self._gaits if readable(name) == self._second.value)
        gait = Mixture(self._first, second, _value(self._share)).gait(self._gaits)
        self._runner.ask(lambda simulation: simulation.command(gait=gait))

    def _add_speeds(self, gui: viser.GuiApi) -> None:
        self._speeds: dict[str, viser.GuiSliderHandle[float]] = {}
        for name in COMMANDS:
            low, high = self._policy.metadata.command_range[name]
            if low == high:
                continue  # never commanded anything else
            label, hint = _LABELS[name]
            first = FIRST_SPEED if name == "velocity_x" else 0.0
            slider = gui.add_slider(label, low, high, 0.05, min(max(first, low), high), hint=f"{hint} As in training.")
            slider.on_update(lambda _: self._tell_velocity())
            self._speeds[name] = slider

    def _tell_velocity(self) -> None:
        ranges = self._policy.metadata.command_range
        x, y, turn = (_value(self._speeds[n]) if n in self._speeds else ranges[n][0] for n in COMMANDS)
        self._runner.ask(lambda simulation: simulation.command(velocity=(x, y, turn)))

    def _add_push(self, gui: viser.GuiApi) -> None:
        strength = gui.add_slider(
            "strength [N s]", *_PUSH, 0.5, _FIRST_PUSH, hint="Momentum of a push; a Go2 of 15 kg gains 1 m/s by 15 N s."
        )
        buttons = gui.add_button_group("push it", tuple(PUSHES), hint="As seen by the robot.")

        @buttons.on_click
        def _(_: object) -> None:
            forward, left = (_value(strength) * part for part in PUSHES[buttons.value])
            self._runner.ask(lambda simulation: simulation.push((forward, left)))

    def _add_world(self, gui: viser.GuiApi) -> None:
        payload = gui.add_slider(
            "payload [kg]", *_PAYLOAD, 0.1, 0.0, hint=f"Added to the trunk{self._trained('added_mass', 1.0)}."
        )
        friction = gui.add_slider(
            "friction",
            *_FRICTION,
            0.05,
            DEFAULT_FRICTION,
            hint=f"Of foot on ground{self._trained('friction', DEFAULT_FRICTION)}.",
        )
        bumps = gui.add_checkbox(
            "uneven ground",
            False,
            hint=f"Bumps of +-{100.0 * BUMPS.amplitude:g} cm. The policy sees none of it; it learned on flat ground.",
        )

        def tell_world(_: object) -> None:
            terrain = BUMPS if bumps.value else None
            world = World(_value(payload), _value(friction) / DEFAULT_FRICTION, terrain)
            self._runner.ask(lambda simulation: simulation.set_world(world))

        for handle in (payload, friction, bumps):
            handle.on_update(tell_world)

    def _trained(self, name: str, unit: float) -> str:
        """From where to where a setting of rl.physics.randomization went in training, if the policy file says so."""
        config = self._policy.metadata.training["config"]
        bounds = config.get("env", {}).get("randomization", {}).get(name)
        return f"; in training from {unit * bounds[0]:g} to {unit * bounds[1]:g}" if bounds else ""


def _value(slider: viser.GuiSliderHandle[float]) -> float:
    """Of a slider, within its range: what is typed into the box beside it is not checked."""
    return min(max(float(slider.value), slider.min), slider.max)
