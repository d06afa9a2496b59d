"""Files that are whole or absent, settings as plain data, the terminal."""
