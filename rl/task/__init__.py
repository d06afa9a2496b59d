"""What is to be learned: environment, commands, rewards, curriculum, termination."""
