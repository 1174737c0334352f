"""The planar world: what the hand can reach, with which tool, and how models are read."""

from pathlib import Path

import numpy as np
import pytest

from habilis.estimators import Counting
from habilis.robots import PushingSimulator, Reach, puck_placements, push_plan, push_scene, tools_of
from habilis.robots.scene import bodies_at
from habilis.worlds.pictures import save_picture

pytest.importorskip("mujoco")

WEST, EAST, SOUTH, NORTH = 2, 1, 4, 3
PLAIN = """<mujoco><worldbody>
<body name="hand"><joint name="x" type="slide" axis="1 0 0"/><geom size="0.1"/>{hand}</body>
<body name="puck">{puck}<geom size="0.1"/></body></worldbody>
<actuator><velocity joint="x" kv="10" {limits}/></actuator></mujoco>"""
SLIDES = """<joint type="slide" axis="1 0 0" range="-1 1"/>
<joint type="slide" axis="0 1 0" range="{}"/>"""


def moved(simulator: PushingSimulator, position: list[float], actions: list[int]) -> np.ndarray:
    """Where the puck is after actions."""
    chosen = simulator.actions[np.array(actions)]
    return simulator.rollout(simulator.placed([position]), chosen[None])[0, simulator.puck]


def test_an_action_moves_the_hand_by_a_tenth_and_leaves_it_at_rest():
    simulator = PushingSimulator("reach.xml")
    start = simulator.placed([[0.3, 0.9]] * 5)
    after = simulator.step(start, simulator.actions)
    np.testing.assert_allclose((after - start)[:, :2], 0.1 * simulator.actions, atol=0.002)
    np.testing.assert_array_equal(after[:, 2:], start[:, 2:])


def test_the_bare_hand_has_influence_within_its_reach_only():
    world = Reach()
    simulator = PushingSimulator(world.xml())
    counted = Counting(0.05, 100).fit(simulator, 8, "puck")
    near = world.reach + 2 * world.radius
    bits = counted.bits(simulator.placed([[0.0, near - 0.02], [0.0, near + 0.02]]))
    assert bits[0] >= 1
    assert bits[1] == 0


def test_the_hook_pulls_what_the_stick_can_only_push():
    puck = [-0.06, 0.45]
    pull = [EAST, NORTH, WEST, SOUTH]
    after = {
        tool: moved(PushingSimulator("reach.xml", tool), puck, pull) for tool in ("none", "hook")
    }
    np.testing.assert_array_equal(after["none"], puck)
    goal = [0.1, 0.4]
    hook, stick = (PushingSimulator("reach.xml", tool) for tool in ("hook", "stick"))
    start = hook.placed([[0.1, 0.7]])[0]
    plan = push_plan(hook, start, goal)
    np.testing.assert_allclose(moved(hook, [0.1, 0.7], list(plan)), goal, atol=0.025 + 1e-9)
    with pytest.raises(ValueError, match="no sequence of 8 actions is found"):
        push_plan(stick, start, goal, 8, sequences=300)


def test_the_puck_stays_on_the_table_and_out_of_the_wall():
    world = Reach()
    simulator = PushingSimulator("reach.xml", "stick")
    generator = np.random.default_rng(0)
    actions = simulator.actions[generator.integers(5, size=(200, 12))]
    where = simulator.rollout(simulator.placed([[0.1, 0.75]] * 200), actions)[:, simulator.puck]
    assert len(np.unique(where, axis=0)) > 10
    assert (np.abs(where[:, 0]) < world.side / 2 - world.radius / 2).all()
    assert (where[:, 1] < world.side - world.radius / 2).all()
    closed = where[:, 0] < world.side / 2 - world.opening - world.radius / 2
    assert (np.abs(where[closed, 1] - world.wall) > world.radius / 2).all()


def test_a_search_of_few_sequences_counts_what_all_of_them_reach():
    simulator = PushingSimulator("reach.xml", "scoop")
    start = simulator.placed([[0.02, 0.66]])
    every = np.stack(np.meshgrid(*[np.arange(5)] * 3), axis=-1).reshape(-1, 3)
    last = simulator.rollout(np.repeat(start, 125, axis=0), simulator.actions[every])
    cells = np.unique(np.rint(last[:, simulator.puck] / 0.05), axis=0)
    assert len(cells) > 3
    found = Counting(0.05, 1000).fit(simulator, 3, "puck").bits(start)
    np.testing.assert_allclose(found, np.log2(len(cells)))


def test_noise_is_added_to_the_controls_that_an_action_holds():
    still, noisy = PushingSimulator("reach.xml"), PushingSimulator("reach.xml", noise=0.1)
    start, action = still.placed([[0.3, 0.9]] * 400), still.actions[[1] * 400]
    assert (still.is_stochastic, noisy.is_stochastic, noisy.noise) == (False, True, 2)
    drawn = noisy.step(start, action, np.random.default_rng(0))[:, :2]
    assert drawn.std(axis=0) == pytest.approx([0.01, 0.01], rel=0.15)
    none = noisy.transition(start[:1], action[:1], np.zeros((1, 2)))
    np.testing.assert_allclose(none, still.step(start[:1], action[:1]), atol=0.001)


def test_the_tools_of_a_model_are_the_first_words_of_its_hands_geoms():
    geoms = '<geom name="hand palm" size="0.1"/><geom name="rake" size="0.1"/>'
    geoms += '<body><geom name="rake tooth" size="0.1"/><geom name="net" size="0.1"/></body>'
    text = PLAIN.format(hand=geoms, puck=SLIDES.format("0 1"), limits='ctrlrange="-1 1"')
    assert tools_of(text) == ["rake", "net"]
    counts = {tool: PushingSimulator(text, tool).model.ngeom for tool in ("none", "rake", "net")}
    assert counts == {"none": 3, "rake": 5, "net": 4}


@pytest.mark.parametrize(
    ("puck", "limits", "words"),
    [
        ("<freejoint/>", 'ctrlrange="-1 1"', "two slide joints, each with a range"),
        (SLIDES.format("0 0"), 'ctrlrange="-1 1"', "two slide joints, each with a range"),
        (SLIDES.format("0 1"), "", "an actuator has no ctrlrange"),
    ],
)
def test_models_of_another_kind_are_refused(puck: str, limits: str, words: str):
    with pytest.raises(ValueError, match=words):
        PushingSimulator(PLAIN.format(hand="", puck=puck, limits=limits))


def test_dimensions_that_leave_no_room_are_refused():
    with pytest.raises(ValueError, match="leave 3 \\* radius between reach and wall"):
        Reach(reach=0.58)


def test_placements_are_one_a_square_and_free_with_every_tool():
    simulators = [PushingSimulator("reach.xml", tool) for tool in ("none", "stick", "scoop")]
    found, again = puck_placements(simulators, 6, seed=3), puck_placements(simulators, 6, seed=3)
    np.testing.assert_array_equal(found.positions, again.positions)
    assert 30 <= len(found.positions) <= 36
    inside = (found.positions - found.low) / (found.high - found.low) * found.side
    np.testing.assert_array_equal(np.floor(inside), found.squares)
    # A placed puck that touches nothing stays where it is.
    for simulator in simulators:
        start = simulator.placed(found.positions)
        after = simulator.step(start, np.zeros((len(start), 2)))
        np.testing.assert_allclose(after, start, atol=simulator.grain / 2 + 1e-9)


def test_a_picture_has_the_tool_and_the_puck_where_they_are(tmp_path: Path):
    bare, hook = (PushingSimulator("reach.xml", tool) for tool in ("none", "hook"))
    state = hook.placed([[0.2, 0.8]])[0]
    scene = push_scene(hook, state, np.array([0.0, 0.3]))
    assert (scene.width, scene.height) == (12, 12)
    assert len(scene.shapes) == len(push_scene(bare, state).shapes) + 4
    x, y = np.mean(scene.shapes[-2].points, axis=0)
    assert (x, y) == pytest.approx((1 + (0.2 + 0.46) / 0.092, 12 - 1 - (0.8 - 0.04) / 0.092))
    np.testing.assert_allclose(bodies_at(hook, state)[1][:2], [0.2, 0.8])
    save_picture(scene, tmp_path / "hook.png")
    assert (tmp_path / "hook.png").stat().st_size > 500
