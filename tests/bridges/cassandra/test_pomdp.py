"""Files in Cassandra's format: read as they are meant, or refused with the line and the fix."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb

TIGER = """\
# Cassandra, Kaelbling and Littman's tiger, in rows and matrices.
discount: 0.95
values: reward
states: tiger-left tiger-right
actions: listen open-left open-right
observations: hear-left hear-right

T: listen
identity
T:open-left uniform
T: open-right
uniform

O: listen
0.85 0.15
0.15 0.85
O: open-left uniform
O: open-right uniform

R: listen : * : * : * -1
R: open-left : tiger-left : * : * -100
R: open-left : tiger-right : * : * 10
R: open-right:tiger-left:*:* 10
R: open-right : tiger-right : * : * -100
"""

TIGER_IN_ENTRIES = (
    """\
values: cost states: 2 actions: 3
observations: 2 discount: 0.95   # one line break is as good as another
start: 0.5
  0.5
T: * : * : * 0.5
T: listen-does-not-exist-here-so-0 : 0 : 0 1
""".replace("listen-does-not-exist-here-so-0", "0")
    + """\
T: 0 : 1 : 0 0   T: 0 : 1 : 1 1.0 T: 0 : 0 : 1 0
O: * : * : 0 0.5 O: * : * : 1 5e-1
O: 0 : 0 0.85
0.15
O: 0 : 1 : 0 .15
O: 0 : 1 : 1 + 0.85
R: * : * : * : * 1
R: 1 : 0
 100 100
 100 100
R: 1 : 1 : * - 10 -10
R: 2 : 0 : * : 0 -10
R: 2 : 0 : * : 1 -10
R: 2 : 1 : 0 100 100
R: 2 : 1 : 1 100 100
"""
)

MAZE = """\
discount: 1
values: reward
states: west middle east goal
actions: w e
start: west
T: w
1 0 0 0
1 0 0 0
0 0.9 0.1 0
0 0 0 1
T: e : west 0 1 0 0
T: e : middle
0 0.1 0.9 0
T: e : east : goal 1.0
T: e : goal reset
R: * : * : * -1
R: * : * : goal 5
R: w : goal 0 0 0 0
"""


def load(folder: Path, text: str, name: str = "m.pomdp") -> hb.POMDP:
    (folder / name).write_text(text, "utf-8")
    return hb.load_pomdp(folder / name)


def sensor_of(model: hb.POMDP) -> np.ndarray:
    assert isinstance(model.sensor, np.ndarray)
    return model.sensor


def test_tiger_is_what_its_authors_describe(tmp_path: Path):
    tiger = load(tmp_path, TIGER)
    mdp = tiger.mdp
    assert mdp.actions == ("listen", "open-left", "open-right")
    assert tiger.observations == ("hear-left", "hear-right")
    assert tiger.discount == 0.95
    assert tiger.belief.tolist() == [0.5, 0.5]
    assert mdp.transition(0).toarray().tolist() == np.eye(2).tolist()
    assert (mdp.transition(1).toarray() == 0.5).all()
    assert mdp.reward.tolist() == [[-1, -100, 10], [-1, 10, -100]]
    assert np.allclose(sensor_of(tiger)[0], [[0.85, 0.15], [0.15, 0.85]])
    assert (sensor_of(tiger)[1:] == 0.5).all()
    assert (mdp.state(1), mdp.index("tiger-left")) == ("tiger-right", 0)
    assert not mdp.terminal.any()


def test_the_same_model_in_entries_numbers_and_costs_is_the_same(tmp_path: Path):
    one, other = load(tmp_path, TIGER), load(tmp_path, TIGER_IN_ENTRIES)
    for action in range(3):
        assert np.array_equal(
            one.mdp.transition(action).toarray(), other.mdp.transition(action).toarray()
        )
    assert np.allclose(sensor_of(one), sensor_of(other))
    assert np.array_equal(one.mdp.reward, other.mdp.reward)
    assert np.array_equal(one.belief, other.belief)
    assert other.mdp.actions == other.observations == ()


def test_the_best_return_of_tiger_is_the_published_one(tmp_path: Path):
    # After n more growls from the left than from the right, the belief depends on n alone.
    # SARSOP and others publish 19.37 for the uniform belief.
    tiger = load(tmp_path, TIGER)
    reward, hears = tiger.mdp.reward.astype(float), sensor_of(tiger)[0]
    leads = np.arange(-12, 13)
    left = hears[0, 0] ** leads / (hears[0, 0] ** leads + hears[1, 0] ** leads)
    belief = np.stack([left, 1 - left], axis=1)
    value = np.zeros(len(leads))
    for _ in range(600):
        heard = belief @ hears
        more, less = value[np.minimum(leads + 13, 24)], value[np.maximum(leads + 11, 0)]
        listening = heard[:, 0] * more + heard[:, 1] * less
        following = np.stack([listening, *[np.full(len(leads), value[12])] * 2], axis=1)
        value = (belief @ reward + tiger.discount * following).max(axis=1)
    assert value[12] == pytest.approx(19.3713, abs=1e-3)


def test_tigers_empowerment_is_what_a_door_changes_and_a_listen_shows(tmp_path: Path):
    tiger = load(tmp_path, TIGER)
    one = hb.capacity([[0.85, 0.15], [0.5, 0.5]]).bits
    bits = hb.empowerment(tiger.mdp, 1, sensor_of(tiger))
    assert np.allclose(bits, one, atol=1e-6)
    # A second action shows where the tiger is, but no door decides where that will be.
    assert np.allclose(hb.empowerment(tiger.mdp, 2, sensor_of(tiger)), one, atol=1e-6)


def test_an_mdp_is_seen_as_it_is(tmp_path: Path):
    maze = load(tmp_path, MAZE, "maze.mdp")
    assert (maze.sensor, maze.observations, maze.discount) == ("state", (), 1.0)
    assert maze.mdp.start == 0
    assert maze.belief.tolist() == [1, 0, 0, 0]
    assert maze.mdp.transition(1).toarray().tolist() == [
        [0, 1, 0, 0],
        [0, 0.1, 0.9, 0],
        [0, 0, 0, 1],
        [1, 0, 0, 0],
    ]
    assert np.allclose(maze.mdp.reward, [[-1, -1], [-1, -1], [-1, 5], [0, -1]])
    assert hb.empowerment(maze.mdp, 1, maze.sensor, states=[0]) == pytest.approx(1, abs=1e-6)


def test_a_sensor_that_all_actions_share_has_no_actions(tmp_path: Path):
    text = TIGER.replace("O: open-left uniform\nO: open-right uniform", "O: * \n.7 .3\n0 1")
    model = load(tmp_path, text)
    assert np.allclose(sensor_of(model), [[0.7, 0.3], [0, 1]])


@pytest.mark.parametrize(
    ("start", "belief"),
    [
        ("", [0.25] * 4),
        ("start: uniform", [0.25] * 4),
        ("start: 0.1 0.2\n0.3 0.4", [0.1, 0.2, 0.3, 0.4]),
        ("start: 0.333333 0.333333 0 0.333333", [1 / 3, 1 / 3, 0, 1 / 3]),
        ("start: middle", [0, 1, 0, 0]),
        ("start: 2", [0, 0, 1, 0]),
        ("start include: west 3", [0.5, 0, 0, 0.5]),
        ("start\ninclude : goal # alone", [0, 0, 0, 1]),
        ("start exclude: goal", [1 / 3, 1 / 3, 1 / 3, 0]),
        ("start exclude: goal 0 east", [0, 1, 0, 0]),
        ("start include: *", [0.25] * 4),
    ],
)
def test_every_form_of_start_is_a_belief(tmp_path: Path, start: str, belief: list[float]):
    model = load(tmp_path, MAZE.replace("start: west", start).replace("reset", "uniform"))
    assert np.allclose(model.belief, belief)
    assert model.mdp.start == int(np.argmax(belief))


def test_one_state_is_certain(tmp_path: Path):
    text = "discount: 0 values: reward states: 1 actions: 1 {} T: 0 identity R: 0 : 0 3"
    for start in ("", "start: 1.0", "start: uniform"):
        assert load(tmp_path, text.format(start)).belief.tolist() == [1]


@st.composite
def models(draw) -> tuple[str, np.ndarray, np.ndarray | None, np.ndarray]:
    """A file of entries in all forms, with dense T, O and R[a, s, s', o] filled as they come."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    states, actions, seen = (int(rng.integers(1, 5)) for _ in range(3))
    partly = bool(rng.random() < 0.7)
    names = [f"s{i}" for i in range(states)] if rng.random() < 0.5 else []
    said = [f"states: {' '.join(names) or states}", f"actions: {actions}", "values: reward"]
    said += ["discount: 0.5"] + [f"observations: {seen}"] * partly
    said = [said[i] for i in rng.permutation(len(said))]
    T, shows = np.zeros((actions, states, states)), np.zeros((actions, states, seen))
    R = np.zeros((actions, states, states, seen if partly else 1))

    def pick(count: int, names: list[str] = names) -> tuple[slice | int, str]:
        if rng.random() < 0.4:
            return slice(None), "*"
        index = int(rng.integers(count))
        return index, names[index] if names and rng.random() < 0.5 else str(index)

    def rows(shape: tuple[int, ...]) -> np.ndarray:
        whole = rng.multinomial(1000, rng.dirichlet(np.full(shape[-1], 0.5)), shape[:-1])
        return whole / 1000

    def text(values: np.ndarray) -> str:
        return "\n".join(" ".join(map(str, row)) for row in np.atleast_2d(values).tolist())

    def distributions(kind: str, table: np.ndarray) -> None:
        width = table.shape[-1]
        for turn in range(int(rng.integers(1, 6))):
            (a, action), (s, state) = pick(actions, []), pick(states)
            form = rng.integers(4) if turn else 0
            if turn == 0:
                a, action = slice(None), "*"
            if form == 0:
                values = rows((states, width))
                table[a] = values
                said.append(f"{kind}: {action}\n{text(values)}")
            elif form == 1:
                table[a] = 1 / width
                said.append(f"{kind}: {action} uniform")
            elif form == 2 and kind == "T":
                table[a] = np.eye(width)
                said.append(f"T :{action}  identity")
            else:
                values = rows((width,))
                table[a, s] = values
                if rng.random() < 0.5:
                    said.append(f"{kind}: {action} : {state}\n{text(values)}")
                else:
                    said.extend(
                        f"{kind}:{action}:{state}:{i} {p}" for i, p in enumerate(values.tolist())
                    )

    distributions("T", T)
    if partly:
        distributions("O", shows)
    for _ in range(int(rng.integers(0, 8))):
        (a, action), (s, state), (n, following) = pick(actions, []), pick(states), pick(states)
        o, observation = pick(seen, [])
        depth = int(rng.integers(2, 5)) if partly else int(rng.integers(1, 4))
        where = (a, s, n, o)[:depth]
        words = (action, state, following, observation)[:depth]
        shape = R.shape[depth:] if partly else R.shape[depth:3]
        values = rng.integers(-9, 10, size=shape) / 4
        R[where] = values if partly or not shape else values[..., None]
        said.append(f"R: {' : '.join(words)}\n{text(values)}")
    return "\n".join(said), T, shows if partly else None, R


@settings(max_examples=150, deadline=None)
@given(models())
def test_entries_in_every_form_fill_the_arrays_in_their_order(tmp_path_factory, case):
    text, T, shows, R = case
    model = load(tmp_path_factory.mktemp("models"), text)
    mdp = model.mdp
    found = np.stack([mdp.transition(action).toarray() for action in range(mdp.action_count)])
    assert np.allclose(found, T, atol=2e-5)
    seen = np.ones((*T.shape[:2], 1)) if shows is None else shows
    mean = np.einsum("ast,ato,asto->sa", T, seen, R)
    assert np.allclose(mdp.reward, mean, atol=1e-3)
    if shows is None:
        assert isinstance(model.sensor, str)
    else:
        assert np.allclose(sensor_of(model), shows, atol=2e-5)


def changed(old: str, new: str, text: str = TIGER) -> str:
    assert old in text
    return text.replace(old, new, 1)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", r"m\.pomdp: has no discount; add a line discount: 0\.95"),
        (changed("values: reward\n", ""), "has no values; add a line"),
        (changed("discount: 0.95", "discount: 1.5"), "line 2: discount is 1.5; give a number"),
        (changed("discount: 0.95", "discount: x"), "line 2: discount needs a number, and 'x'"),
        (changed("values: reward", "values: money"), "line 3: values is 'money'; write reward"),
        (changed("values: reward", "values reward"), "line 3: 'values' begins no part"),
        (changed("values: reward", "values: reward\nvalues: cost"), "line 4: values: is there twi"),
        (changed("states: tiger-left", "states: T"), "line 4: 'T' in states: cannot be a name"),
        (changed("states: tiger-left", "states: 7th 3"), "line 4: '3' in states: cannot be a"),
        (changed("tiger-left tiger-right", "one one"), "line 4: 'one' in states: is there twice"),
        (changed("tiger-left tiger-right", "2 3"), "line 4: 3 follows the number of states"),
        (changed("tiger-left tiger-right", "0"), "line 4: there are 0 states"),
        (changed("tiger-left tiger-right", ""), "line 4: states: is empty"),
        ("discount: 1 values: cost actions: 2", "has no states; add a line"),
        ("T: 0 identity", "line 1: T: comes before actions:; put actions: above it"),
        ("start: uniform", "line 1: start: comes before states:"),
        (TIGER + "states: 3", "states: is there twice; remove one"),
        (TIGER + "start: uniform", "line 25: start: comes after T: of line 8; put it above"),
        (changed("T: listen", "T: lisen"), "line 8: 'lisen' is none of the actions; use listen, o"),
        (changed("T:open-left uniform", "T: 3 uniform"), "line 10: '3' is none of the actions"),
        (changed("identity", "1 0 0"), "line 10: T: over states and states needs 4 numbers, and"),
        (changed("identity", "1 0 0 1 1"), "line 9: '1' follows 4 of 4 numbers"),
        (changed("identity", "1 0 0 nan"), "line 9: T: .* and 'nan' follows 3; give all"),
        (changed("identity", "1 0 0 1_0"), "line 9: T: .* and '1_0' follows 3; give all"),
        (changed("identity", "1 0 2 -1"), "line 8: T: has 2; probabilities are from 0 to 1"),
        (changed("identity", "1 0 0.5 0.4"), "line 8: .* T: listen : tiger-right sum to 0.9; make"),
        (changed("0.85 0.15", "0.85 0.25"), "line 14: .* O: listen : tiger-left sum to 1.1"),
        (changed("O: open-left uniform", "O: open-left identity"), "line 17: O: .* and 'identity'"),
        (changed("T:open-left uniform\n", ""), "T: open-left : tiger-left is given nowhere; add"),
        (changed("O: open-left uniform\n", ""), "O: open-left : tiger-left is given nowhere"),
        (changed("R: listen : * : * : * -1", "R: listen 1"), "line 20: R: needs an action and"),
        (changed(": * -1\n", ": * uniform\n"), "line 20: R: needs a number, and 'uniform' follows"),
        (changed(": * -1\n", ": * : * -1\n"), "line 20: R: needs a number, and ':' follows 0"),
        (changed("O: listen", "O: listen", MAZE + "O: listen"), "O: comes before observations:"),
        (TIGER + "garbage", "line 25: 'garbage' follows 1 of 1 numbers of R:; remove it"),
        (TIGER + "R: 0 : 0 : 0 : 0", "and the end of the file follows 0; give all of them"),
        (changed("start: west", "start: 0.5 0.5", MAZE), "line 5: start has 2 entries; give a"),
        (changed("start: west", "start: 1 1 0 0", MAZE), "line 5: start is not a distribution"),
        (changed("start: west", "start: 2 0 0 -1", MAZE), "line 5: start is not a distribution"),
        (changed("start: west", "start: north", MAZE), "line 5: 'north' is none of the states"),
        (changed("start: west", "start: *", MAZE), "line 5: start is \\*; write uniform"),
        (changed("start: west", "start include: up", MAZE), "line 5: 'up' is none of the states"),
        (changed("start: west", "start include:", MAZE), "line 5: start include: leaves no state"),
        (changed("start: west", "start exclude: *", MAZE), "start exclude: leaves no state"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path: Path, text: str, reason: str):
    with pytest.raises(ValueError, match=reason) as caught:
        load(tmp_path, text)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(str(tmp_path / "m.pomdp"))


def test_a_sensor_too_large_for_any_machine_is_refused(tmp_path: Path):
    text = "discount: 1 values: cost states: 2 actions: 1 observations: 800000000 T: * identity"
    with pytest.raises(ValueError, match="are a sensor of 12 GiB; give a smaller model"):
        load(tmp_path, text)


def test_a_large_sparse_model_takes_no_dense_transitions(tmp_path: Path):
    count = 1000
    steps = "\n".join(f"T: * : {s} : {min(s + 1, count - 1)} 1" for s in range(count))
    text = f"discount: 1 values: reward states: {count} actions: 2 observations: 2 O: * uniform\n"
    model = load(tmp_path, text + steps + f"\nR: * : * : {count - 1} : * 1")
    assert model.mdp.next_state[:, 1].tolist() == [*range(1, count), count - 1]
    assert model.mdp.reward[-2:].tolist() == [[1, 1], [1, 1]]
    assert model.mdp.reward.sum() == 4


def test_where_there_is_no_text_says_so(tmp_path: Path):
    (tmp_path / "m.pomdp").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(ValueError, match="is not a text file"):
        hb.load_pomdp(tmp_path / "m.pomdp")
    with pytest.raises(ValueError, match=r"none\.pomdp: cannot be read \(No such file"):
        hb.load_pomdp(tmp_path / "none.pomdp")
