"""``symdyn record``: a film of a policy that goes through gaits and speeds."""

from __future__ import annotations

from rl.physics.threads import wait_passively
from rl.pictures import headless_gl  # before what imports MuJoCo

wait_passively()  # before torch

import math  # noqa: E402
from pathlib import Path  # noqa: E402

from rich.console import Console  # noqa: E402

from rl.cli.arguments.record import RecordArguments  # noqa: E402
from rl.judging.simulate import Episode, Script, Segment  # noqa: E402
from rl.judging.simulate import run as simulate  # noqa: E402
from rl.pictures.film import frames  # noqa: E402
from rl.pictures.film_config import FilmConfig  # noqa: E402
from rl.pretrained import load_policy  # noqa: E402
from symdyn.errors import InvalidValue  # noqa: E402
from symdyn.figures.video import check_format, write_video  # noqa: E402
from symdyn.gait.symmetry import gait_by_name  # noqa: E402
from symdyn.io.console import log_to, make_console, print_command, print_written  # noqa: E402
from symdyn.io.progress import progress  # noqa: E402
from symdyn.policy.file import Policy  # noqa: E402

_GIF_BYTES = 2**30


def run(args: RecordArguments) -> int:
    """The command. Raises SymdynError for bad input."""
    script = script_of(args)
    if args.out is not None:
        check_format(args.out)
    path, policy = load_policy(args.policy, args.robot)
    out = args.out or Path("out") / f"{policy.robot.name}.mp4"
    check_format(out)
    _check_memory(out, args.film, script.duration)
    console = make_console()
    log_to(console)
    _warn_of_range(policy, args.speeds, console)
    headless_gl.use_working_backend()
    (episode,) = simulate(policy, [script])
    _write(policy, episode, args.film, out, console)
    ran = len(episode.recording.time) * episode.recording.dt
    plays = args.film.frames_of(ran) / args.film.fps
    fell = "" if episode.fell_at is None else f" The robot fell after {episode.fell_at:.2f} s: there it ends."
    print_written(console, f"Wrote {out}: {ran:.4g} s of running, plays {plays:.4g} s.{fell} Next:")
    print_command(console, "symdyn", "evaluate", path)
    return 0


def script_of(args: RecordArguments) -> Script:
    """The commands that are filmed. Raises UnknownName, InvalidValue."""
    gaits = [gait_by_name(name) for name in args.gaits]
    if not gaits:
        raise InvalidValue("--gaits", args.gaits, "one name at least")
    speeds = args.speeds
    if not speeds or not all(math.isfinite(speed) for speed in speeds):
        raise InvalidValue("--speeds", speeds, "finite numbers, m/s")
    if len(gaits) == 1:
        gaits = gaits * len(speeds)
    if len(speeds) == 1:
        speeds = speeds * len(gaits)
    if len(speeds) != len(gaits):
        raise InvalidValue("The number of --speeds", len(speeds), f"1 or that of the gaits, {len(gaits)}")
    if not (math.isfinite(args.seconds) and 0.1 <= args.seconds <= 600.0):
        raise InvalidValue("--seconds", args.seconds, "from 0.1 to 600")
    if args.seed < 0:
        raise InvalidValue("--seed", args.seed, ">= 0")
    segments = tuple(
        Segment(i * args.seconds, gait, (speed, 0.0, 0.0))
        for i, (gait, speed) in enumerate(zip(gaits, speeds, strict=True))
    )
    return Script("film", segments, len(segments) * args.seconds, args.seed)


def _warn_of_range(policy: Policy, speeds: tuple[float, ...], console: Console) -> None:
    """A film of a fall may be what is wanted; but it should not surprise."""
    low, high = policy.metadata.command_range["velocity_x"]
    outside = [f"{speed:g}" for speed in speeds if not low <= speed <= high]
    if outside:
        console.print(
            f"Commanded speeds outside the range of training, {low:g} to {high:g} m/s: {', '.join(outside)} m/s. "
            "The robot may fall.",
            style="yellow",
        )


def _check_memory(out: Path, film: FilmConfig, seconds: float) -> None:
    frame = 3 * film.size[0] * film.size[1]
    total, most = film.frames_of(seconds), _GIF_BYTES // frame
    if out.suffix.lower() == ".gif" and total > most:
        raise InvalidValue(
            "The number of frames of a GIF",
            total,
            f"at most {most} of this --size (all are held in memory); write .mp4 instead",
        )


def _write(policy: Policy, episode: Episode, film: FilmConfig, out: Path, console: Console) -> None:
    with progress(console, f"Drawing {out.name}") as report_progress:
        pictures = frames(
            episode,
            policy.robot,
            film,
            report_progress,
        )
        write_video(out, pictures, film.fps)
