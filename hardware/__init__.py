"""The same policy on the real robot: messages, state, safety, logs."""
