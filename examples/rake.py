"""A custom tool: `habilis compare yard --tools examples/rake.py:Rake,broom --horizon 3`."""

import numpy as np


class Rake:
    """Pulls an object that stands behind it, in line with the agent, when the agent backs away."""

    character = "R"  # represents it on a map

    def attached(self, agent, tool, thing):
        return np.zeros(thing.shape, bool)  # never: the object only moves when pulled

    def carry(self, agent, tool, thing, step):
        behind = thing - tool == tool - agent  # agent, rake and object in one straight line
        backing = step == agent - tool  # the agent moves away from the rake
        return np.where(behind & backing, thing + step, thing)

    def swing(self, agent, tool, thing, step):
        return thing  # putting it on another side moves nothing
