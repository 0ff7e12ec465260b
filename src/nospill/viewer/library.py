"""Where viser comes from."""

from __future__ import annotations

from types import ModuleType

from nospill.errors import MissingExtraError


def require_viser() -> ModuleType:
    """The library viser, imported where it is first needed.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import viser
    except ImportError as error:
        raise MissingExtraError('viewing needs viser, which is not installed; pip install "nospill[view]"') from error
    return viser
