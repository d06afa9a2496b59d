"""symdyn: one definition of a gait for analysis, training, evaluation and the robot."""
