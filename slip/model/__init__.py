"""The spring-loaded quadruped: parameters, equations of motion, unknowns of a stride, names of gaits."""
