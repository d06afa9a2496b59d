"""The simulation that a viewer shows: one robot under a policy, its pace, its history."""
