"""Figures and animations of orbits, families and curves."""
