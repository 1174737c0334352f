"""Learning with empowerment in the reward: networks, A2C, many runs at once."""
