import pytest

from habilis.learning.algorithms.a2c import A2C
from habilis.learning.config import Config

# A corner to push a can into: learned within seconds.
ROOM = "A.\nC.\n..\nG.\n"


@pytest.fixture(scope="session")
def room(tmp_path_factory):
    path = tmp_path_factory.mktemp("world") / "room.txt"
    path.write_text(ROOM)
    return path


@pytest.fixture(scope="session")
def config(room):
    """Two tasks: seven runs that give up after a few hundred episodes."""
    return Config(
        algorithm=A2C(hidden=(8,)), world=str(room), runs=7, episodes=300, episode_limit=50
    )
