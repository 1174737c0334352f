"""The picture of learning curves."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import StrMethodFormatter, SymmetricalLogLocator

from habilis.colours import COLOURS
from habilis.learning.config import Config
from habilis.learning.curves import SMOOTHING, Curve

DEFAULT = Path("curves.png")

# What says nothing without an intrinsic reward.
_OF_INTRINSIC = ("horizon", "beta", "beta_schedule", "beta_steps", "earned", "terminal_bonus")
_DASHES = ("-", "--", "-.", ":")

_NAMES = {
    "return": "return",
    "length": "steps of an episode",
    "equipped": "share of the steps with the tool in hand",
    "attached": "share of the equipped steps with the object attached",
}
_STATISTICS = {"mean": "mean", "iqm": "interquartile mean"}


def curves_figure(curves: Mapping[str, Curve], best_returns: Sequence[float] = ()) -> Figure:
    """Learning curves with their intervals, by their labels.

    Args:
        curves: of one value, over one unit.
        best_returns: drawn dotted.

    Returns:
        The figure; `worlds.pictures.save_figure` writes it.
    """
    one = next(iter(curves.values()))
    figure = Figure(figsize=(11, 4.8), dpi=96)
    ax = figure.subplots()
    for number, (label, curve) in enumerate(curves.items()):
        colour = COLOURS[number % len(COLOURS)]
        runs = f"{curve.runs} run{'s' if curve.runs > 1 else ''}"
        style = _DASHES[number // len(COLOURS) % len(_DASHES)]
        ax.fill_between(curve.x, curve.low, curve.high, color=colour, alpha=0.2, linewidth=0)
        if len(curve.x) == 1:  # a line through one point is none
            ax.vlines(curve.x, curve.low, curve.high, color=colour, alpha=0.2, linewidth=6)
            style = "o"
        ax.plot(curve.x, curve.middle, style, color=colour, lw=1.4, label=f"{label} ({runs})")
    for best in sorted(set(best_returns)):
        ax.axhline(best, color="#5b6270", linewidth=0.8, linestyle=":")
    if one.value == "return":
        ax.set_yscale("symlog")
        ax.yaxis.set_major_locator(SymmetricalLogLocator(base=10, linthresh=2, subs=(1, 2, 5)))
        ax.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        if best_returns:
            ax.set_ylim(top=0.75 * max(best_returns))
    elif one.value != "length":
        ax.set_ylim(0, 1.02)
    dotted = " (dotted: best)" if best_returns else ""
    ax.set(
        xlabel=f"{one.unit} (moving average over {SMOOTHING} episodes)",
        ylabel=f"{_NAMES[one.value]}{dotted}",
        title=f"{_STATISTICS[one.statistic]} over runs, shaded: 95 % bootstrap interval",
    )
    ax.title.set_fontsize(10)
    ax.xaxis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(frameon=False)
    figure.tight_layout()
    return figure


def labels(configs: Sequence[Config], names: Sequence[str]) -> list[str]:
    """The settings that differ between configurations.

    Settings that belong to an algorithm are compared among those that use it.

    Args:
        configs: the configurations to distinguish.
        names: take part where settings do not tell all apart.
    """
    common = [{f.name: getattr(c, f.name) for f in fields(c)} for c in configs]
    described = [
        _differing(values, common, ("algorithm", *(() if values["beta"] else _OF_INTRINSIC)))
        for values in common
    ]
    of_algorithm = [c.as_dict() for c in configs]
    for number, config in enumerate(configs):
        same = [
            values
            for values, other in zip(of_algorithm, configs, strict=True)
            if type(other.algorithm) is type(config.algorithm)
        ]
        if len(same) < len(configs):
            described[number].append(str(of_algorithm[number]["algorithm"]))
        described[number] += _differing(of_algorithm[number], same, skip=tuple(common[0]))
    found = [", ".join(words) for words in described]
    unique = len(set(found)) == len(found) and all(found)
    return found if unique else [_named(n, f) for n, f in zip(names, found, strict=True)]


def _named(name: str, label: str) -> str:
    return f"{name}: {label}" if label else name


def _differing(
    values: Mapping[str, Any], all_values: Sequence[Mapping[str, Any]], skip: Sequence[str]
) -> list[str]:
    return [
        _shown(name, value)
        for name, value in values.items()
        if name not in skip and any(other[name] != value for other in all_values)
    ]


def _shown(name: str, value: Any) -> str:
    words = name.replace("_", " ")
    if isinstance(value, bool):
        return words if value else f"no {words}"
    if isinstance(value, tuple):
        return f"{words} {'x'.join(map(str, value))}"
    if name == "world":
        return Path(value).stem
    if name == "tool":
        return value or "the map's tool"
    return f"{words} {value:g}" if isinstance(value, float) else f"{words} {value}"
