"""The command ``symdyn``, and the commands in which packages meet."""
