"""The Python client of the collision daemon collided.

A client publishes bodies and their poses, and is told what touches, what is near, and how sure that is:

    import collided

    with collided.connect("dds://0") as client:
        ball = client.body("ball", collided.sphere(0.05))
        client.body("block", collided.box(0.2, 0.2, 0.2), fixed=True)
        ball.move((0.1, 0, 0))
        for batch in client.watch():
            for event in batch:
                print(event.kind.name, event.a, event.b)

Units: metres, seconds where a name ends in _s, nanoseconds where it ends in _ns. Quaternions are in the order that the
keyword says, wxyz= or xyzw=. Not safety-rated: do not let a human's safety depend on it alone."""

from .client import Answers, Body, Client, Found, Hit, Ids, Rejection, Rule, Status, connect, ids, version
from .errors import (BadArgument, CollidedError, ConnectError, Forked, NoDaemon, Overrun, Rejected, Timeout, TransportError,
                     UnknownId, Unsupported)
from .events import EVENT, IMPACT, POINT, Achieved, Batch, Event, Kind
from .kernel import Checked, CheckStatus, check, check_motion, check_twist
from .robots import Joint, JointType, Robot, Tried, Verdict
from .shapes import (Claim, Pose, Shape, box, capsule, compound, cone, cylinder, ellipsoid, halfspace, sphere, verify)
from .subscription import Subscription

__all__ = [
    "EVENT", "IMPACT", "POINT", "Achieved", "Answers", "BadArgument", "Batch", "Body", "CheckStatus", "Checked", "Claim", "Client", "CollidedError",
    "ConnectError", "Event", "Forked", "Found", "Hit", "Ids", "Joint", "JointType", "Kind", "NoDaemon", "Overrun", "Pose", "Rejected",
    "Rejection", "Robot", "Rule", "Shape", "Status", "Subscription", "Timeout", "TransportError", "Tried", "UnknownId", "Unsupported", "Verdict", "box",
    "capsule", "check", "check_motion", "check_twist", "compound", "cone", "connect", "cylinder", "ellipsoid", "halfspace", "ids", "sphere", "verify", "version",
]
