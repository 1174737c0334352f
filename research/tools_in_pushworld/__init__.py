"""Whether object empowerment finds the tools of PushWorld's puzzles: `make tools`."""
