"""Results at the paper's pace that were never trained: files as the real ones, numbers drawn."""

from pathlib import Path

import numpy as np

from habilis.studies.paper.published import EXPERIMENTS, REWARDS

LEARNERS = ("fast default", "A2C", "PPO", "Q-learning", "RMSprop")


def write_pace(folder: Path, ratio: float = 0.8, pairs: int = 5, seed: int = 0) -> Path:
    """All files of `data/pace`; agents with a bonus take `ratio` times the others' episodes."""
    random = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    learner = [
        "setting,optimizer,learning_rate,map,tool,runs,converged,episodes,first_success,steps,had"
    ]
    for setting in range(1, 13):
        for experiment in EXPERIMENTS:
            for row in experiment.rows:
                if row.vanilla:
                    counts = _counts(random, row.mean, 5)
                    learner.append(
                        f"{setting},adam,0.001,{experiment.world},{row.tool},5,5,{counts},{counts},"
                        f"{counts},{counts}"
                    )
    for name in ("screen.csv", "confirm.csv"):
        (folder / name).write_text("\n".join(learner) + "\n")
    ensemble = {
        (str(pair), str(10 + pair), f"corridor-0{pair}", f"yard-0{pair}"): 1.3 ** (2 - pair)
        for pair in range(1, pairs + 1)
    }
    head = "pair,setting,corridor,yard"
    _write(folder / "ensemble.csv", head, ensemble, ratio, 10, random)
    _write(folder / "thirty.csv", head, dict(list(ensemble.items())[:1]), ratio, 30, random)
    speeds = {(name,): 0.1 * 1.8**k for k, name in enumerate(LEARNERS)}
    _write(folder / "compared.csv", "learner", speeds, ratio, 10, random)
    (folder / "pairs.toml").write_text(
        "\n".join(
            f"[[pair]]\nsetting = {s}\ncorridor = {c!r}\nyard = {y!r}\n"
            f"[pair.learner]\noptimizer = 'rmsprop'\nlearning_rate = 0.002\nenvs = 8\n"
            f"rollout = 20\nhidden = [64, 64]\nepisode_limit = 200\n"
            for _, s, c, y in ensemble
        )
    )
    (folder / "after.toml").write_text('decided = ["The budget of the broom was doubled."]\n')
    return folder


def _write(path, head, learners, ratio, runs, random) -> None:
    columns = "map,tool,reward,horizon,beta,runs,converged,episodes,first_success,steps,had"
    lines = [f"{head},{columns}"]
    for key, speed in learners.items():
        for experiment in EXPERIMENTS:
            name = key[2:][EXPERIMENTS.index(experiment)] if len(key) == 4 else experiment.world
            for row in experiment.rows:
                vanilla = next(v for v in experiment.rows if v.vanilla and v.tool == row.tool)
                mean = vanilla.mean * speed * (1 if row.vanilla else ratio)
                counts, first = (_counts(random, mean * part, runs) for part in (1, 0.2))
                exceeded = " ".join(["-", *counts.split()[1:]]) if row.tool == "broom" else counts
                converged = runs - (row.tool == "broom")
                what = (name, row.tool, REWARDS[row.intrinsic], row.horizon, row.beta, runs)
                came = (converged, exceeded, first, counts, counts)
                lines.append(",".join(map(str, (*key, *what, *came))))
    path.write_text("\n".join(lines) + "\n")


def _counts(random: np.random.Generator, mean: float, runs: int) -> str:
    return " ".join(str(int(mean * factor)) for factor in random.lognormal(0, 0.1, runs))
