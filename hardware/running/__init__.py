"""The deployer's processes: loop, watchdog, display, keyboard, real-time scheduling."""
