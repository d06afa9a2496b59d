"""Between the robot's own wire and LCM: LowState to the deployer, targets to the motors, and a guard that damps."""
