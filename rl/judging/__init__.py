"""How a policy is judged: scripted episodes, protocols, summaries, reports, timing sweeps."""
