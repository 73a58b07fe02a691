"""A swarm of spheres around a gripper, with numpy and asyncio: one task publishes all poses at once, another one is told of
the distances, as arrays, and checks the proof of the least one.

collided & python3 swarm.py [URI [SECONDS]]"""

import asyncio
import sys

import numpy as np

import collided

COUNT, RADIUS, PERIOD_S = 200, 0.02, 0.02
GRIPPER, SPHERE = collided.box(0.1, 0.1, 0.3), collided.sphere(RADIUS)


async def fly(client: collided.Client, swarm: collided.Ids, seconds: float) -> None:
    """Each sphere on its own circle. The arrays are made once, and read by the library where they are."""
    positions = np.zeros((COUNT, 3))
    wxyz = np.tile([1.0, 0.0, 0.0, 0.0], (COUNT, 1))
    start = np.linspace(0.0, 2 * np.pi, COUNT, endpoint=False)
    radius = np.linspace(0.3, 2.0, COUNT)
    for tick in range(int(seconds / PERIOD_S)):
        angle = start + 0.5 * tick * PERIOD_S / radius
        positions[:, 0] = radius * np.cos(angle) + 0.2 * np.sin(0.01 * tick)
        positions[:, 1] = radius * np.sin(angle)
        client.publish(swarm, positions, wxyz=wxyz)
        client.flush()
        await asyncio.sleep(PERIOD_S)


async def watch(client: collided.Client) -> None:
    """Batches are structured arrays: the nearest of all is one line."""
    async for batch in client.watch("gripper", "sphere*", touch=False, distance_m=0.4, tolerance_m=1e-6, rate_hz=5):
        told = np.isin(batch.events["kind"], (collided.Kind.NEAR, collided.Kind.UPDATE))
        if not told.any():
            continue
        least = batch.events[told][np.argmin(batch.events["lo"][told])]
        a, b = batch.names[least["a"]], batch.names[least["b"]]
        print(f"{int(told.sum()):3d} distances; the least: {a} and {b}, {least['lo']:.6f} to {least['hi']:.6f} m", flush=True)


async def main() -> None:
    """Both, for some seconds; at the end the least distance is asked for, and its proof is checked here."""
    uri, seconds = (sys.argv[1:] + ["dds://0", "5"][len(sys.argv) - 1:])[:2]
    with collided.connect(uri) as client:
        client.body("gripper", GRIPPER, fixed=True)
        swarm = collided.ids([client.body(f"sphere{i}", SPHERE, pose=collided.Pose((3.0 + i, 0, 0))) for i in range(COUNT)])
        client.sync()
        watcher = asyncio.create_task(watch(client))
        await fly(client, swarm, float(seconds))
        watcher.cancel()
        hit = client.nearest("gripper")[0]
        hit = client.distance("gripper", hit.b if hit.a == "gripper" else hit.a, 1e-9)
        sphere = next(found.pose for found in client.find(hit.b))
        holds = collided.verify(GRIPPER, collided.Pose(), SPHERE, sphere, hit)
        print(f"{hit.a} and {hit.b}: {hit.lo:.9f} to {hit.hi:.9f} m, {'proven' if holds else 'NOT proven'}")


asyncio.run(main())
