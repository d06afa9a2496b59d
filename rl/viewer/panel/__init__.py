"""Footfalls, metrics and text beside the robot, as SVG and Markdown."""
