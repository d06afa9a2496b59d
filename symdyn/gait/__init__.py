"""What a gait is: the library, the clock, the timing curves, the symmetry classes."""
