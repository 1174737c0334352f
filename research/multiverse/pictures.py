"""The pictures of the second part."""

from collections.abc import Mapping

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure

from habilis.colours import COLOURS
from habilis.statistics import bootstrap_interval, interquartile_mean
from habilis.studies.axes import (
    LABEL_SIZE,
    episodes_axis,
    log_axis,
    mark_best,
    returns_axis,
)
from habilis.studies.comparison import Outcome

HOLDS, UNDECIDED, OPPOSITE = COLOURS[0], "#d9dde3", COLOURS[1]
_OUTCOMES = {Outcome.HOLDS: HOLDS, Outcome.UNDECIDED: UNDECIDED, Outcome.OPPOSITE: OPPOSITE}
_SUPERIORITY = TwoSlopeNorm(0.5, 0, 1)
_MAP = "RdBu"
_FINE = (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)  # ticks of an axis that is less than a decade
_COLOURS = (*COLOURS[:4], "#5b6270", COLOURS[5])


def shares_figure(parts: Mapping[str, pl.DataFrame]) -> Figure:
    """In what share of the settings each claim holds: a bar a claim, a panel a part.

    Args:
        parts: `claims.shares` by the title of its panel.
    """
    claims = next(iter(parts.values()))["claim"].to_list()
    figure = Figure(figsize=(4.2 + 3.6 * len(parts), 0.9 + 0.42 * len(claims)), dpi=96)
    axes = np.atleast_1d(figure.subplots(1, len(parts), sharey=True))
    for ax, (title, shares) in zip(axes, parts.items(), strict=True):
        left = np.zeros(len(shares))
        for outcome, colour in _OUTCOMES.items():
            values = shares[outcome.value].to_numpy()
            ax.barh(shares["claim"], values, left=left, color=colour, label=outcome.value)
            for row, (value, start) in enumerate(zip(values, left, strict=True)):
                if value >= 0.08:
                    ink = "#1f2430" if outcome is Outcome.UNDECIDED else "white"
                    middle = start + value / 2
                    ax.text(
                        middle, row, f"{value:.0%}", color=ink, ha="center", va="center", fontsize=8
                    )
            left += values
        ax.set(title=title, xlim=(0, 1), xticks=[])
        ax.spines[:].set_visible(False)
        ax.tick_params(length=0)
    axes[0].invert_yaxis()
    axes[-1].legend(frameon=False, loc="upper left", bbox_to_anchor=(1, 1), fontsize=8)
    figure.tight_layout()
    return figure


def choices_figure(verdicts: pl.DataFrame, changed: pl.DataFrame, measure: str) -> Figure:
    """The probability that the supposedly faster agent finishes first, for every setting.

    A dot: the order is significant (p < 0.05). A cross: with this horizon and beta the best policy
    for the regularised reward is no shortest plan, so that an agent that learns it cannot converge.

    Args:
        verdicts: of `claims.multiverse`.
        changed: claim, horizon and beta where the best policy is another one.
        measure: which of its measures.
    """
    verdicts = verdicts.filter(pl.col("measure") == measure, pl.col("beta").is_not_null())
    claims = verdicts["claim"].unique(maintain_order=True).to_list()
    learners = verdicts["learner"].unique(maintain_order=True).to_list()
    horizons, betas = (sorted(verdicts[name].unique()) for name in ("horizon", "beta"))
    crossed = set(changed.select("claim", "horizon", "beta").iter_rows())
    figure = Figure(figsize=(2.6 + 2.0 * len(learners), 0.9 + 1.5 * len(claims)), dpi=96)
    axes = figure.subplots(len(claims), len(learners), sharex=True, sharey=True, squeeze=False)
    image = ScalarMappable(_SUPERIORITY, _MAP)
    for row, claim in zip(axes, claims, strict=True):
        for ax, learner in zip(row, learners, strict=True):
            part = verdicts.filter(claim=claim, learner=learner)
            values = np.full((len(betas), len(horizons)), np.nan)
            for one in part.iter_rows(named=True):
                x, y = horizons.index(one["horizon"]), betas.index(one["beta"])
                values[y, x] = one["superiority"]
                if one["p"] < 0.05:
                    ax.plot(x, y, "o", color="white", markersize=3.5, markeredgecolor="#1f2430")
                if (claim, one["horizon"], one["beta"]) in crossed:
                    ax.plot(x + 0.28, y + 0.28, "x", color="#1f2430", markersize=4, mew=1)
            ax.imshow(values, cmap=_MAP, norm=_SUPERIORITY, origin="lower", aspect="auto")
            ax.set_xticks(range(len(horizons)), [str(h) for h in horizons], fontsize=8)
            ax.set_yticks(range(len(betas)), [f"{b:g}" for b in betas], fontsize=8)
            ax.tick_params(length=0)
        row[0].set_ylabel(
            claim.replace(" (", "\n(").replace(", with", ",\nwith") + "\nbeta", fontsize=7
        )
    for ax, learner in zip(axes[0], learners, strict=True):
        ax.set_title(learner, fontsize=9)
    for ax in axes[-1]:
        ax.set_xlabel("horizon", fontsize=8)
    figure.tight_layout(rect=(0, 0, 0.93, 1))
    bar = figure.add_axes((0.94, 0.35, 0.012, 0.3))
    figure.colorbar(image, cax=bar, label="probability of coming first")
    return figure


def explained_figure(explained: pl.DataFrame) -> Figure:
    """Which choice decides each claim: the share of the variance between settings."""
    choices = [name for name in explained.columns if name != "claim"]
    values = explained.select(choices).to_numpy().astype(float)
    figure = Figure(figsize=(8.5, 0.9 + 0.42 * len(explained)), dpi=96)
    ax = figure.subplots()
    ax.imshow(np.nan_to_num(values), cmap="Greens", vmin=0, vmax=1, aspect="auto")
    for (row, column), value in np.ndenumerate(values):
        text = "–" if np.isnan(value) else f"{value:.0%}"
        ink = "white" if value > 0.6 else "#1f2430"
        ax.text(column, row, text, ha="center", va="center", fontsize=9, color=ink)
    ax.set_xticks(range(len(choices)), choices)
    ax.set_yticks(range(len(explained)), explained["claim"].to_list(), fontsize=8)
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)
    figure.tight_layout()
    return figure


def maps_figure(verdicts: pl.DataFrame, measure: str) -> Figure:
    """The probability that the supposedly faster agent finishes first, a dot for each map.

    Args:
        verdicts: of `claims.on_maps`.
        measure: which of its measures.
    """
    verdicts = verdicts.filter(measure=measure)
    claims = verdicts["claim"].unique(maintain_order=True).to_list()
    figure = Figure(figsize=(9, 0.9 + 0.5 * len(claims)), dpi=96)
    ax = figure.subplots()
    for row, claim in enumerate(claims):
        part = verdicts.filter(claim=claim)
        spread = np.linspace(-0.28, 0.28, len(part))
        for one, up in zip(part.sort("superiority").iter_rows(named=True), spread, strict=True):
            original = one["map"] in ("corridor", "yard")
            ax.plot(
                one["superiority"],
                row + up,
                "D" if original else "o",
                color=_OUTCOMES[Outcome(one["outcome"])],
                markeredgecolor="#1f2430",
                markeredgewidth=1.4 if original else 0.4,
                markersize=7 if original else 6,
            )
    ax.axvline(0.5, color="#5b6270", linewidth=0.8)
    ax.set(
        xlim=(-0.02, 1.02),
        xlabel="probability of coming first (blue: p < 0.05, orange: opposite; ◆ built-in map)",
    )
    ax.set_yticks(range(len(claims)), claims, fontsize=8)
    ax.invert_yaxis()
    ax.spines[["top", "right", "left"]].set_visible(False)
    ax.tick_params(axis="y", length=0)
    figure.tight_layout()
    return figure


def curves_figure(
    panels: Mapping[str, Mapping[str, np.ndarray]], best: Mapping[str, float]
) -> Figure:
    """Learning curves: the interquartile mean of the return, and its 95 % bootstrap interval.

    Args:
        panels: by title, by the agent's name, float[runs, blocks], the mean returns over each 100
            episodes.
        best: the best return of each panel.
    """
    figure = Figure(figsize=(5.2 * len(panels), 4), dpi=96)
    axes = np.atleast_1d(figure.subplots(1, len(panels)))
    for ax, (title, agents) in zip(axes, panels.items(), strict=True):
        for (name, table), colour in zip(agents.items(), _COLOURS, strict=False):
            low, high = bootstrap_interval(table, interquartile_mean)
            x = 100 * (np.arange(table.shape[1]) + 1)
            ax.plot(x, interquartile_mean(table), color=colour, label=name, linewidth=1.4)
            ax.fill_between(x, low, high, color=colour, alpha=0.2, linewidth=0)
        longest = max(100 * table.shape[1] for table in agents.values())
        episodes_axis(ax.xaxis, "episodes (mean over each 100)", 100, longest)
        returns_axis(ax, best[title], "return" if ax is axes[0] else "")
        mark_best(ax, best[title])
        ax.set_title(title, fontsize=LABEL_SIZE)
        ax.legend(frameon=False, fontsize=8, loc="lower right")
        ax.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    return figure


def intervals_figure(panels: Mapping[str, pl.DataFrame], label: str) -> Figure:
    """Points with intervals, a row an agent.

    Args:
        panels: by title, "agent", "middle", "low", "high" (null: open), a "note" on the right, and
            whether it is "complete", all its runs having converged.
        label: of the horizontal axis.
    """
    heights = [0.9 + 0.26 * len(panel) for panel in panels.values()]
    figure = Figure(figsize=(10, sum(heights)), dpi=96)
    ratios = {"height_ratios": heights}
    axes = np.atleast_1d(figure.subplots(len(panels), 1, gridspec_kw=ratios))
    for ax, (title, panel) in zip(axes, panels.items(), strict=True):
        _intervals(ax, panel)
        ax.set_title(title, fontsize=LABEL_SIZE)
        lowest = panel.select(pl.min_horizontal("middle", "low").min()).item()
        low, high = (0.5, 1.0) if lowest is None else (0.9 * lowest, ax.get_xlim()[1])
        log_axis(ax.xaxis, label, low, high, _FINE if high / low < 5 else (1, 2, 5))
    figure.tight_layout()
    return figure


def _intervals(ax: Axes, panel: pl.DataFrame) -> None:
    ends = panel.select(pl.max_horizontal("middle", "high").max()).item()
    furthest = 1.5 * ends if ends is not None else 1.0  # where an open interval is drawn to
    for row, one in enumerate(panel.iter_rows(named=True)):
        colour = HOLDS if one["complete"] else OPPOSITE
        if one["middle"] is not None:
            high = furthest if one["high"] is None else one["high"]
            ax.plot([one["low"], high], [row, row], color=colour, linewidth=2.5, alpha=0.4)
            if one["high"] is None:
                ax.plot(high, row, ">", color=colour, markersize=5, alpha=0.6)
            ax.plot(one["middle"], row, "o", color=colour, markersize=6)
        ax.text(
            1.01,
            row,
            one["note"],
            transform=ax.get_yaxis_transform(),
            va="center",
            fontsize=8,
            color=colour,
        )
    ax.set_yticks(range(len(panel)), panel["agent"].to_list(), fontsize=8)
    ax.set_ylim(len(panel) - 0.5, -0.5)
    ax.spines[["top", "right", "left"]].set_visible(False)
    ax.tick_params(axis="y", length=0)
