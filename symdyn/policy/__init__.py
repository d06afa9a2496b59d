"""What a policy is: the observation, the policy file, and the driver that runs it."""
