"""The parts of Habilis that need more than the plain installation."""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

_OF_EXTRA = {
    "learn": ("jax", "jaxlib", "equinox", "optax", "jinja2", "filelock", "tensorboardX"),
    "gymnasium": ("gymnasium", "pygame"),
    "robots": ("mujoco", "gymnasium", "jax", "jaxlib", "equinox", "optax"),
    "video": ("imageio_ffmpeg", "moviepy"),
    "sweep": ("optuna", "ray"),
    "studio": ("starlette", "uvicorn", "websockets"),
    "storm": ("stormpy",),
}


class MissingExtraError(ImportError):
    """A part of Habilis is used whose packages are not installed."""


def import_from(module: str, extra: str) -> ModuleType:
    """Imports a module that needs an extra, one of ours or of the extra itself.

    Raises:
        MissingExtraError: a package of the extra is not installed; the message says what to run.
    """
    with extra_named(extra):
        return import_module(module)


@contextmanager
def extra_named(*extras: str) -> Iterator[None]:
    """Turns the failed import of an extra's package into one line.

    Args:
        extras: those looked at; none: all.

    Raises:
        MissingExtraError: as in `import_from`.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        for extra in extras or _OF_EXTRA:
            if package in _OF_EXTRA[extra]:
                raise _missing(package, extra) from None
        raise


def check_installed(extra: str) -> None:
    """Refuses what another process would need an extra for.

    Raises:
        MissingExtraError: as in `import_from`.
    """
    for name in _OF_EXTRA[extra]:
        if find_spec(name) is None:
            raise _missing(name, extra)


def _missing(name: str, extra: str) -> MissingExtraError:
    return MissingExtraError(f"{name} is not installed; run: pip install 'habilis[{extra}]'")
