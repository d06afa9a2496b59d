"""From a URDF to the spring-loaded model: description, mass and inertia, morphological symmetry, units."""
