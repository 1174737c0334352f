"""Small studies of bonuses: `habilis study` trains agents with several, and compares them."""
