"""What can go wrong, as exceptions: one for each status of collided.h, with the library's own words."""

from typing import Any

from ._native import ffi, lib


class CollidedError(Exception):
    """Of all that this package raises for what the library or the daemon says."""


class ConnectError(CollidedError, ConnectionError):
    """The client could not connect: the text says why, and what to do."""


class BadArgument(CollidedError, ValueError):
    """An argument is not usable."""


class UnknownId(CollidedError, LookupError):
    """There is no such body or subscription, any more."""


class Rejected(CollidedError):
    """The daemon refused it."""


class Timeout(CollidedError, TimeoutError):
    """It has not come within the time that was given."""


class NoDaemon(CollidedError, ConnectionError):
    """No daemon has been heard for three seconds. The client is announced to the next one by itself: it may be used on."""


class TransportError(CollidedError, OSError):
    """The transport failed."""


class Unsupported(CollidedError):
    """That cannot be done, or not be known."""


class Overrun(CollidedError):
    """A subscription was not read, and held more than its limit, or receiving was interrupted: what came after that is gone.
    Subscribe anew."""


class Forked(CollidedError, RuntimeError):
    """The client belongs to the process that this one was forked from. Connect in the child, or use multiprocessing with
    the start method "spawn"."""


_BY_STATUS: dict[int, type[CollidedError]] = {
    lib.COLLIDED_BAD_ARGUMENT: BadArgument,
    lib.COLLIDED_UNKNOWN_ID: UnknownId,
    lib.COLLIDED_REJECTED: Rejected,
    lib.COLLIDED_TIMEOUT: Timeout,
    lib.COLLIDED_NO_DAEMON: NoDaemon,
    lib.COLLIDED_TRANSPORT: TransportError,
    lib.COLLIDED_UNSUPPORTED: Unsupported,
}


def text_of(pointer: Any) -> str:
    """A string of C's."""
    return "" if pointer == ffi.NULL else bytes(ffi.string(pointer)).decode("utf-8", "replace")


def error_of(status: int, text: str) -> CollidedError:
    """The exception for a status that is not COLLIDED_OK."""
    return _BY_STATUS.get(status, CollidedError)(text or text_of(lib.collided_status_text(status)))
