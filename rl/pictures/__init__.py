"""Films and renderings of the robot."""
