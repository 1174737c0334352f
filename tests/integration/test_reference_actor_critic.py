"""The float64 reference of A2C and PPO beside PyTorch: its gradients, optimisers and clipping."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from reference_actor_critic import Rollout, Settings, batched, ppo_steps, standardised, steps
from reference_networks import Parameters
from reference_optimizers import GAINS, linear_bound, orthogonality_error

torch = pytest.importorskip("torch")
nn = torch.nn
torch.set_num_threads(1)

ACTIVATIONS = {"tanh": nn.Tanh, "relu": nn.ReLU, "selu": nn.SELU, "sigmoid": nn.Sigmoid}
OPTIMIZERS = {
    "adam": lambda p: torch.optim.Adam(p, lr=0.02),
    "rmsprop-torch": lambda p: torch.optim.RMSprop(p, lr=0.02, alpha=0.99, eps=1e-5),
}
STEPS, ENVS, ROWS, ACTIONS = 6, 3, 8, 4


def perceptron(widths, activation, *, linear_end=True):
    parts = [p for w in pairwise(widths) for p in (nn.Linear(*w), ACTIVATIONS[activation]())]
    return nn.Sequential(*(parts[:-1] if linear_end else parts)).double()


def layers(module):
    return [
        (m.weight.detach().numpy().T.copy(), m.bias.detach().numpy().copy())
        for m in module
        if isinstance(m, nn.Linear)
    ]


def built(kind, activation):
    """Networks of PyTorch's, a list of the parts that each clip covers."""
    torch.manual_seed(0)
    if kind == "separate":
        trunk = nn.Sequential()
        policy = perceptron((ROWS, 16, 8, ACTIONS), activation)
        value = perceptron((ROWS, 16, 1), activation)
        parts = [[policy], [value]]
    else:
        trunk = perceptron((ROWS, 16, 8), activation, linear_end=False)
        policy, value = (perceptron((8, out), activation) for out in (ACTIONS, 1))
        parts = [[trunk, policy, value]]
    groups = [[p for m in part for p in m.parameters()] for part in parts]
    return SimpleNamespace(trunk=trunk, policy=policy, value=value, groups=groups)


def read(net):
    return Parameters(layers(net.policy), layers(net.value), layers(net.trunk))


def rollout(seed):
    rng = np.random.default_rng(seed)
    shape = (STEPS, ENVS)
    terminated, truncated = rng.random((2, *shape)) < 0.2
    return Rollout(
        rng.integers(ROWS, size=(*shape, 2)),
        rng.integers(ACTIONS, size=shape),
        rng.normal(size=shape),
        terminated,
        truncated,
        cut_values=rng.normal(size=shape),
    )


def one_hot(inputs):
    return torch.nn.functional.one_hot(torch.from_numpy(inputs), ROWS).sum(-2).double()


def loss(net, batch, settings, entropy):
    x = net.trunk(one_hot(batch.inputs))
    chosen = torch.distributions.Categorical(logits=net.policy(x))
    log_prob = chosen.log_prob(torch.from_numpy(batch.actions))
    advantages, targets = map(torch.from_numpy, (batch.advantages, batch.targets))
    gained = log_prob * advantages
    if batch.old_log_probs is not None:
        ratio = (log_prob - torch.from_numpy(batch.old_log_probs)).exp()
        bounds = 1 - settings.clip_range, 1 + settings.clip_range
        gained = torch.minimum(ratio * advantages, ratio.clamp(*bounds) * advantages)
    value = nn.functional.mse_loss(net.value(x)[:, 0], targets)
    return -gained.mean() - entropy * chosen.entropy().mean() + settings.value * value


def agree(ours, theirs):
    for a, b in zip(ours.arrays(), theirs.arrays(), strict=True):
        assert np.allclose(a, b, rtol=1e-9, atol=1e-12)


def stepped(net, batches, optimizer, settings, clip):
    """The networks after each step of PyTorch's, a batch a step."""
    optimizers = [OPTIMIZERS[optimizer](group) for group in net.groups]
    for batch_of in batches:
        total = loss(net, batch_of(read(net)), settings, 0.05)
        for each in optimizers:
            each.zero_grad()
        total.backward()
        for group, each in zip(net.groups, optimizers, strict=True):
            nn.utils.clip_grad_norm_(group, clip)
            each.step()
        yield total.item(), read(net)


@pytest.mark.parametrize("activation", ACTIVATIONS)
@pytest.mark.parametrize("kind", ["shared", "separate"])
@pytest.mark.parametrize("optimizer", OPTIMIZERS)
def test_a2cs_first_three_steps_are_pytorchs(activation, kind, optimizer):
    chosen = {
        "networks": kind,
        "activation": activation,
        "normalise": True,
        "unbiased": True,
        "gae_lambda": 0.9,
    }
    net, settings = built(kind, activation), Settings(**chosen)
    data = [rollout(seed) for seed in range(3)]
    ours = steps(
        read(net),
        data,
        **chosen,
        optimizer=optimizer,
        learning_rate=0.02,
        clip=0.3,
        clip_epsilon=1e-6,
        entropy=0.05,
    )
    batches = [lambda p, one=one: batched(p, one, settings) for one in data]
    for mine, (total, theirs) in zip(
        ours, stepped(net, batches, optimizer, settings, 0.3), strict=True
    ):
        assert mine.loss.total == pytest.approx(total, rel=1e-10)
        agree(mine.parameters, theirs)


@pytest.mark.parametrize("kind", ["shared", "separate"])
def test_ppos_first_four_steps_are_pytorchs(kind):
    chosen = {"networks": kind, "activation": "selu", "clip_range": 0.05}
    net, settings = built(kind, "selu"), Settings(**chosen)
    data = rollout(7)
    halves = [*np.split(np.random.default_rng(0).permutation(STEPS * ENVS), 2)] * 2
    whole = batched(read(net), data, settings, old_policy=True)

    def part(places):
        fields = (None if field is None else field[places] for field in whole)
        return whole._replace(**dict(zip(whole._fields, fields, strict=True)))

    ours = ppo_steps(
        read(net),
        data,
        halves,
        **chosen,
        learning_rate=0.02,
        clip=0.3,
        clip_epsilon=1e-6,
        entropy=0.05,
    )
    batches = [lambda _, places=places: part(places) for places in halves]
    for mine, (total, theirs) in zip(
        ours, stepped(net, batches, "adam", settings, 0.3), strict=True
    ):
        assert mine.loss.total == pytest.approx(total, rel=1e-10)
        agree(mine.parameters, theirs)


@pytest.mark.parametrize("unbiased", [False, True])
def test_the_deviations_are_pytorchs(unbiased):
    x = np.random.default_rng(0).normal(size=20)
    theirs = torch.from_numpy(x)
    theirs = (theirs - theirs.mean()) / (theirs.std(unbiased=unbiased) + 1e-8)
    assert np.allclose(standardised(x, unbiased=unbiased), theirs.numpy(), rtol=1e-12)


@pytest.mark.parametrize("activation", ACTIVATIONS)
def test_gains_and_initial_weights_are_pytorchs(activation):
    gain = nn.init.calculate_gain(activation)
    assert GAINS[activation] == pytest.approx(gain, rel=1e-15)
    for shape in ((9, 4), (4, 9)):
        weight = nn.init.orthogonal_(torch.empty(shape, dtype=torch.float64), gain=gain)
        assert orthogonality_error(weight.numpy().T, gain) < 1e-12
    plain = nn.Linear(25, 400)
    weight, bias = (p.detach().numpy() for p in (plain.weight, plain.bias))
    for array in (weight, bias):
        assert 0.95 < np.abs(array).max() / linear_bound(weight.T) <= 1
