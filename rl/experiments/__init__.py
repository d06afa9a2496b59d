"""The paper's Results section, and what it lacks: fixed seeds, figures, a table paper against ours.

Every experiment is a function ``run(subject) -> Result``; :mod:`rl.experiments.catalogue` lists them.
"""
