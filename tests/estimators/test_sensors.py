"""Sensors of simulators: what they select, and refusals in the place of a wrong number."""

import numpy as np
import pytest

import habilis as hb
from habilis.estimators.sensors import reading
from habilis.estimators.simulators import MujocoSimulator, double_integrator

SLIDERS = """<mujoco><worldbody><body><joint name="x" type="slide" axis="1 0 0"/>
<joint name="y" type="slide" axis="0 1 0"/><geom size="0.1"/></body></worldbody>
<actuator><motor joint="x" ctrlrange="-1 1"/></actuator></mujoco>"""


def test_a_list_of_names_is_their_entries_in_order():
    states = np.arange(8.0).reshape(2, 4)
    shown = reading(MujocoSimulator(SLIDERS), ["y velocity", "x"])(states)
    np.testing.assert_array_equal(shown, states[:, [3, 0]])


@pytest.mark.parametrize("simulator", [double_integrator(), MujocoSimulator(SLIDERS)])
@pytest.mark.parametrize("sensor", [7, [0, 7], -9])
def test_an_index_that_no_observation_has_is_refused(simulator, sensor):
    """Functions of JAX would be given the last entry."""
    with pytest.raises(ValueError, match=r"an observation has \d entries; give indices from 0 to"):
        reading(simulator, sensor)(np.zeros((1, 4 if simulator.in_jax is False else 2)))


def test_a_name_in_a_list_that_does_not_exist_is_named():
    with pytest.raises(ValueError, match="sensor 'z' is unknown; use one of state, x, x velocity"):
        reading(MujocoSimulator(SLIDERS), ["x", "z"])


@pytest.mark.ill_typed
@pytest.mark.parametrize("width", [1, 3])
@pytest.mark.parametrize("simulator", [double_integrator(), MujocoSimulator(SLIDERS)])
def test_states_of_another_length_are_refused(simulator, width):
    """NumPy would put one number into all entries of a MuJoCo state."""
    with pytest.raises(ValueError, match=rf"states have {width} numbers each, the simulator's"):
        simulator.step(np.zeros((1, width)), np.zeros((1, 1)), None)


@pytest.mark.parametrize("state", [9.0, -1.0, 0.5])
def test_an_index_that_is_no_state_is_refused_also_by_the_simulator(state):
    ring = hb.TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
    fitted = hb.Counting().fit(hb.estimators.simulators.FiniteSimulator(ring), 1)
    with pytest.raises(ValueError, match=rf"states has {state:g}; use indices from 0 to 8"):
        fitted.bits([[state]])


def test_states_are_rows_even_of_one_number():
    """[0, 9] could be two states of one number, or one of two."""
    ring = hb.TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
    fitted = hb.Counting().fit(hb.estimators.simulators.FiniteSimulator(ring), 3)
    with pytest.raises(ValueError, match=r"states has shape \(2,\).* one state a row, as \[\["):
        fitted.bits([0.0, 9.0])
