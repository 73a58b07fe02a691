#!/usr/bin/env python3
"""A client of collided without its library: a ball swings through a block over LCM, and what touches is printed.

    lcm-gen -p --ppath . collided.lcm && ./plain_client.py [PORT]      (lcm-gen: package liblcm-bin; nothing else is needed)

What the messages mean: ../README.md. Datagrams of LCM: "LC02", a number, the channel, a zero octet, the message."""
import itertools
import math
import random
import socket
import struct
import sys
import time

from collided import Ack, Body, Client, EventBatch, PoseBatch, Reject, Subscription  # what lcm-gen made

GROUP, PORT = "239.255.76.67", int(sys.argv[1]) if len(sys.argv) > 1 else 7667
ME = random.randrange(1, 2**63)  # the client's number in each message
SEQUENCE = itertools.count(time.time_ns() // 1000)  # of messages of all kinds, ever growing
last = 0  # the newest batch that was read
waiting = {}  # by sequence: a message that is neither acknowledged nor refused, when it is due again, and how long after

wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
wire.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
wire.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
wire.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)  # nothing leaves the machine
wire.bind((GROUP, PORT))
wire.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP) + socket.inet_aton("0.0.0.0"))


def send(message, datagrams=itertools.count()):
    channel = f"collided.in.{type(message).__name__}".encode()
    wire.sendto(struct.pack(">4sI", b"LC02", next(datagrams)) + channel + b"\0" + message.encode(), (GROUP, PORT))


def fill(message, **fields):
    """A message with these fields. Arrays get their lengths; an array of bytes that is not given is "" where lcm-gen made it."""
    given = {"version": Client.WIRE_VERSION, "client_id": ME, "sequence": next(SEQUENCE), **fields}
    for name in [n for n in message.__slots__ if n + "_n" in message.__slots__]:
        given[name] = given.get(name, [])
        given[name + "_n"] = len(given[name])
    for name, value in given.items():
        setattr(message, name, value)
    return message


def announce(message, **fields):
    """Sends a message again and again until its Ack or Reject comes: LCM loses datagrams."""
    waiting[fill(message, **fields).sequence] = [message, 0.0, 0.05]


def subscribe():
    announce(Subscription(), subscription_id=1, facts=Subscription.FACT_TOUCH, select_a="*", select_b="*")


def receive(data):
    global last
    channel, _, message = data[8:].partition(b"\0")
    if channel == b"collided.out.Ack.%016x" % ME:
        for sequence in Ack.decode(message).sequences:
            waiting.pop(sequence, None)
    elif channel == b"collided.out.Reject.%016x" % ME:
        reject = Reject.decode(message)
        waiting.pop(reject.sequence, None)
        print("refused:", reject.text, file=sys.stderr, flush=True)
    elif channel == b"collided.out.EventBatch.%016x.1" % ME:
        batch = EventBatch.decode(message)
        if batch.batch > last + (not batch.heartbeat) and not batch.snapshot:
            print(f"lost: batches after {last}", flush=True)
            subscribe()  # anew: a snapshot comes
        last = batch.batch
        for kind, a, b, lo, hi in zip(batch.kinds, batch.names_a, batch.names_b, batch.lo, batch.hi):
            if kind in (EventBatch.EVENT_BEGIN, EventBatch.EVENT_END):
                print("begin" if kind == EventBatch.EVENT_BEGIN else "end", a, b, f"{lo:.6f} {hi:.6f}", flush=True)


def create(number, name, motion, kind, size, radius):
    here = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]  # position, and a quaternion (w, x, y, z)
    announce(Body(), body_id=number, name=name, motion=motion, category=1, mask=-1, pose=here, shape_types=[kind], shape_sizes=size,
             shape_radii=[radius], shape_poses=here, shape_geometries=[0])


announce(Client(), name="plain", lease_ns=2_000_000_000)
create(1, "ball", Body.MOTION_MOVING, Body.SHAPE_SPHERE, [0.0, 0.0, 0.0], 0.05)
create(2, "block", Body.MOTION_FIXED, Body.SHAPE_BOX, [0.2, 0.2, 0.2], 0.0)
subscribe()
begun = heartbeat = time.monotonic()
moving = False
while (now := time.monotonic()) < begun + 6:
    if now > heartbeat + 0.6:  # a Client under a new sequence, every third of the lease
        heartbeat = now
        announce(Client(), name="plain", lease_ns=2_000_000_000)
    for entry in list(waiting.values()):
        if now >= entry[1]:
            send(entry[0])
            entry[1], entry[2] = now + entry[2], min(2 * entry[2], 1.0)
    moving = moving or not waiting  # once all is acknowledged: poses of a body that is not known yet are refused
    if moving:
        send(fill(PoseBatch(), stamp_ns=time.time_ns(), bodies=[1], positions=[math.cos(2 * (now - begun)), 0.0, 0.0],
                  orientations=[1.0, 0.0, 0.0, 0.0]))
    wire.settimeout(0.01)
    try:
        while True:
            receive(wire.recv(65536))
    except TimeoutError:
        pass
send(fill(Client(), removed=1, name="plain"))
