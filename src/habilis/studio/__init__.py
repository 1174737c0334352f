"""The studio: a local page for drawing worlds, with their empowerment updated live."""
