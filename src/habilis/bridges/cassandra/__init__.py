"""POMDP and MDP files in Cassandra's format (`.pomdp`, `.mdp`)."""

from habilis.bridges.cassandra.pomdp import POMDP as POMDP
from habilis.bridges.cassandra.pomdp import load_pomdp as load_pomdp
