"""The labels on heatmaps."""

from matplotlib.axes import Axes
from matplotlib.text import Text


def labels_on(ax: Axes) -> list[Text]:
    """The labels of a heat map's values."""
    return [text for artist in ax.artists for text in getattr(artist, "texts", [])]
