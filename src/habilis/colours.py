"""Colours for lines on white, distinguishable for every kind of colour vision."""

# Okabe and Ito's, the yellow left out: too light for a line on white.
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000")
