"""How it is learned: settings, trainer, networks, checkpoints, export."""
