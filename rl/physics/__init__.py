"""The simulated robot: the MuJoCo model, the physics protocol and its engine, terrain, randomisation."""
