"""The parts of Habilis that need more than the plain installation."""

from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

_OF_EXTRA = {
    "learn": ("jax", "jaxlib", "equinox", "optax", "jinja2", "filelock", "tensorboardX"),
    "gymnasium": ("gymnasium", "pygame"),
    "video": ("imageio_ffmpeg", "moviepy"),
    "sweep": ("optuna", "ray"),
    "studio": ("starlette", "uvicorn", "websockets"),
}


class MissingExtraError(ImportError):
    """A part of Habilis is used whose packages are not installed."""


def import_from(module: str, extra: str) -> ModuleType:
    """Imports a module that needs an extra, one of ours or of the extra itself.

    Raises:
        MissingExtraError: a package of the extra is not installed; the message says what to run.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] not in _OF_EXTRA[extra]:
            raise
        raise _missing(error.name, extra) from None


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
