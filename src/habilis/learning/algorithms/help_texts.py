"""Help for the settings that several algorithms share."""

ENVS = "environments that a run steps in parallel"
ROLLOUT = "steps per environment and update"
DISCOUNT = "discount factor, gamma"
REWARD_SCALE = "factor on the training reward (reported returns are unscaled)"

# Of those with networks.
LEARNING_RATE = "step size of the optimiser"
LEARNING_RATE_END = "step size after learning_rate_steps"
LEARNING_RATE_STEPS = "environment steps over which the step size changes linearly; 0: constant"
LEARNING_RATE_DECAY = "factor on the step size after each learning_rate_every"
LEARNING_RATE_EVERY = "environment steps between decays of the step size; 0: none"
SCHEDULE = (
    'unit of the schedules of step size and entropy: environment "steps" or finished "episodes" '
    "before the current rollout"
)
OPTIMIZER = (
    "rmsprop (decay 0.99, epsilon 1e-5 in the root), rmsprop-torch (epsilon outside the root, as "
    "in PyTorch) or adam"
)
CLIP = "largest norm of a network's gradient, beyond which it is clipped; 0: no clipping"
ENTROPY = "weight of the policy's entropy (nats) in the loss"
ENTROPY_END = "weight of the entropy after entropy_steps"
ENTROPY_STEPS = "environment steps over which that weight changes linearly; 0: constant"
ENTROPY_HOLD = "environment steps before it starts to change"
VALUE = "weight of the value's squared error in the loss"
GAE_LAMBDA = "lambda of the generalised advantage; 1: n-step returns"
NORMALISE = "whether advantages have mean 0 and deviation 1 in each batch"
UNBIASED = "whether that deviation divides by n - 1 instead of n"
HIDDEN = "widths of a network's hidden layers"
NETWORKS = 'one "shared" trunk for policy and value, or "separate" networks'
ACTIVATION = "activation of the hidden layers: tanh, relu, selu, sigmoid"
INITIALISATION = (
    "initial weights: lecun (normal, the last layer small), orthogonal (with the activation's "
    "gain) or pytorch (weights and biases uniform within 1 / sqrt(inputs), PyTorch's default)"
)
