"""Gaussian channels against closed forms, other algorithms, and their invariances."""

from dataclasses import replace
from typing import Any

import jax
import numpy as np
import pytest
from scipy.optimize import brentq

import habilis as hb
from habilis.estimators import ActionBox, simulators
from habilis.estimators.gaussian import water_filling

SPRING = np.array([[1.0, 0.1], [-0.3, 0.9]])
PUSH = np.array([[0.005], [0.1]])


class Stepped:
    """A simulator of JAX as one of NumPy, which cannot be differentiated."""

    def __init__(self, simulator):
        self.compiled = jax.jit(simulator.transition)
        self.actions, self.noise = simulator.actions, simulator.noise
        self.is_stochastic = simulator.is_stochastic

    def step(self, states, actions, key):
        return self.transition(states, actions, None)

    def transition(self, states, actions, noise):
        with jax.enable_x64(True):
            return np.asarray(self.compiled(states, actions, noise))


def response(A, B, horizon):
    """The derivative of s_h with respect to (a_1 ... a_h)."""
    return np.hstack([np.linalg.matrix_power(A, horizon - 1 - t) @ B for t in range(horizon)])


def test_one_component_of_a_linear_system_is_the_capacity_of_a_gaussian_channel():
    for horizon in (1, 3, 8):
        spring = simulators.linear_system(SPRING, PUSH)
        fitted = hb.Gaussian(power=2.0, noise=0.05).fit(spring, horizon, 0)
        gain = (response(SPRING, PUSH, horizon)[0] ** 2).sum() / 0.05**2
        assert fitted.kind == "exact"
        assert fitted.bits([[0, 0], [3, -1]]) == pytest.approx(np.log2(1 + 2 * gain) / 2, abs=1e-9)


def test_process_noise_is_propagated_and_power_is_divided():
    noise = np.array([[0.02, 0.0], [0.01, 0.05]])
    spring = simulators.linear_system(SPRING, PUSH, noise=noise)
    sensor_noise = np.array([[0.01, 0.004], [0.004, 0.02]])
    horizon, power = 5, 0.7
    found = hb.Gaussian(power, sensor_noise).fit(spring, horizon).channels([[0.0, 1.0]])

    covariance, steps = sensor_noise.copy(), np.eye(2)
    for _ in range(horizon):
        covariance += steps @ noise @ noise.T @ steps.T
        steps = steps @ SPRING
    G = response(SPRING, PUSH, horizon)
    gains = np.linalg.eigvals(np.linalg.solve(covariance, G @ G.T)).real
    spent = lambda level: np.maximum(level - 1 / gains, 0).sum() - power  # noqa: E731
    level: Any = brentq(spent, 0, 1e3, xtol=1e-15)
    bits = np.log2(np.maximum(level * gains, 1)).sum() / 2
    assert found.bits == pytest.approx(bits, abs=1e-6)
    assert found.gains[0] == pytest.approx(np.sort(gains)[::-1])
    assert found.powers.sum() == pytest.approx(power)
    assert found.residual == pytest.approx(0, abs=1e-12)


def test_the_residual_is_what_a_worse_division_of_power_lacks():
    gains = np.array([[9.0, 4.0, 1.0, 0.0]])
    best = water_filling(gains, 2.0)
    tried = np.random.default_rng(0).dirichlet(np.ones(4), 2000) * 2.0
    assert best.powers.sum() == pytest.approx(2.0)
    assert (np.log2(1 + gains * tried).sum(axis=1) / 2 <= best.bits).all()
    assert water_filling(np.zeros((1, 3)), 1.0).bits == 0


def test_a_rotated_sensor_and_other_units_change_nothing():
    arm = simulators.pendulum(noise=0.1, substeps=1)
    states = arm.random_states(3, np.random.default_rng(0))
    noise = np.diag([0.1, 0.2]) ** 2
    plain = hb.Gaussian(1.0, noise).fit(arm, 3).bits(states)
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(2, 2)))[0]
    scale = np.diag([1e3, 1e-4])
    for change in (turn, scale):
        seen = replace(arm, observation=lambda state, change=change: change @ state)
        changed = hb.Gaussian(1.0, change @ noise @ change.T).fit(seen, 3, slice(None))
        assert changed.bits(states) == pytest.approx(plain, abs=1e-6)
    wider = replace(arm, function=lambda s, a, z: arm.function(s, a / 5, z))
    assert hb.Gaussian(25.0, noise).fit(wider, 3).bits(states) == pytest.approx(plain, abs=1e-6)


def test_differences_agree_with_derivatives():
    for simulator in (simulators.pendulum(), simulators.pendulum(noise=0.3)):
        states = simulator.random_states(4, np.random.default_rng(0))
        method = hb.Gaussian(power=3.0, noise=[0.01, 0.05], nominal=0.5)
        exact = method.fit(simulator, 5)
        assert exact.kind == "approximation"
        stepped = method.fit(Stepped(simulator), 5)
        assert stepped.bits(states) == pytest.approx(exact.bits(states), abs=1e-6)


def test_a_mass_of_mujocos_is_the_linear_system_that_it_is():
    xml = """<mujoco><option timestep="0.1" gravity="0 0 0"/><worldbody><body>
      <joint name="x" type="slide"/><geom size="0.1" mass="2"/></body></worldbody>
      <actuator><motor joint="x" ctrlrange="-1 1"/></actuator></mujoco>"""
    for noise in (0.0, 0.2):
        mass = simulators.MujocoSimulator(xml, noise=noise)
        B = np.array([[0.005], [0.05]])  # semi-implicit Euler
        system = simulators.linear_system([[1, 0.1], [0, 1]], B, noise=noise * B if noise else None)
        method = hb.Gaussian(power=4.0, noise=0.01)
        expected = method.fit(system, 6).bits([[0, 0]])
        assert method.fit(mass, 6).bits([[0, 0]]) == pytest.approx(expected, abs=1e-6)


def test_an_upright_pendulum_has_more_empowerment_than_a_hanging_one():
    pendulum = simulators.pendulum()
    upright, hanging = hb.empowerment(
        pendulum, 10, states=[[0, 0], [np.pi, 0]], method=hb.Gaussian(1.0, 0.1)
    )
    assert upright > hanging + 1


def test_without_actions_and_without_states_there_is_nothing():
    fitted = hb.Gaussian(1.0, 0.1).fit(simulators.pendulum(), 0)
    assert fitted.bits([[1, 2], [3, 4]]).tolist() == [0, 0]
    assert len(hb.Gaussian(1.0, 0.1).fit(simulators.pendulum(), 2).bits(np.zeros((0, 2)))) == 0


def test_singular_noise_is_refused():
    spring = simulators.linear_system(SPRING, PUSH)
    same = simulators.linear_system(SPRING, PUSH, noise=[[1.0], [2.0]])
    with pytest.raises(ValueError, match="singular: component 1 of the sensor has none"):
        hb.Gaussian(1.0, [0.1, 0.0]).fit(spring, 2).bits([[0, 0]])
    with pytest.raises(ValueError, match="singular: that of some components"):
        hb.Gaussian(1.0, 0.0).fit(same, 1).bits([[0, 0]])
    assert hb.Gaussian(1.0, 0.0).fit(same, 2).bits([[0, 0]]) > 0  # two steps of noise span both


@pytest.mark.ill_typed
def test_wrong_arguments_are_refused_in_one_line():
    pendulum = simulators.pendulum()
    wrong: list[Any] = [0, -1, np.inf, "much", np.nan]
    for power in wrong:
        with pytest.raises(ValueError, match="power is"):
            hb.Gaussian(power, 1.0)
    for noise in (-1, np.nan, "loud", [1, -1], [[1, 2], [3, 4]], [[1, 2], [2, 1]], [[1.0, 2.0]]):
        with pytest.raises(ValueError, match="noise "):
            hb.Gaussian(1.0, noise)
    with pytest.raises(ValueError, match="noise has 3 numbers, the sensor 2"):
        hb.Gaussian(1.0, [1, 1, 1]).fit(pendulum, 1).bits([[0, 0]])
    with pytest.raises(ValueError, match=r"give \[2, 2\]"):
        hb.Gaussian(1.0, np.eye(3)).fit(pendulum, 1).bits([[0, 0]])
    with pytest.raises(ValueError, match="nominal is"):
        hb.Gaussian(1.0, 1.0, nominal=[1, 2]).fit(pendulum, 3)
    with pytest.raises(ValueError, match="nominal is on the edge"):
        hb.Gaussian(1.0, 1.0, nominal=5.0).fit(Stepped(pendulum), 3)
    with pytest.raises(ValueError, match="labels, which have no derivative"):
        hb.empowerment(hb.TabularMDP.deterministic([[0]]), 1, method=hb.Gaussian(1.0, 1.0))
    with pytest.raises(ValueError, match="horizon is 2000000000"):
        hb.Gaussian(1.0, 1.0).fit(pendulum, 2 * 10**9)

    class Secret:
        actions = ActionBox([0.0], [1.0])

        def step(self, states, actions, key):
            return states + key.normal(size=states.shape)

    with pytest.raises(ValueError, match="does not say how"):
        hb.Gaussian(1.0, 1.0).fit(Secret(), 1)
    rough = simulators.JaxSimulator(lambda s, a: s + jax.numpy.sqrt(a), ActionBox([0.0], [1.0]))
    with pytest.raises(ValueError, match="derivative of the sensor is not finite"):
        hb.Gaussian(1.0, 1.0).fit(rough, 1).bits([[0.0]])
