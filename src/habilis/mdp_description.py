"""What there is in a table, in words."""

from typing import TYPE_CHECKING

from habilis.reprs import counted, listed

if TYPE_CHECKING:
    from habilis.mdp import TabularMDP


def described(mdp: "TabularMDP") -> list[str]:
    """What there is of it, in a few words each."""
    actions = counted(mdp.action_count, "action")
    return [
        f"{counted(mdp.states, 'state')}, {actions}, {_kind(mdp)}",
        f"players {_players(mdp)}" if mdp.players else "",
        f"factors {listed(mdp.factors)}" if mdp.factors else "",
        f"flags {listed(mdp.flags)}" if mdp.flags else "",
        f"start {_state(mdp, mdp.start)}",
    ]


def contents(mdp: "TabularMDP") -> dict[str, str]:
    """The same by name, with the names of the actions."""
    names = f": {listed(mdp.actions)}" if mdp.actions else ""
    return {
        "states": f"{mdp.states:,}",
        "actions": f"{mdp.action_count}{names}",
        **({"players": _players(mdp)} if mdp.players else {}),
        "transitions": _kind(mdp),
        "factors": listed(mdp.factors),
        "flags": listed(mdp.flags),
        "start": _state(mdp, mdp.start),
    }


def _kind(mdp: "TabularMDP") -> str:
    return "stochastic" if mdp.is_stochastic else "deterministic"


def _players(mdp: "TabularMDP") -> str:
    """Who acts, with how many actions each."""
    return listed(f"{name} ({counted(count, 'action')})" for name, count in mdp.players.items())


def _state(mdp: "TabularMDP", state: int) -> str:
    """A state, with the cells and labels that its factors have."""
    values = []
    for name, factor in mdp.factors.items():
        label = int(factor[state])
        of_map = mdp.shape if mdp.is_cell(name) else None
        values.append(f"{name} {label if of_map is None else divmod(label, of_map[1])}")
    return f"{state:,}: {listed(values)}" if values else f"{state:,}"
