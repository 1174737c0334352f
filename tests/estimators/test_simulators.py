"""Simulators: each against its equations or the thing that it is made of."""

import os
import subprocess
import sys
from ctypes.util import find_library
from types import SimpleNamespace
from typing import Any

import gymnasium
import jax
import numpy as np
import pytest

import habilis as hb
from habilis.estimators import ActionBox, simulators
from habilis.estimators.rollouts import outcomes_of, roll_out
from habilis.estimators.sensors import reading
from habilis.worlds.pictures import save_picture

mujoco: Any = pytest.importorskip("mujoco")  # its stubs are incomplete

SLIDER = """
<mujoco>
  <option timestep="0.01"/>
  <worldbody>
    <body name="puck">
      <joint name="x" type="slide" axis="1 0 0"/><joint name="y" type="slide" axis="0 1 0"/>
      <geom size="0.1" mass="2"/>
    </body>
  </worldbody>
  <actuator><motor joint="x" ctrlrange="-1 1"/><motor joint="y"/></actuator>
  <sensor><framepos name="place" objtype="body" objname="puck"/></sensor>
</mujoco>
"""
CLASSICS = (
    simulators.double_integrator,
    simulators.pendulum,
    simulators.cart_pole,
    simulators.ball_in_box,
)


def states_of(simulator, count=5, seed=0):
    return simulator.random_states(count, np.random.default_rng(seed))


def rolled(simulator, states, sequences, seed=0):
    return roll_out(simulator, np.asarray(states, float), np.asarray(sequences, float), seed)


def test_the_double_integrator_moves_as_a_mass_does():
    simulator = simulators.double_integrator(dt=0.2)
    end = rolled(simulator, [[1.0, -2.0]], [[[0.5]] * 10])
    assert end == pytest.approx(np.array([[1 - 2 * 2 + 0.5 * 2**2 / 2, -2 + 0.5 * 2]]), abs=1e-12)


def test_a_pendulum_without_friction_keeps_its_energy():
    simulator = simulators.pendulum(friction=0.0, dt=0.05)
    start = states_of(simulator)
    end = rolled(simulator, start, np.zeros((5, 40, 1)))
    energy = [one[:, 1] ** 2 / 2 + 9.81 * np.cos(one[:, 0]) for one in (start, end)]
    assert energy[1] == pytest.approx(energy[0], abs=1e-3)
    assert np.abs(end - start).min() > 1e-3


def test_a_cart_pole_keeps_its_energy_and_its_momentum():
    cart, mass, half = 1.0, 0.3, 0.5
    simulator = simulators.cart_pole(cart=cart, mass=mass, half_length=half, substeps=8)
    start = states_of(simulator)
    end = rolled(simulator, start, np.zeros((5, 20, 1)))

    def momentum_and_energy(states):
        _, v, angle, turn = states.T
        across, down = v + half * turn * np.cos(angle), half * turn * np.sin(angle)
        spin = mass * (2 * half) ** 2 / 12 * turn**2 / 2
        height = mass * 9.81 * half * np.cos(angle)
        kinetic = cart * v**2 / 2 + mass * (across**2 + down**2) / 2 + spin
        return np.stack([cart * v + mass * across, kinetic + height])

    assert momentum_and_energy(end) == pytest.approx(momentum_and_energy(start), abs=1e-3)


def test_a_ball_never_leaves_its_box_and_bounces_without_loss():
    simulator = simulators.ball_in_box(friction=0.0, size=2.0, radius=0.25, dt=0.7)
    start = states_of(simulator, 50)
    end = rolled(simulator, start, np.zeros((50, 30, 2)))
    assert ((end[:, :2] >= 0.25) & (end[:, :2] <= 1.75)).all()
    assert np.abs(end[:, 2:]) == pytest.approx(np.abs(start[:, 2:]))
    assert (np.sign(end[:, 2:]) != np.sign(start[:, 2:])).any()


@pytest.mark.parametrize("make", CLASSICS)
def test_noise_is_that_of_the_action(make):
    quiet, noisy = make(), make(noise=0.3)
    start = states_of(quiet)
    size = quiet.actions.size
    action, drawn = np.full((5, size), 0.1), np.full((5, size), 2.0)
    assert not quiet.is_stochastic
    assert noisy.is_stochastic
    with jax.enable_x64(True):
        moved = noisy.transition(start, action, drawn)
        assert np.asarray(moved) == pytest.approx(np.asarray(quiet.step(start, action + 0.6)))


@pytest.mark.parametrize("make", CLASSICS)
def test_classics_have_pictures(make, tmp_path):
    simulator = make()
    first, second = (simulator.at(state) for state in states_of(simulator, 2))
    save_picture(first, tmp_path / "first.svg")
    save_picture(second, tmp_path / "second.svg")
    assert (tmp_path / "first.svg").read_bytes() != (tmp_path / "second.svg").read_bytes()
    assert first.colored_text().plain == first.caption


def test_a_table_steps_as_it_says():
    lake = hb.TabularMDP.from_gymnasium(gymnasium.make("FrozenLake-v1"))
    simulator = simulators.FiniteSimulator(lake)
    outcomes = outcomes_of(simulator, reading(simulator, "state"))
    found = outcomes(np.array([[6.0]]), np.array([[[2.0]]]), 0, 40_000)[0, 0, :, 0]
    frequencies = np.bincount(found.astype(int), minlength=16) / len(found)
    assert frequencies == pytest.approx(lake.transition(2).toarray()[6], abs=0.01)


def test_the_sensors_of_a_table_are_its_factors():
    mdp = hb.tabulate(hb.load_world("corridor"))
    simulator = simulators.FiniteSimulator(mdp)
    states = np.array([[0.0], [70.0]])
    for name in mdp.factors:
        shown = reading(simulator, name)(states)[:, 0]
        assert np.array_equal(shown, mdp.factor(name)[[0, 70]])
    assert np.array_equal(reading(simulator, "state")(states), states)


def test_sensors_are_entries_names_or_functions_of_observations():
    simulator = simulators.pendulum()
    states = np.array([[0.3, 2.0]])
    seen = np.array([[np.cos(0.3), np.sin(0.3), 2.0]])

    def shown(sensor):
        outcomes = outcomes_of(simulator, reading(simulator, sensor))
        return outcomes(states, np.empty((1, 0, 1)), 0, 1)[0, 0]

    assert np.array_equal(shown("state"), states)
    assert shown("angle") == pytest.approx(seen[:, :2])
    assert shown(2) == pytest.approx(seen[:, 2:])
    assert shown([2, 0]) == pytest.approx(seen[:, [2, 0]])
    assert shown(slice(1, None)) == pytest.approx(seen[:, 1:])
    assert shown(lambda seen: seen[:, 0] * seen[:, 2]) == pytest.approx(2 * np.cos(0.3))


def test_mujoco_moves_as_its_model_says():
    simulator = simulators.MujocoSimulator(SLIDER, substeps=10)
    model = mujoco.MjModel.from_xml_string(SLIDER)
    sequence = np.random.default_rng(0).uniform(-1, 1, (1, 7, 2))
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = [0.1, 0.2], [0.3, -0.4]
    mujoco.mj_forward(model, data)
    for controls in sequence[0]:
        data.ctrl[:] = controls
        for _ in range(10):
            mujoco.mj_step(model, data)
    end = rolled(simulator, [[0.1, 0.2, 0.3, -0.4]], sequence)
    assert end == pytest.approx(np.concatenate([data.qpos, data.qvel])[None], abs=1e-12)


def test_mujocos_sensors_are_those_of_the_state_itself():
    simulator = simulators.MujocoSimulator(SLIDER)
    states = np.array([[0.1, 0.2, 3.0, -4.0], [0.5, 0.0, 1.0, 0.0]])
    assert reading(simulator, "place")(states) == pytest.approx(
        np.array([[0.1, 0.2, 0.0], [0.5, 0.0, 0.0]])
    )
    assert np.array_equal(reading(simulator, "y velocity")(states), states[:, [3]])
    box: Any = simulator.actions
    assert np.array_equal(box.high, [1.0, np.inf])
    assert not box.is_bounded


def test_mujocos_noise_is_that_of_the_controls_and_threads_do_not_matter():
    quiet = simulators.MujocoSimulator(SLIDER)
    noisy = simulators.MujocoSimulator(SLIDER, noise=0.5, threads=1)
    states, actions = np.zeros((9, 4)), np.full((9, 2), 0.2)
    drawn = np.linspace(-1, 1, 18).reshape(9, 2)
    moved = noisy.transition(states, actions, drawn)
    assert np.array_equal(moved, quiet.step(states, actions + 0.5 * drawn))
    assert not np.array_equal(rolled(noisy, states, actions[:, None]), moved)


@pytest.mark.skipif(find_library("EGL") is None, reason="nothing to render with")
def test_mujoco_renders_without_a_screen():
    code = f"""
import numpy as np
from habilis.estimators.simulators import MujocoSimulator
simulator = MujocoSimulator({SLIDER!r})
here, there = (simulator.render(np.array([x, 0, 0, 0.0]), 60, 80) for x in (0, 0.3))
print(here.shape, np.array_equal(here, there))
"""
    screenless = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    done = subprocess.run(
        [sys.executable, "-c", code], env=screenless, capture_output=True, text=True, check=True
    )
    assert done.stdout == "(60, 80, 3) False\n"


def test_gymnasiums_environments_move_as_mujoco_does():
    environment = gymnasium.make("Reacher-v5")
    simulator = simulators.gymnasium_simulator(environment)
    inside: Any = environment.unwrapped
    environment.reset(seed=3)
    state = np.concatenate([inside.data.qpos, inside.data.qvel])
    action = np.array([0.4, -0.2], np.float32)
    environment.step(action)
    end = rolled(simulator, [state], [[action]])[0]
    assert end == pytest.approx(np.concatenate([inside.data.qpos, inside.data.qvel]), abs=1e-9)


def test_an_environment_whose_wrapper_changes_actions_is_refused():
    wrapped = gymnasium.wrappers.TransformAction(gymnasium.make("Reacher-v5"), np.negative, None)
    with pytest.raises(ValueError, match="away from where MuJoCo does"):
        simulators.gymnasium_simulator(wrapped)
    with pytest.raises(ValueError, match="FrozenLakeEnv is no MuJoCo environment"):
        simulators.gymnasium_simulator(gymnasium.make("FrozenLake-v1"))


def test_a_class_of_ones_own_is_stepped():
    class Walk:
        actions = np.array([[-1.0], [1.0]])

        def step(self, states, actions, key):
            return states + actions * key.integers(1, 3, size=states.shape)

    assert isinstance(Walk(), hb.Simulator)
    outcomes = outcomes_of(Walk(), reading(Walk(), "state"))
    states, sequences = np.array([[0.0], [5.0]]), np.array([[[1.0], [1.0]]])
    found = outcomes(states, sequences, 0, 50)
    assert set(found[0].ravel()) == {2.0, 3.0, 4.0}
    assert np.array_equal(found[1] - 5, found[0])  # the same draws from each state
    assert np.array_equal(found, outcomes(states, sequences, 0, 50))
    assert not np.array_equal(found, outcomes(states, sequences, 1, 50))


def test_steps_are_counted():
    metered = simulators.Metered(simulators.double_integrator())
    rolled(metered, np.zeros((4, 2)), np.zeros((4, 6, 1)))
    assert metered.steps == 24
    hb.Gaussian(1.0, 1.0).fit(metered, 6).bits([[0, 0]])
    assert metered.steps == 30
    assert metered.is_linear


def test_steps_that_an_estimator_makes_itself_are_counted_too():
    metered: Any = simulators.Metered(simulators.MujocoSimulator(SLIDER, noise=0.1))
    states, actions = np.zeros((3, 4)), np.zeros((3, 2))
    metered.step(states, actions, np.random.default_rng(0))
    metered.transition(states, actions, actions)
    metered.rollout(states, np.zeros((3, 5, 2)))
    assert metered.steps == 3 + 3 + 15
    metered = simulators.Metered(simulators.pendulum())
    jax.jit(lambda s: metered.step(s, s[:, :1], None))(np.zeros((3, 2)))
    assert metered.steps == 0  # nothing is seen of what is compiled elsewhere
    metered.step(np.zeros((3, 2)), np.zeros((3, 1)), None)
    assert metered.steps == 3


def test_what_is_no_simulator_and_what_goes_nowhere_is_refused():
    growing = simulators.JaxSimulator(lambda state, action: state**3 + action, [[1.0]])
    with pytest.raises(ValueError, match=r"leads from \[9\.\] to numbers that are not finite"):
        rolled(growing, [[9.0]], np.ones((1, 9, 1)))
    narrow = SimpleNamespace(actions=[[1.0]], step=lambda s, a, key: s[:, :1])
    with pytest.raises(ValueError, match=r"states of shape \(1, 1\) for \(1, 2\)"):
        rolled(narrow, [[0.0, 0.0]], np.ones((1, 2, 1)))
    narrow.in_jax = True
    for method in (hb.Counting(), hb.Gaussian(power=1, noise=0.1), hb.MonteCarlo(2, 2)):
        narrow.is_stochastic = isinstance(method, hb.MonteCarlo)
        with pytest.raises(ValueError, match=r"states of shape \(\d+, 1\) for \(\d+, 2\)"):
            hb.empowerment(narrow, 2, states=[[0.0, 0.0]], method=method)
    blind = hb.TabularMDP.deterministic([[0, -1], [0, 1]])
    with pytest.raises(
        ValueError, match=r"action 1 is .* in state 0, .*: let next_state\[0, 1\] lead"
    ):
        simulators.FiniteSimulator(blind)
    with pytest.raises(ValueError, match="MuJoCo cannot read"):
        simulators.MujocoSimulator("<mujoco")
    with pytest.raises(ValueError, match=r"none\.xml': no such file; give the path"):
        simulators.MujocoSimulator("none.xml")
    with pytest.raises(ValueError, match=r"or of simulators an estimator, as hb\.Counting"):
        hb.empowerment(growing, 1, states=[[0.0]], method="counting")  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match="no actuator"):
        simulators.MujocoSimulator("<mujoco/>")
    with pytest.raises(ValueError, match="each number of the first below"):
        ActionBox([0.0], [0.0])
    with pytest.raises(ValueError, match="'speed' is unknown; use one of state, angle, velocity"):
        reading(simulators.pendulum(), "speed")
    with pytest.raises(ValueError, match="radius is 2"):
        simulators.ball_in_box(radius=2)
    for make in CLASSICS:
        with pytest.raises(ValueError, match="noise is -1"):
            make(noise=-1)
