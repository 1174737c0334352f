"""Models in PRISM's language, JANI or Storm's explicit formats, through `stormpy` (2.0 or newer).

`TabularMDP.from_storm` describes what becomes of them.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64
from scipy.sparse import csr_array

from habilis.extras import import_from
from habilis.files import shown
from habilis.mdp import TabularMDP

UNLABELLED = "[]"
"""The name of a choice without a label, as PRISM writes it."""

_DEADLOCK = "deadlock"
_KINDS = ("DTMC", "MDP", "POMDP")
_LARGEST = 2**31 - 1


def table_of(model: Any, constants: str, reward: str | None, terminal: str | None) -> TabularMDP:
    """`TabularMDP.from_storm`; see there."""
    sparse = _built(model, constants)
    kind = str(sparse.model_type).rpartition(".")[2]
    if kind not in _KINDS or sparse.has_parameters or sparse.supports_uncertainty:
        what = "parametric" if sparse.has_parameters else "interval"
        known = what if kind in _KINDS else f"a {kind}"
        raise ValueError(f"the model is {known}; give one of {', '.join(_KINDS)}, with numbers")
    initial = list(sparse.initial_states)
    if len(initial) != 1:
        raise ValueError(f"the model has {len(initial)} initial states; give it one")
    flags = _flags(sparse)
    if terminal is not None and terminal not in flags:
        known = ", ".join(sorted(flags)) or "none"
        raise ValueError(f"terminal is {terminal!r}, which is not a label; the model has {known}")
    state, action, names = _choices(sparse)
    each = _transitions(sparse, state, action, len(names) or int(action.max()) + 1)
    mean = np.zeros((sparse.nr_states, len(each)))
    chosen = action >= 0
    mean[state[chosen], action[chosen]] = _rewards(sparse, state, reward)[chosen]
    ends = None if terminal is None else flags[terminal]
    mdp = TabularMDP.stochastic(each, mean, terminal=ends, start=int(initial[0]))
    return replace(mdp, factors=_factors(sparse), flags=flags, actions=names)


def _built(model: Any, constants: str) -> Any:
    """A sparse model of Storm's."""
    stormpy = import_from("stormpy", "storm")
    developer = import_from("stormpy.developer", "storm")
    if not isinstance(model, str | Path):
        if getattr(model, "is_sparse_model", False):
            return _without_constants(model, constants)
        if isinstance(model, (developer.storage.PrismProgram, developer.storage.JaniModel)):
            return _reported("the model", lambda: _from_program(model, constants))
        raise ValueError(
            f"{type(model).__name__} is not a model of Storm's; give a path, a PrismProgram, a "
            "JaniModel or a sparse model"
        )
    path, name = Path(model), shown(model) if str(model) else "''"
    if not path.is_file():
        raise ValueError(f"{name}: there is no such file; name one with a model for Storm")
    if path.suffix == ".drn":
        options = developer.DirectEncodingParserOptions()
        options.build_choice_labeling = _counts_choices(path)
        built = _reported(name, lambda: stormpy.build_model_from_drn(str(path), options=options))
        return _without_constants(built, constants)
    if path.suffix == ".tra":
        labels = path.with_suffix(".lab")
        if not labels.is_file():
            raise ValueError(f"{name}: {labels.name} is missing; put the labels beside it")
        built = _reported(name, lambda: stormpy.build_model_from_explicit(str(path), str(labels)))
        return _without_constants(built, constants)
    if path.suffix == ".jani":
        program = _reported(name, lambda: stormpy.parse_jani_model(str(path))[0])
    else:
        program = _reported(name, lambda: stormpy.parse_prism_program(str(path)))
    return _reported(name, lambda: _from_program(program, constants))


def _counts_choices(path: Path) -> bool:
    """Whether a .drn file declares how many choices it has: without it, Storm reads no labels."""
    with path.open("rb") as file:
        return b"@nr_choices" in file.read(1 << 16)


def _reported(name: str, work: Callable[[], Any]) -> Any:
    """What `work` returns; an error of Storm's in one line."""
    try:
        return work()
    except (RuntimeError, TypeError) as error:  # StormError is a RuntimeError, as are C++'s
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(f"{name}: Storm refuses it: {shown(reason)}; correct it") from None


def _from_program(program: Any, constants: str) -> Any:
    stormpy = import_from("stormpy", "storm")
    if constants:
        program, _ = stormpy.instantiate_constants(program, constants)
    missing = [constant.name for constant in program.constants if not constant.defined]
    if missing:
        example = ",".join(f"{name}=4" for name in missing)
        raise ValueError(
            f"the model has constants without a value ({', '.join(missing)}); give these, as "
            f"constants={example!r}"
        )
    options = stormpy.BuilderOptions(build_full=True)
    return stormpy.build_model(program, options=options)


def _without_constants(built: Any, constants: str) -> Any:
    if constants:
        raise ValueError(
            f"constants are {constants!r}, but an explicit model has none; leave them out"
        )
    return built


def _choices(
    sparse: Any,
) -> tuple[Int64[np.ndarray, "C"], Int64[np.ndarray, "C"], tuple[str, ...]]:
    """The state and the action of each choice (-1: none, in a deadlock), and the actions' names.

    An action is a label; the second choice of a state with the same label is a second action. A
    DTMC has one action.
    """
    count = sparse.nr_states
    first = (
        np.asarray(sparse.nondeterministic_choice_indices, np.int64)
        if sparse.is_nondeterministic_model
        else np.arange(count + 1)
    )
    state = np.repeat(np.arange(count), np.diff(first))
    stuck = np.zeros(count, bool)
    if sparse.labeling.contains_label(_DEADLOCK):
        stuck[list(sparse.labeling.get_states(_DEADLOCK))] = True
    labelled = sparse.is_nondeterministic_model and sparse.has_choice_labeling()
    labelled = labelled and bool(sparse.choice_labeling.get_labels())
    numbers: dict[str, int] = {}
    action = np.full(len(state), -1, np.int64)
    for s in range(count):
        if stuck[s]:
            continue
        seen: Counter[str] = Counter()
        for choice in range(first[s], first[s + 1]):
            label = UNLABELLED
            if labelled and (labels := sparse.choice_labeling.get_labels_of_choice(choice)):
                label = " ".join(sorted(labels))
            seen[label] += 1
            name = label if seen[label] == 1 else f"{label} {seen[label]}"
            action[choice] = numbers.setdefault(name, len(numbers))
    if not numbers:
        raise ValueError("every state of the model is a deadlock; give one with actions")
    return state, action, tuple(numbers) if labelled else ()


def _transitions(
    sparse: Any, state: Int64[np.ndarray, "C"], action: Int64[np.ndarray, "C"], actions: int
) -> list[csr_array]:
    """The transition matrix [S, S] of each action, without rows where it is not available."""
    matrix, states = sparse.transition_matrix, sparse.nr_states
    rows, columns, weights = [], [], []
    for row in range(matrix.nr_rows):
        for entry in matrix.get_row(row):
            rows.append(row)
            columns.append(entry.column)
            weights.append(float(entry.value))
    choice, column, weight = np.array(rows), np.array(columns), np.array(weights)
    each = []
    for number in range(actions):
        of = action[choice] == number
        place = state[choice[of]], column[of]
        each.append(csr_array((weight[of], place), (states, states)))
    return each


def _rewards(
    sparse: Any, state: Int64[np.ndarray, "C"], name: str | None
) -> Float64[np.ndarray, "C"]:
    """The reward of each choice."""
    models = dict(sparse.reward_models)
    known = ", ".join(repr(one) for one in sorted(models)) or "none"
    if name is None and len(models) > 1:
        raise ValueError(f"the model has several reward models; name one of {known} with reward=")
    if name is None and not models:
        return np.zeros(len(state))
    if name is not None and name not in models:
        raise ValueError(f"reward is {name!r}, which the model does not have; it has {known}")
    found = models[name] if name is not None else next(iter(models.values()))
    if found.has_transition_rewards:
        raise ValueError(
            f"reward {name or known} depends on next states; give one of states and actions"
        )
    total = np.zeros(len(state))
    if found.has_state_rewards:
        total += np.array([float(one) for one in found.state_rewards])[state]
    if found.has_state_action_rewards:
        total += np.array([float(one) for one in found.state_action_rewards])
    return total


def _flags(sparse: Any) -> dict[str, Bool[np.ndarray, "S"]]:
    """The labels of states, but for that of the initial one."""
    flags = {}
    for label in sorted(sparse.labeling.get_labels() - {"init"}):
        flags[label] = np.zeros(sparse.nr_states, bool)
        flags[label][list(sparse.labeling.get_states(label))] = True
    return flags


def _factors(sparse: Any) -> dict[str, Int32[np.ndarray, "S"]]:
    """The variables of each state, and what is observed in a POMDP."""
    factors = {}
    if sparse.has_state_valuations():
        valuations = sparse.state_valuations
        for variable in valuations.get_all_variables():
            factors[variable.name] = _labels(valuations.get_values_states(variable))
    if sparse.is_partially_observable:
        factors.setdefault("observation", _labels(list(sparse.observations)))
    return dict(sorted(factors.items()))


def _labels(values: list[Any]) -> Int32[np.ndarray, "S"]:
    """Values as labels: whole numbers and truth values as they are, others by their order."""
    if all(isinstance(value, int) and abs(value) <= _LARGEST for value in values):
        return np.array(values, np.int32)
    ordered = {value: i for i, value in enumerate(sorted(set(values)))}
    return np.array([ordered[value] for value in values], np.int32)
