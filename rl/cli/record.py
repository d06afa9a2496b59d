"""``symdyn record``: a film of a policy that goes through gaits and speeds."""

from __future__ import annotations

from rl.physics.threads import wait_passively
from rl.pictures import headless_gl  # before what imports MuJoCo

wait_passively()  # before torch

import math  # noqa: E402
from collections.abc import Sequence  # noqa: E402
from dataclasses import dataclass, field  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import Annotated  # noqa: E402

import tyro  # noqa: E402
from rich.console import Console  # noqa: E402

from rl.judging.protocols import GAIT_SEQUENCE, GAIT_SPEED  # noqa: E402
from rl.judging.simulate import Episode, Script, Segment  # noqa: E402
from rl.judging.simulate import run as simulate  # noqa: E402
from rl.pictures.film import FilmConfig, frames  # noqa: E402
from rl.pretrained import load_policy  # noqa: E402
from symdyn.errors import InvalidValue  # noqa: E402
from symdyn.figures.video import check_format, write_video  # noqa: E402
from symdyn.gait.library import get  # noqa: E402
from symdyn.io.console import frames_progress, log_to, make_console  # noqa: E402
from symdyn.io.options import RobotOption  # noqa: E402
from symdyn.policy.file import Policy  # noqa: E402

_GIF_BYTES = 2**30


@dataclass(frozen=True)
class RecordArguments:
    """A film of a policy that goes through gaits and speeds, on the nominal model from a stand: MP4 or GIF.

    Above the robot stand the gait, the commanded speed and the measured one (the mean over the last stride); below it
    the footfalls, desired (hollow) and realised (solid), in the colours of the feet. Rendered without a screen, by EGL
    or OSMesa, whichever works; MUJOCO_GL decides where it is set.

    Attributes:
        policy: the file; the policy that comes with symdyn if left out.
        robot: name or robot file of the robot; the policy's if left out.
        gaits: one after the other.
        speeds: forward speeds, m/s: one for each gait, or one for all. One gait can also have several speeds.
        seconds: of running for each.
        out: the file; its suffix, .mp4 or .gif, is the format. MP4 needs imageio-ffmpeg. out/ROBOT.mp4 if left out.
        film: how it is shown.
        seed: decides the initial stride phase.
    """

    policy: Annotated[Path | None, tyro.conf.Positional] = None
    robot: RobotOption = None
    gaits: tuple[str, ...] = GAIT_SEQUENCE
    speeds: tuple[float, ...] = (GAIT_SPEED,)
    seconds: float = 2.0
    out: Path | None = None
    film: Annotated[FilmConfig, tyro.conf.arg(name="")] = field(default_factory=FilmConfig)
    seed: int = 0

    def script(self) -> Script:
        """The commands. Raises UnknownName, InvalidValue."""
        gaits = [get(name) for name in self.gaits]
        if not gaits:
            raise InvalidValue("--gaits", self.gaits, "one name at least")
        speeds = self.speeds
        if not speeds or not all(math.isfinite(speed) for speed in speeds):
            raise InvalidValue("--speeds", speeds, "finite numbers, m/s")
        if len(gaits) == 1:
            gaits = gaits * len(speeds)
        if len(speeds) == 1:
            speeds = speeds * len(gaits)
        if len(speeds) != len(gaits):
            raise InvalidValue("The number of --speeds", len(speeds), f"1 or that of the gaits, {len(gaits)}")
        if not (math.isfinite(self.seconds) and 0.1 <= self.seconds <= 600.0):
            raise InvalidValue("--seconds", self.seconds, "from 0.1 to 600")
        if self.seed < 0:
            raise InvalidValue("--seed", self.seed, ">= 0")
        segments = tuple(
            Segment(i * self.seconds, gait, (speed, 0.0, 0.0))
            for i, (gait, speed) in enumerate(zip(gaits, speeds, strict=True))
        )
        return Script("film", segments, len(segments) * self.seconds, self.seed)


def run(arguments: Sequence[str]) -> int:
    """The command. Raises SymdynError for bad input."""
    args = tyro.cli(RecordArguments, args=list(arguments), prog="symdyn record")
    script = args.script()
    if args.out is not None:
        check_format(args.out)
    path, policy = load_policy(args.policy, args.robot)
    out = args.out or Path("out") / f"{policy.robot.name}.mp4"
    check_format(out)
    _check_memory(out, args.film, script.duration)
    console = make_console()
    log_to(console)
    headless_gl.use_working_backend()
    (episode,) = simulate(policy, [script])
    _write(policy, episode, args.film, out, console)
    ran = len(episode.recording.time) * episode.recording.dt
    plays = args.film.frames_of(ran) / args.film.fps
    fell = "" if episode.fell_at is None else f" The robot fell after {episode.fell_at:.2f} s: there it ends."
    console.print(f"Wrote {out}: {ran:.4g} s of running, plays {plays:.4g} s.{fell} Next:")
    console.print(f"  symdyn evaluate {path}")
    return 0


def _check_memory(out: Path, film: FilmConfig, seconds: float) -> None:
    frame = 3 * film.size[0] * film.size[1]
    total, most = film.frames_of(seconds), _GIF_BYTES // frame
    if out.suffix.lower() == ".gif" and total > most:
        raise InvalidValue(
            "The number of frames of a GIF", total, f"at most {most} of this --size (all are held in memory); take .mp4"
        )


def _write(policy: Policy, episode: Episode, film: FilmConfig, out: Path, console: Console) -> None:
    with frames_progress(console) as progress:
        task = progress.add_task(f"Drawing {out.name}", total=None)
        pictures = frames(
            episode,
            policy.robot,
            film,
            lambda done, total: progress.update(task, completed=done, total=total),
        )
        write_video(out, pictures, film.fps)
