"""Gymnasium's Pusher-v5 as a landscape over the object's position: docs/explanation/robots.md.

    python -m research.pusher    # ten minutes on two processors

Writes pusher.csv, a row for each pose, position of the object and search, and pusher.png, both
beside the page. What pusher.csv has is not computed again.
"""

from pathlib import Path

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Rectangle

from habilis.estimators import Counting
from habilis.estimators.simulators import MujocoSimulator, gymnasium_simulator
from habilis.estimators.simulators.mujoco import imported
from habilis.files import write_whole
from habilis.statistics import bootstrap_interval
from habilis.worlds.pictures.figures import new_figure, save_figure
from habilis.worlds.pictures.heatmap import HEAT

PAGE = Path(__file__).parents[1] / "docs" / "explanation" / "robots"
RESULTS = PAGE / "pusher.csv"
SENSOR = ["obj_slidex", "obj_slidey"]
HORIZON, HELD, RESOLUTION, SEQUENCES = 6, 5, 0.025, 40
SEARCHES = ("lowered", 0), ("initial", 0), ("lowered", 1)
TORQUE = 2.0
POSES = {
    "initial": np.zeros(7),
    "lowered": np.array([-0.414, 0.873, -1.5, -1.681, -1.167, -0.416, -1.245]),
}
"""Joint angles from shoulder pan to wrist roll. The second puts the fork, level, 6 cm above the
plane that the object slides on, at (0.45, -0.45), its prongs towards +y; least squares found it."""
OBJECT = 0.45, -0.05
"""Where the object is when its joints are 0."""
REGION = (0.25, 0.65), (-0.35, -0.05)
"""Where an episode of Gymnasium's may begin with it, in x and y."""
X, Y = np.linspace(*REGION[0], 6).round(3), np.linspace(*REGION[1], 5).round(3)


def simulator() -> MujocoSimulator:
    """Pusher-v5; an action holds one joint's torque at an end of its range, or none."""
    model = gymnasium_simulator("Pusher-v5").model
    joints = np.eye(model.nu)
    levels = np.concatenate([np.zeros((1, model.nu)), TORQUE * joints, -TORQUE * joints])
    return MujocoSimulator(model, substeps=5 * HELD, actions=levels)


def placed(world: MujocoSimulator, pose: str, positions: np.ndarray) -> np.ndarray:
    """The states at rest in a pose, the object at positions in the plane."""
    states = np.tile(world.initial, (len(positions), 1))
    states[:, : len(POSES[pose])] = POSES[pose]
    states[:, [world.names[name].start for name in SENSOR]] = positions - OBJECT
    return states


def free(world: MujocoSimulator, states: np.ndarray) -> np.ndarray:
    """Whether the arm does not reach into the object."""
    mujoco, model = imported(), world.model
    data, found = mujoco.MjData(model), []
    body = model.body("object").id
    for state in states:
        mujoco.mj_setState(model, data, state, mujoco.mjtState.mjSTATE_PHYSICS)
        mujoco.mj_forward(model, data)
        pairs = model.geom_bodyid[np.asarray(data.contact.geom).reshape(-1, 2)]
        arm = (pairs == body).any(axis=1) & (pairs != 0).all(axis=1)
        found.append(not (arm & (np.asarray(data.contact.dist) < 0)).any())
    return np.array(found)


def measured() -> pl.DataFrame:
    """The counts; a search of a pose that is in the results is not made again."""
    world = simulator()
    positions = np.stack(np.meshgrid(X, Y, indexing="ij"), axis=-1).reshape(-1, 2)
    found = pl.read_csv(RESULTS) if RESULTS.exists() else None
    for pose, seed in SEARCHES:
        if found is not None and len(found.filter(pose=pose, seed=seed)):
            continue
        states = placed(world, pose, positions)
        good = free(world, states)
        fitted = Counting(RESOLUTION, SEQUENCES).fit(world, HORIZON, SENSOR, seed=seed)
        bits = np.full(len(states), np.nan)
        bits[good] = fitted.bits(states[good])
        columns = {"x": positions[:, 0], "y": positions[:, 1], "bits": bits}
        named = pl.lit(pose).alias("pose"), pl.lit(seed, pl.Int64).alias("seed")
        made = pl.DataFrame(columns).select(*named, "x", "y", "bits")
        found = made if found is None else pl.concat([found, made])
        write_whole(RESULTS, found.write_csv)
    assert found is not None
    return found


def averages(found: pl.DataFrame) -> dict[str, np.ndarray]:
    """For each pose the means over its searches, by position; not a number where it is not free."""
    bits: dict[str, np.ndarray] = {}
    for pose in POSES:
        some = found.filter(pose=pose).sort("seed", "x", "y")["bits"].to_numpy()
        bits[pose] = some.reshape(-1, len(X), len(Y)).mean(axis=0)
    return bits


def draw(found: pl.DataFrame) -> Figure:
    """Both landscapes from above, with the arm of their pose."""
    figure = new_figure(900, 390)
    bits = averages(found)
    most = max(1.0, float(np.nanmax(bits["lowered"])))
    world, steps = simulator(), (X[1] - X[0], Y[1] - Y[0])
    both = figure.subplots(1, 2, sharey=True)
    figure.subplots_adjust(left=0.07, right=0.88, bottom=0.13, top=0.92, wspace=0.05)
    for ax, pose in zip(both, POSES, strict=True):
        for (row, column), value in np.ndenumerate(bits[pose]):
            if np.isnan(value):
                continue
            corner = X[row] - steps[0] / 2, Y[column] - steps[1] / 2
            ax.add_patch(Rectangle(corner, *steps, facecolor=HEAT(value / most), edgecolor="white"))
        _draw_arm(ax, world, pose)
        height = "" if pose == "initial" else ", at the object's height"
        ax.set_title(f"{pose} pose{height}: {np.nanmean(bits[pose]):.2f} bits", fontsize=10)
        ax.set(xlim=(-0.1, 1.0), ylim=(-0.8, 0.05), aspect="equal", xlabel="x in m")
    both[0].set_ylabel("y in m")
    place = figure.add_axes((0.9, 0.13, 0.016, 0.79))
    bar = figure.colorbar(ScalarMappable(Normalize(0, most), HEAT), cax=place, label="bits")
    bar.outline.set_visible(False)
    return figure


def _draw_arm(ax: Axes, world: MujocoSimulator, pose: str) -> None:
    """The joints of the arm as a line, its fork, and the object at the middle of the region."""
    mujoco, model = imported(), world.model
    data = mujoco.MjData(model)
    data.qpos[: len(POSES[pose])] = POSES[pose]
    mujoco.mj_kinematics(model, data)
    bodies = ("r_shoulder_pan_link", "r_shoulder_lift_link", "r_elbow_flex_link", "tips_arm")
    line = np.array([data.xpos[model.body(name).id] for name in bodies])
    ax.plot(*line.T[:2], "o-", color="#5b6270", linewidth=5, markersize=7, alpha=0.7)
    for geom in range(model.ngeom):
        if model.geom_conaffinity[geom] and model.geom_bodyid[geom]:
            axis = data.geom_xmat[geom].reshape(3, 3)[:, 2] * model.geom_size[geom, 1]
            ends = np.stack([data.geom_xpos[geom] - axis, data.geom_xpos[geom] + axis])
            ax.plot(*ends.T[:2], color="#0072b2", linewidth=4, solid_capstyle="round")
    ax.add_patch(Circle((0.45, -0.2), 0.05, fill=False, edgecolor="#d55e00", linewidth=1.5))


def main() -> None:
    found = measured()
    save_figure(draw(found), PAGE / "pusher.png")
    for pose, bits in averages(found).items():
        free = bits[~np.isnan(bits)]
        low, high = bootstrap_interval(free)
        print(
            f"{pose}: {free.mean():.2f} bits ({low:.2f} to {high:.2f}) over {len(free)} positions, "
            f"most {free.max():.2f}, influence in {(free >= 0.5).mean():.0%}"
        )
    both = [found.filter(pose="lowered", seed=seed)["bits"].to_numpy() for seed in (0, 1)]
    apart = np.abs(both[0] - both[1])
    print(
        f"two searches differ by {np.nanmean(apart):.2f} bits on average, "
        f"{np.nanmax(apart):.2f} at most"
    )


if __name__ == "__main__":
    main()
