"""What the studies of learning agents have in common: agents, their training, tables, a page."""
