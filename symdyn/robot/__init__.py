"""What a robot is: its robot file, its description, its legs and joints by name, its frames."""
