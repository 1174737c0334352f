"""The float64 reference of A2C and PPO, checked by finite differences and by hand."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest
from reference_actor_critic import (
    Rollout,
    Settings,
    advantages_and_targets,
    batched,
    generalised_advantages,
    loss_and_gradients,
    ppo_steps,
    standardised,
    steps,
)
from reference_networks import Parameters, activated, slope, values
from reference_optimizers import (
    GAINS,
    Moments,
    apply,
    clipped,
    decayed,
    linear,
    linear_bound,
    norm,
    orthogonality_error,
)

ROWS, FACTORS, ACTIONS, STEPS, ENVS = 7, 2, 3, 5, 4
COUNTED = STEPS * ENVS - 1  # of `rollout`
ACTIVATIONS = ("tanh", "relu", "selu", "sigmoid")


def layers(rng, *widths):
    return [(rng.normal(size=(into, out)), rng.normal(size=out)) for into, out in pairwise(widths)]


def networks(kind, seed=0):
    rng = np.random.default_rng(seed)
    if kind == "shared":
        return Parameters(layers(rng, 5, ACTIONS), layers(rng, 5, 1), layers(rng, ROWS, 6, 5))
    return Parameters(layers(rng, ROWS, 6, 5, ACTIONS), layers(rng, ROWS, 4, 1))


def rollout(seed=1, **changed):
    """With an episode that ends, one that is cut off, and steps that do not count."""
    rng = np.random.default_rng(seed)
    shape = (STEPS, ENVS)
    terminated, truncated = np.zeros(shape, bool), np.zeros(shape, bool)
    mask = np.ones(shape, bool)
    terminated[2, 0] = truncated[1, 1] = terminated[3, 2] = True
    mask[4, 2] = False
    return Rollout(
        **{
            "inputs": rng.integers(ROWS, size=(*shape, FACTORS)),
            "actions": rng.integers(ACTIONS, size=shape),
            "rewards": rng.normal(size=shape),
            "terminated": terminated,
            "truncated": truncated,
            "cut_values": rng.normal(size=shape),
            "mask": mask,
            **changed,
        }
    )


def same(ours, theirs):
    pairs = zip(ours.arrays(), theirs.arrays(), strict=True)
    return all(np.allclose(a, b, rtol=1e-12, atol=1e-14) for a, b in pairs)


def by_differences(parameters, batch, settings, entropy):
    """The gradient by central differences."""
    arrays = parameters.arrays()

    def loss():
        changed = parameters.replaced(arrays)
        return loss_and_gradients(changed, batch, settings, entropy)[0].total

    found = []
    for array in arrays:
        gradient = np.zeros(array.shape)
        for place in np.ndindex(array.shape):
            middle, width = array[place], 1e-6
            array[place] = middle + width
            above = loss()
            array[place] = middle - width
            gradient[place] = (above - loss()) / (2 * width)
            array[place] = middle
        found.append(gradient)
    return found


# Gradients.


@pytest.mark.parametrize("activation", ACTIVATIONS)
@pytest.mark.parametrize("kind", ["shared", "separate"])
@pytest.mark.parametrize("ppo", [False, True])
@pytest.mark.parametrize("dense", [False, True])
def test_gradients_are_those_by_central_differences(activation, kind, ppo, dense):
    settings = Settings(networks=kind, activation=activation, value=0.7, normalise=True)
    rng = np.random.default_rng(2)
    available = rng.random((STEPS, ENVS, ACTIONS)) < 0.7
    data = rollout()
    np.put_along_axis(available, data.actions[..., None], True, axis=-1)
    data = dataclasses.replace(data, available=available)
    if dense:
        data = dataclasses.replace(data, inputs=rng.uniform(-1, 1, (STEPS, ENVS, ROWS)))
    batch = batched(networks(kind), data, settings, old_policy=ppo)
    now = networks(kind, seed=3) if ppo else networks(kind)
    if ppo:  # near the old policy, and some ratios out of bounds
        pairs = zip(networks(kind).arrays(), now.arrays(), strict=True)
        now = now.replaced([old + 0.05 * change for old, change in pairs])
    _, gradients = loss_and_gradients(now, batch, settings, 0.3)
    expected = by_differences(now, batch, settings, 0.3)
    for ours, theirs in zip(gradients.arrays(), expected, strict=True):
        assert np.allclose(ours, theirs, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("name", ACTIVATIONS)
def test_slopes_are_those_of_the_activations(name):
    z = np.array([-30.0, -3.0, -0.5, -1e-3, 1e-3, 0.5, 3.0, 30.0])
    by_difference = (activated(name, z + 1e-6) - activated(name, z - 1e-6)) / 2e-6
    assert np.allclose(slope(name, z), by_difference, rtol=1e-7, atol=1e-9)


def test_activations_have_their_known_values():
    z = np.array([-1.0, 0.0, 2.0])
    assert np.allclose(activated("tanh", z), [-0.7615941559557649, 0, 0.9640275800758169])
    assert np.allclose(activated("relu", z), [0, 0, 2])
    assert np.allclose(activated("selu", z), [-1.1113307378125625, 0, 2.101401974710961])
    assert np.allclose(activated("sigmoid", z), [0.2689414213699951, 0.5, 0.8807970779778823])


def test_rows_are_one_hot_inputs():
    data = rollout()
    dense = dataclasses.replace(data, inputs=np.eye(ROWS)[data.inputs].sum(axis=2))
    for kind in ("shared", "separate"):
        first, second = (steps(networks(kind), [d], networks=kind)[0] for d in (data, dense))
        assert same(first.gradients, second.gradients)
        assert same(first.parameters, second.parameters)


# Advantages.


def column(*numbers):
    return np.array(numbers, float)[:, None]


def advantages(ends=(0, 0, 0), cuts=(0, 0, 0), later=(8, 16, 32), gae_lambda=0.5):
    return generalised_advantages(
        column(1, 2, 3),
        column(4, 8, 16),
        column(*later),
        column(*ends) == 1,
        column(*cuts) == 1,
        0.5,
        gae_lambda,
    )[:, 0].tolist()


def test_generalised_advantages_are_those_by_hand():
    # delta = 1 + 8/2 - 4, 2 + 16/2 - 8, 3 + 32/2 - 16 = 1, 2, 3; gamma lambda = 1/4
    assert advantages() == [1 + 2 / 4 + 3 / 16, 2 + 3 / 4, 3]
    # the second step ends its episode: delta = 2 - 8
    assert advantages(ends=(0, 1, 0)) == [1 - 6 / 4, -6, 3]
    # the second step is cut off in a state of value 2: delta = 2 + 2/2 - 8
    assert advantages(cuts=(0, 1, 0), later=(8, 2, 32)) == [1 - 5 / 4, -5, 3]


def test_with_lambda_1_they_are_n_step_returns_less_the_value():
    assert advantages(gae_lambda=1) == [1 + 2 / 2 + 3 / 4 + 32 / 8 - 4, 2 + 3 / 2 + 32 / 4 - 8, 3]
    assert advantages(gae_lambda=0) == [1, 2, 3]


@pytest.mark.parametrize("seed", range(5))
def test_they_are_those_of_the_usual_recursion(seed):
    rng = np.random.default_rng(seed)
    rewards, now, later = rng.normal(size=(3, 12, 3))
    ends, cuts = rng.random((2, 12, 3)) < 0.2
    found = generalised_advantages(rewards, now, later, ends, cuts, 0.9, 0.8)
    following = np.zeros(3)
    for t in reversed(range(12)):
        delta = rewards[t] + 0.9 * later[t] * ~ends[t] - now[t]
        following = delta + 0.9 * 0.8 * following * ~(ends[t] | cuts[t])
        assert np.allclose(found[t], following, rtol=1e-12)


def still(bias):
    """Networks of no weights: the policy is uniform and the value of every state the bias."""
    zero = np.zeros((1, 2)), np.zeros(2)
    return Parameters([zero], [(np.zeros((1, 1)), np.array([bias]))])


def lone(**changed):
    """Three steps of one environment, rewards 1, 2, 3."""
    none = np.zeros((3, 1), bool)
    return Rollout(
        **{
            "inputs": np.zeros((3, 1, 1)),
            "actions": np.array([[0], [1], [0]]),
            "rewards": column(1, 2, 3),
            "terminated": none,
            "truncated": none,
            "cut_values": column(100, 20, 40),
            **changed,
        }
    )


def targets(settings=None, **changed):
    settings = settings or Settings(discount=0.5, networks="separate")
    return advantages_and_targets(still(4.0), lone(**changed), settings)[1][:, 0].tolist()


def test_a_state_that_is_not_cut_off_has_the_value_that_the_network_gives():
    assert targets() == [1 + 2 / 2 + 3 / 4 + 40 / 8, 2 + 3 / 2 + 40 / 4, 3 + 40 / 2]
    td = Settings(discount=0.5, gae_lambda=0.0)
    assert targets(td) == [1 + 4 / 2, 2 + 4 / 2, 3 + 40 / 2]


def test_a_truncated_episode_goes_on_with_the_value_where_it_was_cut_off():
    second = column(0, 1, 0) == 1
    assert targets(truncated=second)[:2] == [1 + 2 / 2 + 20 / 4, 2 + 20 / 2]
    terminal = Settings(discount=0.5, limit_is_terminal=True)
    assert targets(terminal, truncated=second)[:2] == [1 + 2 / 2, 2.0]
    assert targets(terminated=second)[:2] == [1 + 2 / 2, 2.0]
    assert targets(terminated=second, truncated=second)[:2] == [1 + 2 / 2, 2.0]


def test_the_reward_has_its_scale():
    scaled = Settings(discount=0.5, reward_scale=10.0)
    assert targets(scaled, terminated=column(0, 1, 0) == 1)[:2] == [10 + 20 / 2, 20.0]


def test_the_value_where_it_was_cut_off_may_be_the_networks():
    data = rollout()
    inputs = np.random.default_rng(5).integers(ROWS, size=data.inputs.shape)
    by_network = dataclasses.replace(data, cut_values=None, cut_inputs=inputs)
    shared = networks("shared")
    given = values(shared, inputs.reshape(-1, FACTORS), "tanh").reshape(STEPS, ENVS)
    by_hand = dataclasses.replace(data, cut_values=given)
    ours, theirs = (steps(shared, [either])[0] for either in (by_network, by_hand))
    assert same(ours.gradients, theirs.gradients)
    with pytest.raises(ValueError, match="cut_values or cut_inputs"):
        steps(shared, [dataclasses.replace(data, cut_values=None)])


def test_standardised_advantages_have_either_deviation():
    x = np.array([1.0, 2.0, 3.0, 4.0])
    biased = [side / (math.sqrt(1.25) + 1e-8) for side in (-1.5, -0.5, 0.5, 1.5)]
    unbiased = [side / (math.sqrt(5 / 3) + 1e-8) for side in (-1.5, -0.5, 0.5, 1.5)]
    assert np.allclose(standardised(x, unbiased=False), biased, rtol=1e-14)
    assert np.allclose(standardised(x, unbiased=True), unbiased, rtol=1e-14)
    assert standardised(np.ones(3), unbiased=False).tolist() == [0, 0, 0]


# The loss.


def test_the_loss_is_that_by_hand():
    settings = Settings(discount=0.5, value=0.25, networks="separate")
    batch = batched(still(4.0), lone(), settings)
    wanted = [1 + 1 + 0.75 + 5, 2 + 1.5 + 10, 3 + 20]
    advantage = [target - 4 for target in wanted]
    loss, _ = loss_and_gradients(still(4.0), batch, settings, 0.1)
    assert loss.policy == pytest.approx(math.log(2) * sum(advantage) / 3, rel=1e-14)
    assert loss.entropy == pytest.approx(math.log(2), rel=1e-14)
    assert loss.value == pytest.approx(sum(a**2 for a in advantage) / 3, rel=1e-14)
    total = loss.policy - 0.1 * loss.entropy + 0.25 * loss.value
    assert loss.total == pytest.approx(total, rel=1e-14)


def test_its_gradient_is_that_by_hand():
    step = steps(still(4.0), [lone()], discount=0.5, value=0.25, networks="separate")[0]
    a, b, c = 7.75 - 4, 13.5 - 4, 23 - 4
    ((_, by_logits),) = step.gradients.policy
    ((_, by_value),) = step.gradients.value
    assert np.allclose(by_logits, [(-a + b - c) / 6, (a - b + c) / 6], rtol=1e-14)
    assert np.allclose(by_value, [-0.25 * 2 * (a + b + c) / 3], rtol=1e-14)


def test_steps_that_do_not_count_change_nothing():
    data = rollout()
    one = np.arange(STEPS * ENVS).reshape(STEPS, ENVS) == 4 * ENVS + 2
    assert data.mask is not None
    assert data.cut_values is not None
    assert (data.mask == ~one).all()
    changed = dataclasses.replace(
        data,
        inputs=np.where(one[..., None], 0, data.inputs),
        rewards=np.where(one, np.nan, data.rewards),
        cut_values=np.where(one, np.nan, data.cut_values),
    )
    settings = {"normalise": True, "unbiased": True}
    first, second = (steps(networks("shared"), [d], **settings)[0] for d in (data, changed))
    assert first.loss == second.loss
    assert same(first.gradients, second.gradients)


def test_the_mean_is_over_the_steps_that_count():
    """Two episodes of 2 and of 4 steps: the loss is that of the six, not a mean of two means."""
    data = rollout(mask=None)
    ends = np.zeros((STEPS, ENVS), bool)
    ends[1, 0] = ends[3, 1] = True
    mask = np.arange(STEPS)[:, None] < np.array([2, 4, 0, 0])
    data = dataclasses.replace(data, terminated=ends, truncated=~ends & False, mask=mask)

    def alone(env, long):
        part = {
            field: getattr(data, field)[:long, env : env + 1]
            for field in ("inputs", "actions", "rewards", "terminated", "truncated", "cut_values")
        }
        return steps(networks("shared"), [Rollout(**part)])[0]

    both = steps(networks("shared"), [data])[0]
    short, long = alone(0, 2), alone(1, 4)
    assert both.loss.total == pytest.approx((2 * short.loss.total + 4 * long.loss.total) / 6)
    for ours, *parts in zip(*(s.gradients.arrays() for s in (both, short, long)), strict=True):
        assert np.allclose(ours, (2 * parts[0] + 4 * parts[1]) / 6, rtol=1e-12)


def test_a_mask_that_would_cut_an_episode_in_two_is_an_error():
    with pytest.raises(ValueError, match="mask"):
        steps(still(0.0), [lone(mask=column(1, 1, 0))], networks="separate")
    ended = column(1, 0, 0) == 1
    with pytest.raises(ValueError, match="mask"):
        steps(still(0.0), [lone(mask=column(1, 0, 1), terminated=ended)], networks="separate")


def test_ppos_first_gradient_is_a2cs():
    data = rollout()
    everything = [np.arange(COUNTED)]
    for kind in ("shared", "separate"):
        ours = ppo_steps(networks(kind), data, everything, networks=kind, entropy=0.1)[0]
        theirs = steps(networks(kind), [data], networks=kind, entropy=0.1)[0]
        assert same(ours.gradients, theirs.gradients)
        assert ours.loss.policy != theirs.loss.policy  # -A, not -log pi A


@pytest.mark.parametrize(
    ("ratio", "advantage", "policy", "held"),
    [
        (1.1, 2.0, -2.2, False),
        (1.5, 2.0, -2.4, True),
        (1.5, -2.0, 3.0, False),
        (0.5, 2.0, -1.0, False),
        (0.5, -2.0, 1.6, True),
    ],
)
def test_the_clipped_objective_is_that_by_hand(ratio, advantage, policy, held):
    batch = batched(still(0.0), lone(), Settings())
    batch = batch._replace(
        advantages=np.full(3, advantage), old_log_probs=np.full(3, math.log(0.5 / ratio))
    )
    loss, gradients = loss_and_gradients(still(0.0), batch, Settings(clip_range=0.2), 0.0)
    assert loss.policy == pytest.approx(policy, rel=1e-12)
    ((_, by_logits),) = gradients.policy
    expected = 0 if held else -ratio * advantage / 6
    assert np.allclose(by_logits, [expected, -expected], rtol=1e-12)


def test_ppo_may_standardise_over_the_rollout_or_over_a_minibatch():
    data = rollout()
    halves = np.array_split(np.arange(COUNTED), 2)
    found = [
        ppo_steps(networks("shared"), data, halves, normalise=True, normalise_over=over)
        for over in ("rollout", "minibatch")
    ]
    assert not same(found[0][0].gradients, found[1][0].gradients)
    # by hand: with the ratio 1 the policy term is less the mean advantage, of a minibatch 0
    assert found[1][0].loss.policy == pytest.approx(0, abs=1e-14)
    assert abs(found[0][0].loss.policy) > 1e-3


# The optimisers.


def two_steps(optimizer, *gradients):
    arrays = [np.array([1.0])]
    moments = Moments.fresh(arrays)
    found = []
    for gradient in gradients:
        arrays, moments = apply(optimizer, arrays, [np.array([gradient])], moments, 0.5)
        found.append(arrays[0].item())
    return found


def test_adams_first_two_steps_are_those_by_hand():
    # m = .1, v = .001: both corrected 1; then m = .09 + .2, v = .000999 + .004
    first = 1 - 0.5 * 1 / (1 + 1e-8)
    second = first - 0.5 * (0.29 / 0.19) / (math.sqrt(0.004999 / 0.001999) + 1e-8)
    assert two_steps("adam", 1.0, 2.0) == pytest.approx([first, second], rel=1e-13)


def test_rmsprops_first_two_steps_are_those_by_hand():
    # v = .04, then .0396 + .01
    first = 1 - 0.5 * 2 / math.sqrt(0.04 + 1e-5)
    second = first - 0.5 * 1 / math.sqrt(0.0496 + 1e-5)
    assert two_steps("rmsprop", 2.0, 1.0) == pytest.approx([first, second], rel=1e-13)
    first = 1 - 0.5 * 2 / (0.2 + 1e-5)
    second = first - 0.5 * 1 / (math.sqrt(0.0496) + 1e-5)
    assert two_steps("rmsprop-torch", 2.0, 1.0) == pytest.approx([first, second], rel=1e-13)


def test_where_epsilon_is_shows_in_small_gradients():
    inside, outside = (two_steps(name, 1e-3)[0] for name in ("rmsprop", "rmsprop-torch"))
    assert inside == pytest.approx(1 - 0.5 * 1e-3 / math.sqrt(1.001e-5), rel=1e-3)
    assert outside == pytest.approx(1 - 0.5 * 1e-3 / 1.1e-4, rel=1e-9)


def test_a_second_step_goes_on_from_the_first():
    for optimizer in ("adam", "rmsprop", "rmsprop-torch"):
        first, second = steps(
            networks("shared"),
            [rollout(), rollout(seed=9)],
            optimizer=optimizer,
            learning_rate=0.1,
        )
        alone = steps(first.parameters, [rollout(seed=9)], optimizer=optimizer, learning_rate=0.1)
        assert same(second.gradients, alone[0].gradients)
        arrays, moments = apply(
            optimizer, first.parameters.arrays(), second.clipped.arrays(), first.moments, 0.1
        )
        assert same(second.parameters, first.parameters.replaced(arrays))
        assert not same(second.parameters, alone[0].parameters)  # moments were not fresh
        assert moments.steps == 2


def test_clipping_shortens_the_whole_gradient():
    gradients = [np.array([[3.0]]), np.array([4.0])]
    assert [a.item() for a in clipped(gradients, 1)] == pytest.approx([0.6, 0.8], rel=1e-14)
    assert [a.item() for a in clipped(gradients, 6)] == [3, 4]
    assert [a.item() for a in clipped(gradients, 0)] == [3, 4]
    torchs = [3 / 5.000001, 4 / 5.000001]
    assert [a.item() for a in clipped(gradients, 1, 1e-6)] == pytest.approx(torchs, rel=1e-14)


def test_separate_networks_are_clipped_one_by_one():
    step = steps(networks("separate"), [rollout()], networks="separate", clip=0.01)[0]
    of_policy = [array for layer in step.clipped.policy for array in layer]
    of_value = [array for layer in step.clipped.value for array in layer]
    assert norm(of_policy) == pytest.approx(0.01, rel=1e-12)
    assert norm(of_value) == pytest.approx(0.01, rel=1e-12)
    shared = steps(networks("shared"), [rollout()], clip=0.01)[0]
    assert norm(shared.clipped.arrays()) == pytest.approx(0.01, rel=1e-12)
    with pytest.raises(ValueError, match="trunk"):
        steps(networks("shared"), [rollout()], networks="separate")


# Schedules and initial weights.


def test_schedules_are_those_by_hand():
    assert [linear(4, 2, 10, count) for count in (-5, 0, 5, 10, 20)] == [4, 4, 3, 2, 2]
    assert [linear(4, 2, 0, count) for count in (0, 5)] == [4, 4]
    counts = (0, 499, 500, 999, 1000)
    assert [decayed(0.9, 500, count) for count in counts] == [1, 1, 0.9, 0.9, 0.9**2]
    assert decayed(0.9, 0, 1e9) == 1


def test_they_reach_the_step():
    def moved(count, **settings):
        data = rollout(count=count)
        return steps(networks("shared"), [data], optimizer="rmsprop", **settings)[0]

    schedule = {"learning_rate_end": 0.0, "learning_rate_steps": 100}
    half = moved(50, learning_rate=0.2, **schedule)
    decay = moved(1000, learning_rate=0.4, learning_rate_decay=0.5, learning_rate_every=500)
    plain = moved(0, learning_rate=0.1)
    assert same(half.parameters, plain.parameters)
    assert same(decay.parameters, plain.parameters)

    held = {"entropy": 0.2, "entropy_end": 0.0, "entropy_hold": 40, "entropy_steps": 20}
    for count, weight in ((0, 0.2), (40, 0.2), (50, 0.1), (60, 0.0), (99, 0.0)):
        assert moved(count, **held).loss == moved(count, entropy=weight).loss


def test_initial_weights_are_measured():
    rng = np.random.default_rng(0)
    for shape in ((7, 3), (3, 7)):
        u, _, v = np.linalg.svd(rng.normal(size=shape), full_matrices=False)
        for gain in GAINS.values():
            assert orthogonality_error(gain * u @ v, gain) < 1e-12
            assert orthogonality_error(1.1 * gain * u @ v, gain) > 0.1
    assert linear_bound(np.zeros((16, 3))) == 0.25
    gains = {"tanh": 5 / 3, "relu": math.sqrt(2), "selu": 3 / 4, "sigmoid": 1}
    assert gains == GAINS
