"""What goes over LCM: messages, channels, link, event log, readings in symdyn's order."""
