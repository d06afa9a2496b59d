"""What the sensors say about the robot: velocity, foot contact, ground force, order of legs."""
