"""Puzzles of bodies that an agent pushes: PushWorld's and Sokoban's, and their pictures."""
