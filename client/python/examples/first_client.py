"""README's first client, in Python: a ball swings through a block, and each event is printed.

collided & python3 first_client.py [URI]"""

import math
import sys

import collided

with collided.connect(sys.argv[1] if len(sys.argv) > 1 else "dds://0") as client:  # or "lcm://"
    ball = client.body("ball", collided.sphere(0.05))  # m
    client.body("block", collided.box(0.2, 0.2, 0.2), fixed=True)
    touches = client.watch()  # of all with all
    for i in range(600):  # the ball swings through the block
        ball.move((math.cos(0.02 * i), 0, 0))
        client.poll(0.01)  # sends, and waits for what comes
        for batch in touches.take():
            for event in batch:
                what = "begins" if event.kind == collided.Kind.BEGIN else "goes on, or ends"
                print(f"{event.a} and {event.b}: contact {what}")
