"""``python -m symdyn`` is the command ``symdyn``, whichever package provides it."""

import sys
from importlib.metadata import entry_points

(_command,) = entry_points(group="console_scripts", name="symdyn")
sys.exit(_command.load()())
