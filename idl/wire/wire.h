/* wire: the messages of collided as plain C values, the same for every transport.
 *
 * Units are SI, frames right-handed, quaternions (w, x, y, z), time nanoseconds since the Unix epoch. A message borrows
 * its strings and arrays: whoever fills it in owns them, and they must live as long as the message is in use. What has
 * been decoded by wire_lcm.h or wire_dds.h borrows from the arena or the sample that it was decoded from.
 *
 * The same fields, in the same order and under the same names, stand in collided.idl and collided.lcm, but for
 * `client`, `body`, `subscription` and `object`, which are `client_id`, `body_id`, `subscription_id` and `object_id`
 * there, and the `status` of an Answer, which is its `outcome`; wire_schema.h describes them as a table, from which
 * checking, coding and recording are made. The last field of each message is `extensions` (wire_extensions.h): it
 * carries what is added later. */
#ifndef COLLIDED_WIRE_WIRE_H
#define COLLIDED_WIRE_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { WIRE_VERSION = 1 }; /* the first field of each message; others are refused. What comes later is in extensions */

/* Limits: what is beyond is refused with WIRE_TOO_LARGE. */
enum {
    WIRE_NAME_MAX = 127,         /* bytes of a name, a group, a pattern or a stream */
    WIRE_TEXT_MAX = 4095,        /* bytes of a reason, an explanation */
    WIRE_SHAPES_MAX = 256,       /* shapes a body */
    WIRE_RULES_MAX = 1024,       /* filter rules a body */
    WIRE_POSES_MAX = 65536,      /* poses a batch */
    WIRE_PIECE_MAX = 65536,      /* numbers in one piece of a geometry */
    WIRE_GEOMETRY_MAX = 1 << 24, /* numbers in a whole geometry */
    WIRE_EVENTS_MAX = 65536,     /* events a batch */
    WIRE_ANSWERS_MAX = 4096,     /* hits in one answer */
    WIRE_COUNTERS_MAX = 1024,
    WIRE_LOCK_STEP_MAX = 65536,          /* clients in lock-step together */
    WIRE_EXTENSIONS_MAX = 65536,         /* bytes of the extensions of a message ... */
    WIRE_BATCH_EXTENSIONS_MAX = 1 << 20, /* ... of PoseBatch, VertexBatch, Answer and EventBatch */
    WIRE_RECORDS_MAX = 256               /* extensions a message */
};
#define WIRE_POSITION_MAX 1e12 /* m, each coordinate */
#define WIRE_SPEED_MAX 1e9     /* m/s, each component; m/s^2, rad/s^2 */
#define WIRE_SPIN_MAX 1e5      /* rad/s, each component: a bit more than any machine turns */
#define WIRE_SPAN_MAX 86400.0  /* s: horizons and sweeps */
#define WIRE_SIZE_MAX 1e9      /* m, a half extent or a radius; beyond is WIRE_BAD_SIZE */

/* Arrays of plain numbers. `count` counts numbers: three a point, four a quaternion. */
typedef struct wire_u8s {
    uint32_t count;
    const uint8_t *at;
} wire_u8s;
typedef struct wire_i32s {
    uint32_t count;
    const int32_t *at;
} wire_i32s;
typedef struct wire_i64s {
    uint32_t count;
    const int64_t *at;
} wire_i64s;
typedef struct wire_f64s {
    uint32_t count;
    const double *at;
} wire_f64s;
typedef struct wire_strings {
    uint32_t count;
    const char *const *at; /* none of them NULL */
} wire_strings;

typedef enum wire_kind {
    WIRE_NOTHING,
    /* from clients */
    WIRE_CLIENT,
    WIRE_GEOMETRY,
    WIRE_BODY,
    WIRE_POSE_BATCH,
    WIRE_VERTEX_BATCH,
    WIRE_SUBSCRIPTION,
    WIRE_QUERY,
    WIRE_RECEIPT,
    /* from the daemon */
    WIRE_ANSWER,
    WIRE_EVENT_BATCH,
    WIRE_STATUS,
    WIRE_REJECT,
    WIRE_ACK,
    WIRE_KIND_COUNT
} wire_kind;

/* Messages carry `version`, then `client` (a random or chosen 64-bit number, never 0: who sent it, or whom it is for),
 * then `sequence`: one counter a client over all of its messages, from 1, ever growing; it orders what a network does
 * not order, and names the message in Ack and Reject. `removed` = 1 takes the object back (the only fields that count
 * are then its keys). */

enum { WIRE_LOST_REMOVE = 0, WIRE_LOST_HOLD = 1, WIRE_LOST_KEEP = 2 };

/* Client: I am here. */
typedef struct wire_client {
    int32_t version;
    int64_t client;
    int64_t sequence;
    uint8_t removed;  /* 1: I leave, in order */
    uint8_t on_loss;  /* what becomes of my bodies when I am lost: WIRE_LOST_REMOVE; _HOLD (they stay, and count as
                         stale at once, until I am back); _KEEP (they stay as they are) */
    int64_t lease_ns; /* without a sign of life for this long, I am lost; the daemon takes an hour at most */
    int32_t
        lock_step;    /* in lock-step with others, so many with me: a step is done when each has published it. 0 = no */
    const char *name; /* for people */
    wire_u8s extensions;
} wire_client;

enum { WIRE_GEOMETRY_HULL = 1, WIRE_GEOMETRY_MESH = 2, WIRE_GEOMETRY_HEIGHT_FIELD = 3, WIRE_GEOMETRY_SOFT = 4 };

/* The vertices of a height field are no points: the spacing of its columns (along x) and of its rows (along y), how far
 * its base lies below the lowest height, all above 0; then the heights row by row, the row with the least y first. Its
 * indices are the numbers of columns and of rows, at least 2 each. */
enum { WIRE_FIELD_HEAD = 3 /* numbers before the heights */ };

/* Before the vertices of a soft surface, at rest, stand: its ring, a whole number (features of one body within so many
 * edges of each other are not looked at; 0: only those that share a vertex are not), its rest exclusion, m (nor are
 * those of one body that are as near as this at rest; 0: no such rule), and 0. Its indices are three a triangle;
 * (a, b, b) is an edge alone, as of hair and cables, and (a, a, a) a vertex alone. */
enum { WIRE_SOFT_HEAD = 3 /* numbers before the vertices */, WIRE_SOFT_RING_MAX = 8 };

/* Geometry: a hull, mesh or height field under the hash of its content (wire_geometry_hash), sent once, in one or more
 * pieces. It is whole when all numbers have come. */
typedef struct wire_geometry {
    int32_t version;
    int64_t client;
    int64_t sequence;
    uint8_t removed;
    uint8_t kind; /* WIRE_GEOMETRY_* */
    int64_t hash;
    int32_t vertex_numbers; /* of the whole: numbers in all vertices (three a vertex; see WIRE_FIELD_HEAD) */
    int32_t index_numbers;  /* of the whole: three a triangle; 0 for hulls; for a height field: 2 (columns, rows) */
    int32_t piece;          /* this piece, from 0: the numbers from piece * WIRE_PIECE_MAX on, vertices first, then */
    int32_t pieces;         /* indices. In so many pieces */
    wire_f64s vertices;     /* m */
    wire_i32s indices;
    wire_u8s extensions;
} wire_geometry;

enum { WIRE_MOTION_MOVING = 0, WIRE_MOTION_FIXED = 1 };
enum { WIRE_CCD_OFF = 0, WIRE_CCD_LINEAR = 1, WIRE_CCD_FULL = 2 };
enum {
    WIRE_RULE_ALLOW = 0,
    WIRE_RULE_CHECK = 1
}; /* touching is allowed, so the pair is not looked at; it is checked */

/* Body: a rigid thing with one or more shapes, under a name that is unique in the world. */
typedef struct wire_body {
    int32_t version;
    int64_t client;
    int64_t sequence;
    int32_t body; /* the client's own number for it, >= 0 */
    uint8_t removed;
    uint8_t motion;           /* WIRE_MOTION_*: fixed bodies are not checked against each other */
    uint8_t ccd;              /* WIRE_CCD_*: is its motion between two poses swept, for subscriptions in impacts */
    double acceleration_m_s2; /* >= 0: what is predicted holds for all motions that accelerate by at most so much ... */
    double angular_acceleration_rad_s2; /* ... and so much */
    const char *name;
    const char *group;     /* "" = none; subscriptions and rules select by it ("group:NAME") */
    int64_t category;      /* bits of what it is; a pair is checked when each one's mask has a bit of the other's */
    int64_t mask;          /* bits of what it meets */
    uint8_t one_way;       /* 1: its own mask alone decides about pairs with bodies that are not one-way */
    int64_t deadline_ns;   /* a pose older than this is stale: its pairs are unknown. 0 = never */
    int64_t stamp_ns;      /* of `pose` */
    uint8_t stamp_is_now;  /* 1: it is that of the announcement, and makes no pose old */
    wire_f64s pose;        /* 7 numbers: position, quaternion */
    wire_u8s shape_types;  /* a shape each, as WIRE_SHAPE_* */
    wire_f64s shape_sizes; /* 3 a shape; see WIRE_SHAPE_* */
    wire_f64s shape_radii; /* 1 a shape: rounding; a sphere's or capsule's radius */
    wire_f64s shape_deviations; /* 0 or 1 a shape, m, >= 0: how far a point of it may be from the true surface that it
                                   stands for; none = all 0 */
    wire_f64s shape_poses;      /* 7 a shape, in the body's frame */
    wire_i64s shape_geometries; /* 1 a shape: hash, 0 if it has none */
    wire_strings rule_patterns; /* ordered filter rules against other bodies: name patterns ('*', '?') or group:NAME; */
    wire_u8s rule_actions;      /* the first one that matches decides; WIRE_RULE_* */
    wire_strings rule_reasons;  /* told by explain */
    wire_f64s rule_paddings;    /* 1 a rule, m: added to the touch thresholds of the pairs that it checks */
    wire_f64s rule_margins;     /* 1 a rule, m, >= 0: added to the ranges of their distances */
    wire_u8s extensions;
} wire_body;

/* Sizes: half extents, axis of revolution z. */
enum {
    WIRE_SHAPE_SPHERE = 0,       /* 0 0 0; radius */
    WIRE_SHAPE_CAPSULE = 1,      /* 0 0 half length of the segment; radius */
    WIRE_SHAPE_BOX = 2,          /* half x, half y, half z */
    WIRE_SHAPE_CYLINDER = 3,     /* r, r, half height */
    WIRE_SHAPE_CONE = 4,         /* base r, base r, half height; apex at +z */
    WIRE_SHAPE_ELLIPSOID = 5,    /* semi-axes */
    WIRE_SHAPE_HALFSPACE = 6,    /* 0 0 0; solid below z = 0 */
    WIRE_SHAPE_HULL = 7,         /* 0 0 0; geometry */
    WIRE_SHAPE_MESH = 8,         /* 0 0 0; geometry */
    WIRE_SHAPE_HEIGHT_FIELD = 9, /* 0 0 0; geometry. Centred in x and y */
    WIRE_SHAPE_COMPOUND = 10,    /* n 0 0: the next n shapes are its children, at poses in its frame; no half-spaces,
                                    meshes, height fields or compounds */
    WIRE_SHAPE_SOFT = 11         /* 0 0 0; geometry: a soft surface; radius: half its thickness. The only shape of its
                                    body, at the identity; VertexBatch says where its vertices are (wire_soft.h) */
};

/* PoseBatch: new poses of many bodies of one client. */
typedef struct wire_pose_batch {
    int32_t version;
    int64_t client;
    int64_t sequence;
    int64_t stamp_ns;       /* when these poses were true */
    int64_t step;           /* the simulator's step, or 0 */
    int64_t simulation_ns;  /* what time it is in the simulation, >= 0; 0 = not given */
    wire_i32s bodies;       /* n of the client's body numbers */
    wire_f64s positions;    /* 3 n, m */
    wire_f64s orientations; /* 4 n */
    wire_f64s linear;       /* 0 or 3 n, m/s, world frame */
    wire_f64s angular;      /* 0 or 3 n, rad/s, world frame */
    wire_u8s teleports;     /* 0 or n: 1 = it did not move there, it is there: no motion is swept */
    wire_u8s extensions;
} wire_pose_batch;

/* VertexBatch: new vertices of a soft body, or a part of them: those from first_vertex on, in the world. What it
 * carries beyond that stands in wire_soft.h. */
typedef struct wire_vertex_batch {
    int32_t version;
    int64_t client;
    int64_t sequence;
    int64_t stamp_ns;
    int64_t step;
    int32_t body;
    int32_t shape;
    int32_t first_vertex;
    wire_f64s vertices;
    wire_u8s extensions;
} wire_vertex_batch;

enum {
    WIRE_FACT_TOUCH = 1,
    WIRE_FACT_DISTANCE = 2,
    WIRE_FACT_MANIFOLD = 4,
    WIRE_FACT_IMPACT = 8,
    WIRE_FACT_PREDICT = 16,
    WIRE_FACT_SCENE =
        32, /* alone: the bodies that match select_a, and their poses (WIRE_EXTENSION_SCENE, _BODY_POSES) */
    WIRE_FACT_POSES = 64, /* with others: each event carries the poses that it is proven for (WIRE_EXTENSION_POSES) */
    WIRE_FACT_FEATURES = 128, /* of soft bodies (wire_soft.h): which features meet on the way of each step */
    WIRE_FACT_SAFE_STEP = 256 /* and which share of the way is proven to be free */
};

/* Records in `extensions` that are given out: README.md tells their octets. */
enum {
    WIRE_EXTENSION_POSES = 1,      /* EventBatch: poses of both bodies of each event */
    WIRE_EXTENSION_SCENE = 2,      /* EventBatch: bodies that have come, changed or gone */
    WIRE_EXTENSION_BODY_POSES = 3, /* EventBatch: poses and flags of bodies, those that have changed */
    WIRE_EXTENSION_GEOMETRY = 4,   /* Answer: a piece of a geometry */
    WIRE_EXTENSION_CHECK = 5,      /* Query: a robot, and its configurations or motions (wire_robot.h) */
    WIRE_EXTENSION_CHECKED = 6,    /* Answer: what became of each of them */
    WIRE_EXTENSION_SOFT = 7,       /* and 8 to 10: soft bodies (wire_soft.h) */
    WIRE_EXTENSION_LAST = 12       /* 11 and 12: robots that bodies carry, and their joints (wire_model.h) */
};

/* Of a body in a scene, added up. */
enum {
    WIRE_SEEN_STALE = 1,   /* past its deadline: its pairs are unknown */
    WIRE_SEEN_HELD = 2,    /* its client was lost, and it stays: unknown until that is back */
    WIRE_SEEN_PENDING = 4, /* pairs of it are not decided yet */
    WIRE_SEEN_FIXED = 8,
    WIRE_SEEN_SOFT = 16,  /* room for deformable bodies */
    WIRE_SEEN_SWEPT = 32, /* its motion between two poses is swept */
    WIRE_SEEN_ONE_WAY = 64
};

/* How far a pair is looked into for its touch, distance and manifold. A pair that several subscriptions share gets what
 * the finest of them asks. */
enum {
    WIRE_BY_TOLERANCE = 0, /* until the interval is as narrow as the tolerance */
    WIRE_BY_BOXES = 1,     /* bounds by boxes and one support point a shape, reported anew when they no longer hold */
    WIRE_BY_VERDICT = 2    /* touch: until it is proven, in extended arithmetic where need be; no narrower */
};

/* What an interval is, beside what was asked. */
enum {
    WIRE_CERTAIN = 0, /* as narrow as asked; and that they touch, are near, or are not, is proven */
    WIRE_WITHIN = 1,  /* as narrow as asked; the threshold (range) lies within it */
    WIRE_WIDE = 2,    /* wider than asked, for arithmetic or iterations ended */
    WIRE_STOPPED = 3  /* wider than asked, for the budget of the tick ended: it goes on in the next one */
};

#define WIRE_FINEST_RELATIVE 1e-15 /* doubles do not tell less apart */

/* Subscription: what a subscriber wants to know, and the stream on which it wants to be told. */
typedef struct wire_subscription {
    int32_t version;
    int64_t client;
    int64_t sequence;
    int32_t subscription; /* the client's own number for it, >= 0 */
    uint8_t removed;
    int32_t facts;        /* WIRE_FACT_* */
    const char *stream;   /* its name; "" = "<client as 16 hex digits>.<subscription>". Letters, digits and . _ - : /
                             only, since it names a DDS partition and an LCM channel */
    const char *select_a; /* pairs of one body that matches this ... */
    const char *select_b; /* ... and another that matches this: name patterns ('*', '?') or group:NAME */
    double threshold_m;   /* touch: a contact is a pair whose signed distance is at most this; usually 0 */
    double range_m;       /* distance: report pairs nearer than this */
    double tolerance_m;   /* asked width of the intervals; 0: relative_tolerance says it */
    double relative_tolerance; /* the same as a share of the pair's size (the reaches of both shapes together), where
                                  tolerance_m is 0; 0 or 1e-15 .. 1. Both 0: as narrow as arithmetic gives */
    uint8_t accuracy;          /* WIRE_BY_*: how far a pair is looked into */
    double hysteresis_m;       /* >= 0: a contact ends, and near turns far, only so much beyond threshold_m, range_m */
    double horizon_s;          /* predict: contacts up to so long after the newest pose of a pair; > 0 */
    double rate_hz;            /* updates at most so often; 0 = every tick. Begins and ends are always sent at once */
    wire_u8s extensions;
} wire_subscription;

enum {
    WIRE_QUERY_RAY = 1,      /* origin, direction, length: first hit */
    WIRE_QUERY_DISTANCE = 2, /* name_a, name_b: signed distance of two bodies */
    WIRE_QUERY_BOX = 3,      /* origin, orientation, half: which bodies overlap that box */
    WIRE_QUERY_EXPLAIN = 4,  /* name_a, name_b: why is this pair checked, or not, and what is known of it */
    WIRE_QUERY_NEAREST = 5, /* name_a, or origin, orientation, half: the nearest bodies within length, at most `most` */
    WIRE_QUERY_CAST = 6,    /* origin, orientation, half, direction, length: first hit of a box that moves along it */
    WIRE_QUERY_BODIES = 7,  /* name_a as a pattern: list of bodies with their poses */
    WIRE_QUERY_RECORD = 8,  /* name_a: start a recording of that name in the daemon's record_dir; "" = end it */
    WIRE_QUERY_SWEEP = 9,   /* name_a, linear, angular, span_s: what that body would meet first, if it moved so */
    WIRE_QUERY_GEOMETRY =
        10,               /* name_a: a body; name_b: the hash of a geometry of it, 16 hex digits; most: which piece */
    WIRE_QUERY_CHECK = 11 /* configurations or motions of a robot: WIRE_EXTENSION_CHECK says which */
};

typedef struct wire_query {
    int32_t version;
    int64_t client;
    int64_t sequence;
    uint8_t kind; /* WIRE_QUERY_* */
    const char *name_a;
    const char *name_b;
    wire_f64s origin;      /* 0 or 3 numbers, m, world */
    wire_f64s orientation; /* 0 or 4 */
    wire_f64s half;        /* 0 or 3 */
    wire_f64s direction;   /* 0 or 3; need not be unit */
    double length_m;       /* INFINITY is allowed */
    double tolerance_m;
    int32_t most;      /* hits wanted at most; 0 = WIRE_ANSWERS_MAX */
    wire_f64s linear;  /* 0 or 3, m/s, world */
    wire_f64s angular; /* 0 or 3, rad/s, world */
    double span_s;     /* > 0 for a sweep */
    wire_u8s extensions;
} wire_query;

/* Receipt: how far a subscriber has got with the stream of one of its subscriptions. It paces what is sent, and is no
 * command. With epoch 0 it is of no stream, and says what its sender has published: `batch` is the sequence of the
 * newest PoseBatch, 0 = none. */
typedef struct wire_receipt {
    int32_t version;
    int64_t client;
    int64_t sequence;
    int32_t subscription;
    int64_t epoch;
    int64_t batch;   /* the last one that came in order; 0 = none */
    int64_t tick;    /* of a snapshot that is not whole yet: its tick; 0 = `batch` itself has come */
    int32_t part;    /* of that snapshot: the last part that came in order; otherwise 0 */
    uint8_t missing; /* 1: something behind it is missing: send on from there */
    wire_u8s extensions;
} wire_receipt;

enum { WIRE_ANSWER_OK = 0, WIRE_ANSWER_UNKNOWN_NAME = 1, WIRE_ANSWER_UNSUPPORTED = 2, WIRE_ANSWER_TRUNCATED = 3 };

/* Answer: arrays with one entry a hit. */
typedef struct wire_answer {
    int32_t version;
    int64_t client;   /* for whom */
    int64_t sequence; /* of the query */
    int64_t epoch;
    int64_t tick;
    int64_t stamp_ns;       /* when that tick ran; ages count from here */
    uint8_t kind;           /* of the query */
    uint8_t status;         /* WIRE_ANSWER_* */
    const char *text;       /* explain: lines for people; otherwise what went wrong, or "" */
    wire_strings names_a;   /* the body (ray, box, nearest, bodies), or A */
    wire_strings names_b;   /* B, or empty strings */
    wire_f64s lo;           /* signed distance (ray: along the ray), certified lower ... */
    wire_f64s hi;           /* ... and upper bound */
    wire_f64s axes;         /* 3 a hit: unit, from A to B, world; ray: the surface's normal */
    wire_f64s points_a;     /* 3 a hit, world; bodies: position */
    wire_f64s points_b;     /* 3 a hit, world */
    wire_f64s orientations; /* bodies: 4 a hit; otherwise empty */
    wire_i64s ages_ns;      /* 1 a hit: age of the older pose that it rests on, -1 = not stamped */
    wire_u8s stale;         /* 1 a hit: 1 = past the deadline, unknown */
    wire_u8s achieved;      /* WIRE_CERTAIN ..., 0 or 1 a hit */
    wire_u8s extensions;
} wire_answer;

enum {
    WIRE_EVENT_BEGIN = 1,     /* a contact began */
    WIRE_EVENT_UPDATE = 2,    /* it persists */
    WIRE_EVENT_END = 3,       /* it ended; `causes` says by what */
    WIRE_EVENT_NEAR = 4,      /* not in contact, nearer than the subscription's range: distance */
    WIRE_EVENT_FAR = 5,       /* no longer within range */
    WIRE_EVENT_UNKNOWN = 6,   /* a pose is past its deadline: nothing can be said of this pair, it is not free */
    WIRE_EVENT_KNOWN = 7,     /* and can be said again; its state follows */
    WIRE_EVENT_IMPACT = 8,    /* they met on their way from one tick to the next */
    WIRE_EVENT_PREDICTED = 9, /* they will meet within the horizon; reported again as long as they will */
    WIRE_EVENT_AVERTED = 10   /* no more */
};

enum { /* why an event: what ended a contact, or made a pair unknown */
    WIRE_CAUSE_MOTION = 0,
    WIRE_CAUSE_REMOVED = 1, /* the body was removed */
    WIRE_CAUSE_OWNER_LOST = 2,
    WIRE_CAUSE_FILTER = 3,
    WIRE_CAUSE_SHAPE = 4,        /* the body's shapes changed */
    WIRE_CAUSE_SUBSCRIPTION = 5, /* the subscription was changed or removed */
    WIRE_CAUSE_SHUTDOWN = 6,
    WIRE_CAUSE_STALE = 7,
    WIRE_CAUSE_SNAPSHOT = 8, /* it began before; reported again as part of the current state */
    WIRE_CAUSE_TELEPORT = 9  /* a body is elsewhere, without a motion there */
};

/* EventBatch: what happened on one stream in one tick. Arrays with one entry an event. */
typedef struct wire_event_batch {
    int32_t version;
    int64_t client; /* of the subscription */
    int32_t subscription;
    int64_t epoch; /* changes when the daemon restarts, or its standby takes over: see wire_same_line */
    int64_t batch; /* number of the batch on this stream, from 1, without gaps */
    int64_t tick;
    int64_t stamp_ns;       /* when the tick ran */
    int64_t latest_pose_ns; /* the newest pose stamp that this tick applied, 0 = none */
    int64_t step;           /* the newest simulation step */
    int64_t simulation_ns;  /* the newest time that a simulation told with its poses; 0 = none has */
    int32_t missing;        /* lock-step clients that had not published this step when it was done without them;
                               negative: the stream's own client is among them */
    int32_t refused;        /* poses of this step, of the stream's own client, that were refused ... */
    uint8_t refusal;        /* ... and why the first of them was: a wire_reason; WIRE_OK: none was */
    int64_t undone;    /* pairs of this subscription that the budget left with a wider interval than it asks, and all
                          that max_pairs leaves out */
    uint8_t heartbeat; /* 1: nothing is reported, and `batch` is the number of the last batch again */
    int64_t
        oldest_pose_ns; /* of a heartbeat: the oldest stamp that what is reported now rests on, 0 = none is stamped */
    uint8_t snapshot;   /* 1: the whole state as of `batch`; forget what you knew. Sent first, and after a loss */
    uint8_t closing;    /* 1: the stream ends with this batch */
    int32_t part;       /* a large batch comes in parts, 0 .. parts - 1. Each has a number of its own, but those of a
                           snapshot all have that of the last batch before it */
    int32_t parts;
    int32_t behind; /* messages of this stream, this one and those behind it, that wait for receipts; 0 = none:
                       it is up to date */
    const char *stream;
    wire_u8s kinds;     /* WIRE_EVENT_* */
    wire_u8s causes;    /* WIRE_CAUSE_* */
    wire_i64s contacts; /* the id: of a contact, or of the pair when it is only near */
    wire_strings names_a;
    wire_strings names_b;
    wire_i32s shapes_a; /* index of the shape in its body */
    wire_i32s shapes_b;
    wire_f64s lo; /* m, signed distance: certified interval. Unknown: -infinity .. infinity */
    wire_f64s hi;
    wire_f64s axes;      /* 3 an event: unit, from A to B, world */
    wire_f64s points_a;  /* 3 an event, world */
    wire_f64s points_b;  /* 3 an event, world */
    wire_i64s ages_a_ns; /* age of A's pose at stamp_ns; -1 = fixed or not stamped */
    wire_i64s ages_b_ns;
    wire_f64s closings;       /* m/s along the axis, from velocities as far as they are known; positive = approaching */
    wire_u8s achieved;        /* WIRE_CERTAIN ... */
    wire_u8s manifold_counts; /* points of each event, 0 to 4 */
    wire_f64s manifold_points;    /* 3 a point, world */
    wire_f64s manifold_distances; /* 1 a point */
    wire_i64s manifold_features;  /* 1 a point */
    wire_f64s impact_times;     /* 2 an impact (IMPACT, PREDICTED): s after its start; apart before the first, touching
                                   at the second, both proven; the second may be infinite: not proven */
    wire_i64s impact_starts_ns; /* 1 an impact: IMPACT: stamp of the pose the longer motion began with; PREDICTED: of
                                   the newest pose */
    wire_f64s impact_poses;     /* 14 an impact: A's and B's bodies at the first of the two times */
    wire_u8s impact_estimated;  /* 1 an impact: 1 = a velocity was estimated from two poses */
    wire_u8s extensions;
} wire_event_batch;

enum { WIRE_HEALTH_STARTING = 0, WIRE_HEALTH_READY = 1, WIRE_HEALTH_DEGRADED = 2, WIRE_HEALTH_STOPPING = 3 };

/* Status: once a second, and when it changes. */
typedef struct wire_status {
    int32_t version;
    int64_t epoch;
    uint8_t health;      /* WIRE_HEALTH_* */
    const char *daemon;  /* its name: host:pid */
    const char *release; /* of the software */
    const char *links;   /* what it listens on and who can reach it, for people */
    const char *limits;  /* limits reached, for people; "" = none */
    int64_t stamp_ns;
    int64_t started_ns;
    int64_t tick;
    wire_strings counter_names; /* metrics, drops by cause; see the protocol page */
    wire_i64s counter_values;
    wire_u8s extensions;
} wire_status;

typedef enum wire_reason {
    WIRE_OK,
    WIRE_WRONG_VERSION,
    WIRE_MALFORMED,    /* lengths that do not fit each other, unknown enumerators, text that is not UTF-8 */
    WIRE_BAD_NUMBER,   /* NaN or infinity */
    WIRE_BAD_ROTATION, /* a quaternion whose norm is not near 1 */
    WIRE_BAD_SIZE,     /* negative, zero where there must be a solid, or absurd */
    WIRE_BAD_NAME,     /* empty, with control characters, or with what a stream's name may not have */
    WIRE_TOO_LARGE,    /* beyond a limit */
    WIRE_FLAT_HULL,
    WIRE_BAD_HASH, /* the content does not have that hash */
    WIRE_UNKNOWN_CLIENT,
    WIRE_UNKNOWN_BODY,
    WIRE_UNKNOWN_GEOMETRY,
    WIRE_NAME_TAKEN, /* by another body or client */
    WIRE_NOT_YOURS,
    WIRE_UNSUPPORTED,
    WIRE_LIMIT,       /* a limit of this daemon's configuration; the text names it */
    WIRE_OLD_POSE,    /* its stamp is older than that of the pose before */
    WIRE_BAD_STEP,    /* of lock-step: done already, or the step before is not done yet */
    WIRE_STEP_MISSED, /* no refusal: a lock-step client has not published a step in time, and what comes of it */
    WIRE_UNHEARD,     /* no refusal: what the client says that it has published does not come */
    WIRE_REASON_COUNT
} wire_reason;

/* Reject: which message was refused, and why. */
typedef struct wire_reject {
    int32_t version;
    int64_t client;   /* for whom; 0 if it cannot be told */
    int64_t sequence; /* of the message, 0 if it cannot be told */
    int64_t epoch;
    uint8_t kind;   /* wire_kind of the message */
    int32_t object; /* body or subscription, -1 = none */
    uint8_t reason; /* wire_reason */
    const char *text;
    wire_u8s extensions;
} wire_reject;

/* Ack: these messages have been applied (Client, Geometry, Body, Subscription). One that is refused has a Reject
 * instead.
 */
typedef struct wire_ack {
    int32_t version;
    int64_t client;
    int64_t epoch;
    wire_i64s sequences;
    wire_u8s extensions;
} wire_ack;

typedef struct wire_message {
    wire_kind kind;
    union {
        int32_t version; /* of any */
        wire_client client;
        wire_geometry geometry;
        wire_body body;
        wire_pose_batch pose_batch;
        wire_vertex_batch vertex_batch;
        wire_subscription subscription;
        wire_query query;
        wire_receipt receipt;
        wire_answer answer;
        wire_event_batch event_batch;
        wire_status status;
        wire_reject reject;
        wire_ack ack;
    };
} wire_message;

/* Why a message was refused. */
typedef struct wire_refusal {
    wire_reason reason;
    char text[256]; /* which field and what is allowed: "positions[12] is not a number" */
} wire_refusal;

/* Checks everything that can be told without the world: version, numbers, rotations, sizes, lengths, names, limits.
 * WIRE_OK, or the reason, which is also in *refusal. Pure; any thread. */
wire_reason wire_check(const wire_message *m, wire_refusal *refusal);

const char *wire_kind_name(wire_kind kind);       /* "Client", ... */
const char *wire_reason_name(wire_reason reason); /* "wrong_version", ... */

/* Client and sequence of a message (0 where it has none), and its body or subscription (-1 if none): for Ack and
 * Reject. */
void wire_origin(const wire_message *m, int64_t *client, int64_t *sequence, int32_t *object);

/* An epoch is the time of the daemon's start but for its last 16 bits, which count how often its standby took over:
 * epochs that differ in these alone are of one line, in which streams go on, and whatever came under a lower one is not
 * to be believed any more once a higher one was seen. */
enum { WIRE_LINE_BITS = 16 };
static inline int64_t wire_new_line(int64_t start_ns)
{
    return start_ns >> WIRE_LINE_BITS << WIRE_LINE_BITS;
}
static inline bool wire_same_line(int64_t a, int64_t b)
{
    return a >> WIRE_LINE_BITS == b >> WIRE_LINE_BITS && a != 0 && b != 0;
}

/* 64-bit content hash of a whole geometry (FNV-1a over kind, counts and the numbers' bytes, little-endian); not 0. */
int64_t wire_geometry_hash(uint8_t kind, wire_f64s vertices, wire_i32s indices);

#endif
