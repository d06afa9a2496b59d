"""``symdyn bridge``: between the robot's own wire and the deployer."""

from __future__ import annotations

import os

from hardware.bridge.bridge import Bridge, Options
from hardware.cli.arguments.bridge import BridgeArguments
from hardware.running.display import Display, log_from_a_thread
from hardware.wire.channels import DEFAULT_URL
from symdyn.errors import InvalidValue
from symdyn.io.console import log_to, make_console, print_written
from symdyn.io.files import writable_directory, write_json


def run(args: BridgeArguments) -> int:
    """The command: 0, or 1 if the motors were damped for good by a fault. Raises SymdynError before that."""
    if not 0.0 < args.damping_kd < float("inf"):
        raise InvalidValue("--damping-kd", args.damping_kd, "a number > 0, N m s/rad")
    if args.out is not None:
        writable_directory(args.out.parent)
    console = make_console()
    log_to(console)
    url = args.url or os.environ.get("LCM_DEFAULT_URL") or DEFAULT_URL
    options = Options(url, args.interface, args.domain, args.keep_service, args.damping_kd, args.realtime)
    bridge = Bridge(options)
    console.print(f"DDS domain {args.domain} to {url}. Next, in another terminal: symdyn deploy POLICY.onnx")
    display = Display(bridge.status) if console.is_terminal else None
    listener = log_from_a_thread(display)
    try:
        code = bridge.run()
    finally:
        if display is not None:
            display.close()
        listener.stop()
    status = bridge.last
    assert status is not None
    console.print(status)
    if args.out is not None:
        write_json(args.out, status.summary() | {"fault": bridge.fault})
        print_written(console, f"Wrote {args.out}.")
    return code
