"""Timing curves: fits to passive gaits and to trials, identification of springs, studies over models."""
