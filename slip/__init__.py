"""Passive dynamics: from a robot's URDF to the spring-loaded model, its gait families, symmetries and timing curves."""
