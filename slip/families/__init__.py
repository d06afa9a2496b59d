"""Families of periodic gaits: continuation, junctions, search, storage."""
