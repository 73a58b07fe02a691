"""A robot in Python: its joints move its links, what it grips rides along, and configurations and whole motions are tried out
without moving anything; what is wrong raises the exception that tells it."""

import math

from world import PATIENCE_S, check, collided, connect, finish, np, raises, run

LINK = collided.capsule(0.05, 0.8).at((0.5, 0, 0), wxyz=(math.sqrt(0.5), 0, math.sqrt(0.5), 0))  # along x


def arm(c):
    """Two links of 1 m in a row, each turning about z."""
    joints = [collided.Joint(collided.JointType.REVOLUTE, parent=i - 1, origin=collided.Pose((i, 0, 0)), lower=-3, upper=3,
                             body=name) for i, name in enumerate(("upper", "fore"))]
    bodies = [c.body("upper", LINK, rules=[collided.Rule("fore")]), c.body("fore", LINK)]
    return collided.Robot(joints, collided.Pose((0, 0, 1))), bodies


def pose_of(c, name):
    c.sync(PATIENCE_S)
    return c.find(name, PATIENCE_S)[0].pose


def wait_for(c, name, position):
    for _ in range(300):
        pose = pose_of(c, name)
        if np.allclose(pose.position, position, atol=1e-12):
            return
        c.poll(0.02)
    check(False, f"{name} is at {pose}, not at {position}")


def joints_move_links_and_what_is_gripped():
    with connect() as c:
        robot, (upper, fore) = arm(c)
        part = c.body("part", collided.sphere(0.02), pose=collided.Pose((9, 9, 9)))
        check(robot.coordinates == 2, f"{robot.coordinates} joints")
        c.set_robot(upper, robot)
        c.sync(PATIENCE_S)
        c.publish_joints(upper, (math.pi / 2, 0))
        wait_for(c, "fore", (0, 1, 1))
        c.attach(upper, part, fore, collided.Pose((1, 0, 0)))
        c.sync(PATIENCE_S)
        c.publish_joints(upper, [0, math.pi / 2], velocities=np.zeros(2))
        wait_for(c, "part", (1, 1, 1))
        c.detach(upper, part)
        c.sync(PATIENCE_S)
        c.publish_joints(upper, (0, 0), base=collided.Pose((0, 0, 5)), teleport=True)
        wait_for(c, "fore", (1, 0, 5))
        check(np.allclose(pose_of(c, "part").position, (1, 1, 1), atol=1e-12), "what was let go moves on")


def motions_are_tried_out():
    with connect() as c:
        robot, (upper, _) = arm(c)
        c.body("post", collided.sphere(0.1), pose=collided.Pose((0, 1.5, 1)), fixed=True)
        c.sync(PATIENCE_S)
        states = c.check_states(robot, [(0, 0), (math.pi / 2, 0)], measure=True)
        check([tried.verdict for tried in states] == [collided.Verdict.FREE, collided.Verdict.MEETS], f"{states}")
        check(states[0].lo <= states[0].hi and states[0].lo > 0, f"{states[0]}")
        check({states[1].a, states[1].b} == {"fore", "post"}, f"{states[1]}")
        edges = c.check_edges(robot, np.array([[(0, 0), (2, 0)], [(0, 0), (-1, 0)]]))
        check([tried.verdict for tried in edges] == [collided.Verdict.MEETS, collided.Verdict.FREE], f"{edges}")
        check(0.5 < edges[0].free_until < edges[0].met_at < 0.8, f"{edges[0]}")
        many = c.check_states(robot, np.zeros((3000, 2)))
        check(len(many) == 3000 and all(tried.verdict == collided.Verdict.FREE for tried in many), "not 3,000 free ones")


def what_is_wrong_is_named():
    with connect() as c:
        robot, (upper, fore) = arm(c)
        raises(collided.UnknownId, lambda: c.publish_joints(upper, (0, 0)))
        c.set_robot(upper, robot)
        c.sync(PATIENCE_S)
        raises(collided.BadArgument, lambda: c.publish_joints(upper, (0,)))
        raises(collided.BadArgument, lambda: c.publish_joints(upper, (math.nan, 0)))
        raises(ValueError, lambda: c.publish_joints(upper, (0, 0), velocities=(1,)))
        raises(collided.BadArgument, lambda: c.attach(upper, fore, fore))
        raises(collided.UnknownId, lambda: c.detach(upper, fore))
        raises(ValueError, lambda: c.check_states(robot, np.zeros((2, 3))))
        raises(collided.Unsupported, lambda: c.check_states(robot, [(5, 0)]))
        strange = collided.Robot([collided.Joint(collided.JointType.FIXED, parent=0, body="upper")])
        raises(collided.BadArgument, lambda: c.set_robot(upper, strange))


run(joints_move_links_and_what_is_gripped, motions_are_tried_out, what_is_wrong_is_named)
finish()
