"""Initial weights, and gradients by hand, of every kind of network."""

from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from reference_optimizers import GAINS, linear_bound, orthogonality_error

from habilis.learning.networks import ACTIVATIONS, Network, Separate, actor_critic_network

ROWS, FACTORS, ACTIONS, HIDDEN = 90, 3, 40, (80, 60)


def network(kind="shared", activation="tanh", initialisation="lecun", hidden=HIDDEN) -> Any:
    key = jax.random.key(5)
    return actor_critic_network(
        kind, ROWS, FACTORS, ACTIONS, hidden, key, activation, initialisation
    )


def layers(one):
    pairs = [(one.embedding, one.bias), *one.layers]
    return [(np.asarray(weight, float), np.asarray(bias, float)) for weight, bias in pairs]


def both(initialisation, activation="tanh"):
    """The layers of a shared network, and of each of two separate ones."""
    of = {"activation": activation, "initialisation": initialisation}
    separate = network("separate", **of)
    return [layers(one) for one in (network(**of), separate.policy, separate.value)]


def test_lecun_weights_have_variance_one_by_the_inputs_and_the_last_layer_is_small():
    for one in both("lecun"):
        inputs = [FACTORS, *HIDDEN]
        gains = [1.0, 1.0, 0.01]
        for (weight, bias), n, gain in zip(one, inputs, gains, strict=True):
            assert weight.std() * np.sqrt(n) / gain == pytest.approx(
                1, abs=5 / np.sqrt(weight.size)
            )
            assert (bias == 0).all()


def test_pytorchs_weights_and_biases_are_uniform_within_one_by_the_root_of_the_inputs():
    for one in both("pytorch"):
        for weight, bias in one:
            bound = linear_bound(weight)
            for drawn in (weight, bias):
                assert np.abs(drawn).max() <= bound
                if drawn.size >= 40:
                    assert np.abs(drawn).max() > 0.9 * bound
                    near = 5 / np.sqrt(drawn.size)
                    assert drawn.std() / bound == pytest.approx(1 / np.sqrt(3), abs=near)
                    assert drawn.mean() / bound == pytest.approx(0, abs=near)


@pytest.mark.parametrize("activation", ACTIVATIONS)
def test_orthogonal_weights_have_the_activations_gain_in_every_layer(activation):
    for one in both("orthogonal", activation):
        for weight, bias in one:
            assert orthogonality_error(weight, GAINS[activation]) < 1e-5
            assert (bias == 0).all()


def test_separate_networks_begin_apart():
    for initialisation in ("lecun", "pytorch", "orthogonal"):
        one = network("separate", initialisation=initialisation)
        assert not np.array_equal(one.policy.embedding, one.value.embedding)


@pytest.mark.parametrize("activation", ACTIVATIONS)
@pytest.mark.parametrize("kind", ["shared", "separate"])
@pytest.mark.parametrize("coordinates", [False, True], ids=["one-hot", "coordinates"])
def test_the_gradient_by_hand_is_that_of_automatic_differentiation(activation, kind, coordinates):
    one = network(kind, activation, "pytorch", hidden=(6, 5))
    key = jax.random.key(1)
    inputs = (
        jax.random.normal(key, (4, ROWS))
        if coordinates
        else jax.random.randint(key, (4, FACTORS), 0, ROWS)
    )
    weights = jax.random.normal(jax.random.key(2), (4, ACTIONS + 1))
    wanted = jax.grad(lambda n: (n(inputs) * weights).sum())(one)
    activations = one.activations(inputs)
    found = one.gradient(inputs, activations, weights)
    assert jax.tree.structure(found) == jax.tree.structure(wanted)
    for ours, theirs in zip(jax.tree.leaves(found), jax.tree.leaves(wanted), strict=True):
        np.testing.assert_allclose(ours, theirs, rtol=1e-4, atol=1e-5)


def test_one_hot_factors_and_the_same_as_numbers_are_one():
    one = network(activation="selu")
    rows = jnp.array([[0, 33, 80], [5, 31, 61]])
    numbers = jax.nn.one_hot(rows, ROWS).sum(axis=1)
    np.testing.assert_allclose(one(rows), one(numbers), rtol=1e-5, atol=1e-6)


def test_separate_networks_give_out_logits_then_the_value():
    one = network("separate")
    assert isinstance(one, Separate)
    assert isinstance(one.policy, Network)
    rows = jnp.array([[0, 33, 80]])
    np.testing.assert_array_equal(one(rows)[:, :-1], one.policy(rows))
    np.testing.assert_array_equal(one(rows)[:, -1:], one.value(rows))
