"""From readings to targets: state machine, stand-up, limits, health, faults, settings."""
