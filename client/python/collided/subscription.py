"""A subscription: its batches, in order, by `for`, by `async for`, or one at a time."""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncIterator, Iterator
from typing import TYPE_CHECKING

from . import errors
from .events import Batch

if TYPE_CHECKING:
    from .client import Client


class Subscription(Iterator[Batch], AsyncIterator[Batch]):
    """Made by Client.watch. The first batch is a snapshot: all that holds at that time. Whatever of the client waits
    (another subscription, a query, sync) receives for all of its subscriptions; what was received is kept here, up to
    `limit` events and batches, for whoever reads it. Iterating ends when the subscription or the client is closed."""

    def __init__(self, client: Client, number: int, limit: int, heartbeats: bool):
        self._client = client
        self._limit = limit
        self._heartbeats = heartbeats
        self._queue: deque[Batch] = deque()
        self._held = 0
        self._gone = ""
        self.id = number
        self.closed = False

    def keep(self, batch: Batch) -> None:
        """The client has received it."""
        if self._gone or (batch.heartbeat and not self._heartbeats):
            return
        if self._held + 1 + len(batch) > self._limit:
            self.lose(f"more than {self._limit} events were not read in time")
            return
        self._held += 1 + len(batch)
        self._queue.append(batch)

    def lose(self, why: str) -> None:
        """What comes from here on is not kept: who has read what was kept before is told so."""
        self._gone = self._gone or why

    def _pop(self) -> Batch | None:
        if self._queue:
            batch = self._queue.popleft()
            self._held -= 1 + len(batch)
            return batch
        if self._gone and not self.closed:
            self.close()
            raise errors.Overrun(f"{self._gone}: subscribe anew")
        return None

    def take(self) -> list[Batch]:
        """What has been received, without waiting for more: see Client.poll."""
        batches = []
        while (batch := self._pop()) is not None:
            batches.append(batch)
        return batches

    def wait(self, timeout_s: float) -> Batch:
        """The next batch. Raises Timeout, or NoDaemon while none is heard."""
        batch = self._pop()
        if batch is None and not self.closed:
            self._client.wait_for(lambda: bool(self._queue or self._gone) or self.closed, timeout_s)
            batch = self._pop()
        if batch is None:
            raise errors.Timeout(f"no batch within {timeout_s:g} s")
        return batch

    def __iter__(self) -> Subscription:
        return self

    def __next__(self) -> Batch:
        while not self.closed:
            try:
                return self.wait(3600.0)
            except errors.Timeout:
                continue
        if (batch := self._pop()) is not None:
            return batch
        raise StopIteration

    def __aiter__(self) -> Subscription:
        return self

    async def __anext__(self) -> Batch:
        while (batch := self._pop()) is None:
            if self.closed:
                raise StopAsyncIteration
            await self._client.arrival()
        return batch

    def close(self) -> None:
        """Ends it. What was received before can still be read."""
        if not self.closed:
            self.closed = True
            self._client.unsubscribe(self)

    def __enter__(self) -> Subscription:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
