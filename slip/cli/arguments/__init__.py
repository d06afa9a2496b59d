"""What each command takes, a module a command: no heavy library is imported here, so that help appears at once."""
