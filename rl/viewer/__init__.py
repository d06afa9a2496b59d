"""A policy live in the browser: the robot, what it is told, and what it does."""
