"""The studio: a local page on which worlds are drawn and their empowerment is seen at once."""
