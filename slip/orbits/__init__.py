"""One periodic gait: the stride, Newton's method, stability, symmetry, an independent simulation."""
