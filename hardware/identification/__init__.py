"""From a log of the excitation to a fit: what each joint's motor is, with intervals, or why the log does not tell."""
