"""The page in the browser: server, controls, what is shown of a simulation or of a robot."""
