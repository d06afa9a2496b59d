"""Exit codes of the commands."""

FAILED = 1
BAD_INPUT = 2
INTERRUPTED = 130
"""128 + SIGINT, as shells have it: the command was interrupted and can go on later."""
