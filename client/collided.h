/* collided: the client library of the collision daemon collided(8).
 *
 * A client publishes bodies and their poses, and is told what touches, what is near, and how sure that is. The same
 * program works over Cyclone DDS and LCM: the URI decides.
 *
 *     collided_def def = collided_def_default();
 *     def.name = "press";
 *     collided *c = collided_connect("dds://0", &def);
 *     collided_body_def box = collided_body_def_default();
 *     box.name = "part";
 *     box.shapes = (collided_shape[]){collided_box(0.1, 0.1, 0.05)};
 *     box.shape_count = 1;
 *     collided_body part = collided_create_body(c, &box);
 *     ...
 *     collided_close(c);
 *
 * Units: metres, seconds where a name ends in _s, nanoseconds where it ends in _ns. Frames are right-handed;
 * quaternions are (w, x, y, z). Threads: a client is used by one thread at a time; callbacks run inside collided_poll
 * (and the functions that say that they wait) on the calling thread (but see on_arrival), and must not call functions
 * that wait, which then refuse. A thread of the library keeps the lease alive as long as the process lives. Ownership:
 * definitions and what they point to are copied; what callbacks receive is valid during the call. Errors: functions
 * return a collided_status, or a handle whose id is COLLIDED_NONE; collided_error tells the rest. After a restart of
 * the daemon the library announces everything again by itself.
 *
 * Not safety-rated: do not let a human's safety depend on it alone. */
#ifndef COLLIDED_H
#define COLLIDED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A client: its connection, and what it has created. Made by collided_connect, freed by collided_close. */
typedef struct collided collided;

/* The id of no body, no subscription and no object. */
enum { COLLIDED_NONE = -1 };

typedef struct collided_body {
    int32_t id;
} collided_body; /* a body of this client; ids are not used again */
typedef struct collided_subscription {
    int32_t id;
} collided_subscription; /* a subscription of this client */
typedef struct collided_geometry {
    int64_t hash;
} collided_geometry; /* a hull's points or a mesh's triangles, by the hash of their content; 0 = none */

/* What a function came to; collided_error tells the rest. */
typedef enum collided_status {
    COLLIDED_OK = 0,
    COLLIDED_BAD_ARGUMENT,
    COLLIDED_UNKNOWN_ID,
    COLLIDED_REJECTED, /* the daemon refused it */
    COLLIDED_TIMEOUT,
    COLLIDED_NO_DAEMON, /* none is heard */
    COLLIDED_TRANSPORT, /* the transport failed */
    COLLIDED_UNSUPPORTED
} collided_status;

/* The status in words, for people. A constant string; any thread. */
const char *collided_status_text(collided_status status);
/* The release of this library, as "1.2.3". A constant string; any thread. */
const char *collided_version(void);

/* ---- connection ---- */

/* What becomes of the bodies when their client is lost: they are removed, stay but are unknown until the
 * client is back, or stay as they are, even after collided_close. */
typedef enum collided_on_loss { COLLIDED_REMOVE, COLLIDED_HOLD, COLLIDED_KEEP } collided_on_loss;

/* How to connect; begin with collided_def_default. */
typedef struct collided_def {
    const char *name;         /* for people; default: the program's name */
    int64_t id;               /* 0 = random. A fixed id lets a later process go on with the same bodies: sequence
                                 numbers start from the wall clock in microseconds, so that they keep growing */
    double lease_s;           /* lost after so long without a sign of life, at most 3600; default 2 */
    collided_on_loss on_loss; /* default COLLIDED_REMOVE */
    double connect_timeout_s; /* how long collided_connect waits for a daemon; default 5; 0 = do not wait */
    int32_t lock_step;        /* in lock-step with other simulators: how many there are together, with this one; the
                                 first step waits for so many. 0 (default) = not; see collided_step */
    const char *interface;    /* network interface; NULL = loopback only */
    const char *security;     /* DDS: folder of this client's certificate and permissions, as make_site makes it; NULL =
                                 what COLLIDED_SECURITY says; "" = none. One identity a process and domain */
    bool on_arrival;          /* callbacks for events run on the thread of DDS that receives them, at once, while this
                                 client's thread waits in collided_poll or another function that waits. That saves
                                 handing them over: about 7 us. They may publish with this
                                 client (not with another one), must not subscribe, and should be short: nothing else is
                                 received meanwhile. Default false; no difference with LCM */
} collided_def;
/* The defaults that the members of collided_def name. Any thread. */
collided_def collided_def_default(void);

/* Connects, and waits for a daemon as def says (NULL: the defaults). uri: "dds://DOMAIN" (0 to 230) or
 * "lcm://udpm://ADDRESS:PORT?ttl=0" ("lcm://" alone = LCM's default, ttl 0). LCM is for networks on which every host is
 * trusted: it has no security, and liblcm 1.3.1, which receives here, can be ended by one crafted datagram. NULL on
 * failure; the reason is then in collided_connect_error() of this thread. */
collided *collided_connect(const char *uri, const collided_def *def);
/* Why the last collided_connect of this thread failed, in one line; valid until its next one. "" = it did not. */
const char *collided_connect_error(void);

/* Leaves in order, and frees the client. The bodies are removed at once, unless on_loss is KEEP. Where a firewall drops
 * what this machine sends to itself, DDS cannot be ended: it is left behind after two seconds, and collided_connect
 * refuses that domain from then on. Not from a callback: it then does nothing, and collided_error says so. */
void collided_close(collided *c);

/* The last failure of this client, in one line; "" = none. Valid until the next call that takes the client. */
const char *collided_error(const collided *c);
/* The id under which the daemon knows this client: that of its definition, or the random one. */
int64_t collided_client_id(const collided *c);

/* Runs the callbacks. Waits for whatever comes for at most timeout_s (0 = only what is there). COLLIDED_OK also
 * when nothing came; COLLIDED_NO_DAEMON when no daemon has been heard for three seconds. */
collided_status collided_poll(collided *c, double timeout_s);

/* A descriptor for event loops (poll, epoll, GLib, libuv, asyncio): readable when collided_poll(c, 0) has something to
 * do. That is when an event, an answer or a refusal waits, when something has to be asked for again, or when the daemon
 * has fallen silent. Wait for it to be readable, then call collided_poll(c, 0); at times there turns out to be nothing.
 * Call collided_flush before waiting: waiting for a descriptor sends nothing. Always the same one; it is the client's,
 * closed by collided_close: do not read, write or close it. The client's thread calls this; any thread may wait. -1 if
 * the process may not have more descriptors; collided_error tells. Takes two of them with the first call. */
int collided_fd(collided *c);

/* Sends what is buffered now. collided_poll and collided_sync do so too. */
void collided_flush(collided *c);

/* Waits until the daemon has applied, or refused, all changes. These are what was created, changed or removed. And
 * until the first batch of each subscription has come: what the daemon tells from then on arrives on all of them, or is
 * told to be lost (collided_batch.lost). COLLIDED_REJECTED if it refused any since the last call (collided_error tells
 * the first); COLLIDED_TIMEOUT if something of that is outstanding. */
collided_status collided_sync(collided *c, double timeout_s);

/* What the daemon refused, and why. Valid during the callback. */
typedef struct collided_rejection {
    const char *message; /* "Body", ... */
    int32_t object;      /* body or subscription, COLLIDED_NONE */
    const char *reason;  /* "name_taken", ...; "unheard" refuses nothing: what is published does not come to the daemon,
                            since packets are lost or forged. The newest poses are sent again, by new writers */
    const char *text;
} collided_rejection;
/* Called for each refusal, inside collided_poll and functions that wait. */
typedef void collided_rejected(void *context, const collided_rejection *why);
/* Sets the callback for refusals, in place of the one before; NULL = none. `context` is handed to it. */
void collided_on_rejected(collided *c, collided_rejected *callback, void *context);

/* ---- geometry and shapes ---- */

/* Where a frame is in another: metres, and a unit quaternion. */
typedef struct collided_pose {
    double position[3];
    double orientation[4]; /* w, x, y, z */
} collided_pose;
/* The pose at the origin, not turned. Any thread. */
collided_pose collided_pose_identity(void);
/* The pose of c in a, where `outer` is that of b in a and `inner` that of c in b. Orientations must not be zero; that
 * of the product is a unit quaternion. Any thread. */
collided_pose collided_pose_product(collided_pose outer, collided_pose inner);

/* Kinds of shapes; each has a maker below. */
typedef enum collided_shape_type {
    COLLIDED_SPHERE,
    COLLIDED_CAPSULE,
    COLLIDED_BOX,
    COLLIDED_CYLINDER,
    COLLIDED_CONE,
    COLLIDED_ELLIPSOID,
    COLLIDED_HALFSPACE,
    COLLIDED_HULL,
    COLLIDED_MESH,
    COLLIDED_HEIGHT_FIELD,
    COLLIDED_COMPOUND,
    COLLIDED_SOFT
} collided_shape_type;

/* A shape, made by one of the makers below: convex, a mesh, a height field, or a compound. */
typedef struct collided_shape {
    collided_shape_type type;
    double half[3];     /* half extents, axis of revolution z: see the makers below */
    double radius;      /* rounding: all points within it of the rest count as the shape's */
    collided_pose pose; /* in the body's frame */
    collided_geometry geometry;
    const struct collided_shape *children; /* of a compound: borrowed, their poses are in its frame */
    size_t child_count;
    /* m, >= 0. What the shape stands for, if that is finer, is inside of it, and none of the shape's points is farther
     * than this from it. Lower bounds stay; upper bounds grow by the deviations of both, and are at least their sum. To
     * that of a compound's child the compound's own is added. */
    double deviation;
} collided_shape;

/* Sizes are full ones, in metres, as people measure, but for radii and semi-axes. Centred at the origin of the shape's
 * pose, which is the identity and can be set afterwards. Any thread. */
collided_shape collided_sphere(double radius);                   /* a sphere */
collided_shape collided_capsule(double radius, double length);   /* a capsule along z; length between its two centres */
collided_shape collided_box(double x, double y, double z);       /* a box, by its full side lengths */
collided_shape collided_cylinder(double radius, double height);  /* a cylinder along z */
collided_shape collided_cone(double radius, double height);      /* a cone: base at z = -height/2, apex at +height/2 */
collided_shape collided_ellipsoid(double x, double y, double z); /* an ellipsoid, by its semi-axes */
collided_shape collided_halfspace(void);                         /* a half-space: all points with z <= 0 */
collided_shape collided_hull(collided_geometry points);          /* a convex hull, made by collided_create_hull */
collided_shape collided_mesh(collided_geometry triangles);       /* a triangle mesh, made by collided_create_mesh */
collided_shape collided_height_field(collided_geometry heights); /* ground, made by collided_create_height_field */

/* One shape that is the union of others: with whatever it meets it makes one pair, one contact, one distance, along one
 * axis, where a body of as many shapes makes one each. `children`: 1 to 255 of any kind but half-spaces, meshes, height
 * fields and compounds, each with its pose in the compound's frame and a radius of its own; the compound's radius
 * rounds the whole. They are borrowed until collided_create_body or collided_change_body has returned, which copy them.
 * Like every shape it counts, and each child does, to the 256 of a body; in events it is one shape. Any thread. */
collided_shape collided_compound(const collided_shape *children, size_t count);

/* Makes a convex hull of points. There are `count` of them (x, y, z each); the daemon builds it. The same points give
 * the same geometry. The points, in metres, are copied. Hash 0 on failure. */
collided_geometry collided_create_hull(collided *c, const double *points, size_t count);

/* Makes a triangle mesh. There are `count` points (x, y, z each, in metres) and `triangle_count` triangles, three
 * indices of points each, counter-clockwise seen from outside. When every edge is walked once in either direction the
 * mesh is a solid, and what is inside of it touches it; otherwise it is a surface. The daemon mends what it can
 * (triangles turned the wrong way or given twice; points given twice; triangles without area, which become segments
 * and points, and are left out where others cover them), and says in its log and in the answer of `collidectl explain`
 * what the mesh is. It may be of several bodies, one inside of another, too. The same triangles give the same geometry.
 * Copied. Hash 0 on failure.
 */
collided_geometry collided_create_mesh(
    collided *c, const double *points, size_t count, const int32_t *triangles, size_t triangle_count);

/* Makes ground of heights over a grid. There are rows x columns `heights` in metres, at least 2 of each, row by row.
 * The grid is centred: column c stands at x = (c - (columns - 1) / 2) spacing_x and row r at y = (r - (rows - 1) / 2)
 * spacing_y, so that row 0 has the least y; z is the height as it is given. Each cell is two triangles, cut by the
 * diagonal from (column, row) to (column + 1, row + 1). It is a solid: all between that surface and a flat base `base`
 * below the lowest height; spacing and base are above 0. There are no holes: NaN and infinity are refused. At most
 * 4,194,304 triangles, two a cell and three for each step along the rim (1,446 x 1,446 heights). The same heights,
 * spacing and base give the same geometry. Copied. Hash 0 on failure.
 */
collided_geometry collided_create_height_field(
    collided *c, const double *heights, size_t rows, size_t columns, double spacing_x, double spacing_y, double base);

/* Makes the surface of a soft body: cloth, the skin of something soft, hair and cables. `points` are where its vertices
 * are at rest (count triples, m), `triangles` three indices each; (a, b, b) is an edge alone, as of hair, and (a, a, a)
 * a vertex alone. Features of one body within `ring` edges of each other (0 to 8; 0: those that share a vertex) are not
 * looked at, nor are those that are as near as rest_exclusion_m at rest (0: no such rule). Edges are counted by their
 * vertices: by the lesser one, then by the greater. Copied. Hash 0 on failure. */
collided_geometry collided_create_soft(collided *c, const double *points, size_t count, const int32_t *triangles,
    size_t triangle_count, int ring, double rest_exclusion_m);
/* A soft surface: the only shape of its body, at the identity. `thickness`, m: two surfaces are in contact when nearer
 * than half the sum of theirs. At first its vertices are at rest, at the body's pose; from then on poses mean nothing
 * to it, and collided_publish_vertices says where they are. Queries look at rigid bodies alone. Any thread. */
collided_shape collided_soft(collided_geometry surface, double thickness);

/* ---- bodies ---- */

/* Bodies that are fixed are not checked against each other. */
typedef enum collided_motion { COLLIDED_MOVING, COLLIDED_FIXED } collided_motion;

/* Is the motion of a body between two poses swept, for those who subscribe to impacts? Of a pair, one that is not OFF
 * is enough. */
typedef enum collided_ccd {
    COLLIDED_CCD_OFF,
    COLLIDED_CCD_LINEAR, /* its path, in the orientation that it has at the end */
    COLLIDED_CCD_FULL    /* its path and its turning; where angular velocities are published, whole turns, too */
} collided_ccd;

typedef struct collided_rule { /* ordered; the first that matches the other body decides */
    const char *pattern;       /* name pattern with '*' and '?', or "group:NAME" */
    bool allow;                /* true: touching is allowed, the pair is not looked at */
    const char *reason;        /* told by collided_query_explain */
    /* For the pairs that it checks; where the rules of both bodies say something, the larger number counts. */
    double padding_m; /* added to each subscription's threshold: they touch from here on (negative: only so deep) */
    double margin_m;  /* >= 0, added to each subscription's range: their distances are reported from farther away */
} collided_rule;

/* A body; begin with collided_body_def_default. Shapes, rules and names are copied. */
typedef struct collided_body_def {
    int32_t id;        /* >= 0: this number, so that a later process under the same client id can go on with the body;
                          COLLIDED_NONE (default): the next free one */
    const char *name;  /* unique in the world */
    const char *group; /* default "" */
    collided_motion motion;
    uint64_t category, mask;  /* a pair is checked when each one's mask has a bit of the other's; default 1 and all */
    bool one_way;             /* a hit box: its mask alone decides, whatever those of the bodies that it meets say; in
                                 events it is A, where the subscription leaves the choice. Of two such, either one's mask */
    collided_ccd ccd;         /* default COLLIDED_CCD_OFF */
    double acceleration_m_s2; /* >= 0: what is predicted of it holds for all motions that accelerate by at most so
                                 much, ... */
    double angular_acceleration_rad_s2; /* ... and so much; default 0: it moves on as it does */
    double deadline_s; /* a pose older than this is stale: its pairs are unknown, never free. 0 = never */
    collided_pose pose;
    int64_t stamp_ns; /* of the pose; 0 = now, and that makes no pose of it old, whatever clock those are stamped by */
    const collided_shape *shapes;
    size_t shape_count;
    const collided_rule *rules;
    size_t rule_count;
} collided_body_def;
/* The defaults that the members of collided_body_def name; name and shapes must be set. Any thread. */
collided_body_def collided_body_def_default(void);

/* Announces a body. It does not wait: whether the daemon took it is told by collided_sync, or to the callback of
 * collided_on_rejected. COLLIDED_NONE if the definition is wrong. */
collided_body collided_create_body(collided *c, const collided_body_def *def);
/* Changes a body. As if created anew under the same id: shapes, filter, everything but the contacts' ids of what did
 * not change. */
collided_status collided_change_body(collided *c, collided_body body, const collided_body_def *def);
/* Removes a body; its contacts end with the cause "removed". Does not wait. */
collided_status collided_remove_body(collided *c, collided_body body);
/* Takes over a body of an earlier process. One of the same client id created it (collided_body_def.id), so that it can
 * be moved or removed. It is not announced again; whether it exists is found out by the daemon. */
collided_body collided_adopt_body(collided *c, int32_t id);

/* Publishes the poses of many bodies. Plain arrays for `count` bodies: positions 3 each, orientations 4 each; linear
 * (m/s, at most 1e9) and angular (rad/s, world axes, at most 1e5) 3 each or NULL: what the bodies do from here on, for
 * what is predicted, and how many whole turns they made on their way. stamp_ns: when they were true (0 = now), on one
 * clock for all poses of a body, be it a simulator's; one that is older than the last pose of a body is refused
 * ("old_pose", told to the callback of collided_on_rejected, and of a step counted in collided_batch.refused); step: of
 * a simulator, or 0. Sent by the next flush or poll. Several poses of a body that fall into one tick make one motion,
 * straight from the last tick's to the newest. Lock-step: a step that is not 0 is answered on each of this client's own
 * subscriptions of rate_hz 0 by a batch whose `step` is that one, without events if there is nothing to report. When it
 * has come, all that the step brings about there has been told. (LCM may lose a datagram: publish the same again if no
 * answer comes.) */
collided_status collided_publish(collided *c, size_t count, const collided_body *bodies, const double *positions,
    const double *orientations, const double *linear, const double *angular, int64_t stamp_ns, int64_t step);
/* Ends a step of lock-step with other simulators, and waits until it is done. Between processes whose definition says
 * so (collided_def.lock_step) a step is done when each of them has published what it has under that number, in any
 * number of calls, and has ended it by this one, which one that has nothing to publish calls, too. The daemon keeps
 * what is published until then, applies it as a whole, and answers each of them on its subscriptions of rate_hz 0 by a
 * batch with that step, in which all is told that it moved, new or not. Steps are numbered alike by all, from above 0,
 * rising. Create bodies, subscribe, and collided_sync, before the first step. With lock_step = 1 a client alone has its
 * steps done as a whole.
 *
 * End now, wait later: with timeout_s 0 it sends the end, runs the callbacks of what has come, and does not wait
 * (called from a callback it runs none). Called again with the same step it waits for the same end, however often;
 * nothing is ended twice. Poses that are published for a step after its end begin it anew, as long as it is not done:
 * all of them have to come again, and another end. Over LCM, which may lose them: so on COLLIDED_TIMEOUT publish the
 * same step again. Without a pose of each body that it had before, the end is refused; and poses for a step that is
 * done are, unless they are the same again.
 *
 * One that is late by the daemon's step_timeout is gone on without, or waited for, by its step_policy: "step_missed" is
 * told to the callback of collided_on_rejected of each of them, and collided_batch.missing counts it; it is waited for
 * again once it ends a step.
 *
 * COLLIDED_OK: it is done, with all that reached the daemon of what was published for it. COLLIDED_TIMEOUT: it is not
 * known to be done within that time (0: not yet). COLLIDED_REJECTED: it is done, but without some of this client's
 * poses, which were refused (collided_error tells how many and why, as collided_batch.refused does); or its end was
 * refused: the others are beyond that step, or the one before is not done, or poses are to be sent again; or the daemon
 * refused each subscription of rate_hz 0. COLLIDED_BAD_ARGUMENT: this client is not in lock-step, or is to wait and has
 * no such subscription. */
collided_status collided_step(collided *c, int64_t step, double timeout_s);
/* Says what time it is in the simulation. In nanoseconds on its own clock, at least 0; 0 (as at the beginning) = it is
 * not told. What is published from now on, ends of steps included, carries it, and so do the batches that follow from
 * it (collided_batch.simulation_ns), beside the daemon's time: whoever logs or plots events need not translate. It
 * orders nothing and makes nothing old: that is for stamp_ns, on the clock of the computers. In lock-step all say the
 * same; if not, the latest counts. COLLIDED_BAD_ARGUMENT if it is negative. */
collided_status collided_set_simulation_time(collided *c, int64_t simulation_ns);
/* Publishes poses of bodies that did not move there. They are there from now on, without a motion that could be swept:
 * their contacts end with the cause "teleport". As collided_publish, but the stamp may also go back in time. */
collided_status collided_teleport(collided *c, size_t count, const collided_body *bodies, const double *positions,
    const double *orientations, const double *linear, const double *angular, int64_t stamp_ns, int64_t step);
/* Publishes the pose of one body, in the world, true now; sent by the next flush or poll. */
collided_status collided_move(collided *c, collided_body body, collided_pose pose);

/* ---- subscriptions and events ---- */

/* What is asked about a pair; bits of collided_subscription_def.facts. */
typedef enum collided_fact {
    COLLIDED_TOUCH = 1,
    COLLIDED_DISTANCE = 2,
    COLLIDED_MANIFOLD = 4,
    COLLIDED_IMPACT = 8,     /* what met on its way from one tick to the next: of bodies that say so (collided_ccd) */
    COLLIDED_PREDICT = 16,   /* what will meet within horizon_s, from velocities: published ones, or else those between
                                the last two stamped poses; whatever the bodies' collided_ccd */
    COLLIDED_POSES = 64,     /* with others: collided_batch.poses, so that each event can be proven where it is read */
    COLLIDED_FEATURES = 128, /* of soft bodies: which features meet on the way of each step ... */
    COLLIDED_SAFE_STEP = 256 /* ... and which share of the way is free for certain (collided_subscribe_soft) */
} collided_fact;

typedef enum collided_event_kind { /* numbers as on the wire. A later daemon may tell of kinds that are not here: an
                                      event of such a kind is to be passed over */
    COLLIDED_BEGIN = 1,
    COLLIDED_UPDATE,
    COLLIDED_END,
    COLLIDED_NEAR, /* within range_m, also where they touch or overlap: who asks for distances alone is told of these by
                      nothing else; beside touches it has an id of its own, and updates are the contact's while that is
                    */
    COLLIDED_FAR,
    COLLIDED_UNKNOWN,
    COLLIDED_KNOWN,
    COLLIDED_EVENT_IMPACT,    /* they met on their way; one event, without an end */
    COLLIDED_EVENT_PREDICTED, /* they will meet; reported again as long as they will */
    COLLIDED_EVENT_AVERTED    /* no more */
} collided_event_kind;

/* When two bodies meet. Proven in seconds after `start_ns`: they are apart before `lo_s`, and touch at `hi_s`. hi_s is
 * INFINITY where contact is not proven; take it for a contact. The event's `achieved` says why: COLLIDED_CERTAIN,
 * contact is proven; COLLIDED_WITHIN, they come nearer than the tolerance; COLLIDED_WIDE, the search ended at lo_s, of
 * which it may take about 100 ms a pair, and of what comes after nothing is known. */
typedef struct collided_impact {
    double lo_s, hi_s;
    int64_t
        start_ns; /* impact: stamp of the pose that the motion began with; predicted: of the newest pose of the two */
    collided_pose pose_a, pose_b; /* of the bodies, at lo_s, world */
    bool estimated;               /* predicted: a velocity was estimated from two poses */
} collided_impact;

/* How far a pair is looked into for its touch, distance and manifold
 * (/usr/share/doc/libcollided-dev/README.md, "The dial"). */
typedef enum collided_accuracy { /* numbers as on the wire */
    COLLIDED_BY_TOLERANCE,       /* until its interval is as narrow as the tolerance */
    COLLIDED_BY_BOXES,  /* touch, distance: bounds by boxes and one support point a shape. Told anew only when they
                           no longer hold; the cheapest. Who may touch is told to touch */
    COLLIDED_BY_VERDICT /* touch: until it is proven that they touch or not, in extended arithmetic where need be;
                           the interval is no narrower than that takes */
} collided_accuracy;

/* What an interval is, beside what was asked. */
typedef enum collided_achieved { /* numbers as on the wire */
    COLLIDED_CERTAIN,            /* as narrow as asked; and that they touch, are near, or are not, is proven */
    COLLIDED_WITHIN,             /* as narrow as asked; but the threshold (range, or 0) lies within it */
    COLLIDED_WIDE,               /* wider than asked: arithmetic, iterations, or the effort of one query of meshes,
                                    compounds or large hulls ended (about 10 ms, counted in steps, not by the clock); of
                                    a manifold, that not all parts were looked at for points */
    COLLIDED_STOPPED             /* wider than asked: the daemon's budget of a tick ended; it goes on in the next one.
                                    What is above, of a later daemon, promises no more than COLLIDED_WIDE */
} collided_achieved;

/* One of up to four points of a manifold. */
typedef struct collided_contact_point {
    double point[3]; /* world */
    double distance; /* m, signed */
    int64_t feature; /* stable id: what touches of A in the high half, of B in the low half */
} collided_contact_point;

/* What happened to a pair, with its proof. */
typedef struct collided_event {
    collided_event_kind kind;
    const char *cause; /* "motion", "removed", "owner_lost", "filter", "shape", "subscription", "shutdown", "stale",
                          "snapshot", "teleport"; of a later daemon also "unknown" */
    int64_t contact;   /* stable id from begin to end */
    const char *name_a, *name_b; /* name_b of an impact "*": it may have met anything, see client/README.md */
    int32_t shape_a, shape_b;
    double lo, hi;                 /* m: lo <= signed distance <= hi, certified; negative = depth */
    double axis[3];                /* unit, from A to B: proves lo */
    double point_a[3], point_b[3]; /* world: prove hi */
    double age_a_s, age_b_s;       /* age of the poses used, at the batch's stamp_ns; -1 = fixed or not stamped */
    double closing_m_s; /* at which the two points approach along the axis, as far as velocities are known; negative:
                           they part (in an impact: while others of the pair are about to meet, or contact is not
                           proven). With lo and the ages it tells what separation is left (in
                           /usr/share/doc/libcollided-dev/README.md, "Separation in a robot cell"); not safety-rated */
    collided_achieved achieved;
    const collided_contact_point *points;
    size_t point_count;
    const collided_impact *impact; /* of impacts and what is predicted: lo, hi, axis and points are those at
                                      impact->lo_s; otherwise NULL */
} collided_event;

typedef struct collided_batch { /* all events of one tick on one stream; or a heartbeat, of a stream that has been
                                   silent */
    collided_subscription subscription; /* whose stream it is; what another client's subscription publishes under the
                                   same stream name is not delivered */
    const char *stream;
    int64_t epoch, batch, tick, stamp_ns, latest_pose_ns, step;
    int64_t simulation_ns; /* what time it is in the simulation, as the newest step's poses said it: this client's, if
                              it says it, or else whoever's; 0 = nobody has (collided_set_simulation_time) */
    int32_t missing;       /* lock-step clients that the newest step was done without; negative: so many, and this
                              client is one of them */
    int32_t refused;       /* poses that this client published for that step and the daemon refused: they are not in it,
                              ... */
    const char *refusal;   /* ... and why the first of them was: "old_pose", "unknown_body", ...; "" = none was */
    int64_t
        undone;     /* pairs of this subscription that the budget of the tick left with a wider interval than it asks,
                       and all those (of any subscription) that max_pairs leaves out: of these nothing is reported at all */
    bool heartbeat; /* nothing has changed since the last batch, whose number this has: what was reported holds still.
                       Comes when a stream has been silent for the daemon's `heartbeat`, 1 s */
    int64_t oldest_pose_ns; /* of a heartbeat: the oldest stamp of the poses that what was reported rests on; 0 = none
                               is stamped. Poses that are sent again unchanged are no events, but count here */
    bool snapshot;          /* the whole current state: forget what you knew */
    bool closing;
    int64_t lost;   /* batches that were lost, or skipped since this client reads too slowly, before this one, which is
                       then a snapshot: after a loss nothing is delivered until the library has asked for one and got it,
                       or for what is missing */
    int32_t behind; /* so many messages of this stream, from this one on, waited in the daemon until this client had
                       read what came before: it comes late, or much came at once. 0 = it is up to date */
    bool starved;   /* a notice without events: nothing whole has come for 3 s, though the daemon is heard, and what was
                       delivered last is old. Given once; the next batch goes on, or is a snapshot */
    const collided_event *events;
    size_t event_count;
    const collided_pose *poses; /* two an event, of A's and B's bodies, world: those for which lo, hi, axis and points
                                   are (of what is predicted, those at impact->lo_s). An orientation of 0 0 0 0: not
                                   known, as in snapshots. NULL: not asked for with COLLIDED_POSES, or none is known */
} collided_batch;

/* Receives the batches of a subscription, in order, inside collided_poll and functions that wait. Who polls too rarely
 * for what he asks gets less, but never anything wrong: see `behind`, `lost` and `starved`. Nobody else waits for
 * him; the daemon's health is degraded, and names him, as long as he starves. */
typedef void collided_events(void *context, const collided_batch *batch);

/* What is to be told; begin with collided_subscription_def_default. Names and patterns are copied. */
typedef struct collided_subscription_def {
    unsigned facts;       /* of collided_fact; default COLLIDED_TOUCH */
    const char *select_a; /* pairs of a body that matches this and another that matches that; default "*", "*" */
    const char *select_b;
    const char *stream;         /* name of the stream; NULL = one of its own */
    double threshold_m;         /* a contact is a pair at or below it; default 0 */
    double range_m;             /* COLLIDED_DISTANCE: report pairs nearer than this */
    collided_accuracy accuracy; /* default COLLIDED_BY_TOLERANCE */
    double tolerance_m;         /* asked width of the intervals; default 0: relative_tolerance says it */
    double relative_tolerance;  /* the same as a share of the pair's size (the reaches of both shapes together), where
                                   tolerance_m is 0; 1e-15 to 1, default 1e-6. Both 0: as narrow as arithmetic gives.
                                   COLLIDED_TOUCH alone, with tolerance_m 0: of how deep a mesh is in something the
                                   first bracket is sent, COLLIDED_WIDE where it is wider */
    double hysteresis_m; /* >= 0, default 0: a contact ends, and near turns far, only so much beyond threshold_m and
                            range_m, so that what trembles there begins once and ends once */
    double horizon_s;    /* COLLIDED_PREDICT: how far ahead, from the newest pose of a pair on, to which an older one is
                            carried on; until so long after the older one; > 0, at most a day */
    double rate_hz;      /* updates at most so often; 0 = each tick */
    collided_events *callback;
    void *context;
} collided_subscription_def;
/* The defaults that the members of collided_subscription_def name; no callback. Any thread. */
collided_subscription_def collided_subscription_def_default(void);

/* Asks to be told. The first batch is a snapshot of the current state: contacts and what is near or predicted by then
 * are in it. Does not wait, and what happens before that batch and leaves no state is not reported: impacts, and what
 * began and ended. Who must not miss any of it, the impacts of the first step, say, calls collided_sync before.
 * COLLIDED_NONE if the definition is wrong. */
collided_subscription collided_subscribe(collided *c, const collided_subscription_def *def);
/* Ends a subscription: its callback is not called again. */
collided_status collided_unsubscribe(collided *c, collided_subscription subscription);

/* ---- soft bodies ---- */

/* Where vertices of a soft body are: those from `first` on, so many. Others stay where they are. */
typedef struct collided_vertices {
    const double *positions; /* m, world, three each; or ... */
    const float *singles;    /* ... three each, m, relative to origin: half the bandwidth. What is told is about
                                origin + single, added in double */
    double origin[3];
    size_t count;
    int32_t first;
    int64_t frame; /* yours, rising; results name it. 0: not counted (a body of more vertices than go into one message,
                      2,500 over LCM and 20,000 over DDS, needs it) */
    int64_t stamp_ns; /* as with poses; 0 = now */
    int64_t step;     /* as with poses: of a simulator, or 0 */
} collided_vertices;

/* Moves the vertices of a soft body there, each along the straight line from where it is. That is what steps are about:
 * what is told holds for the linear way of these very numbers. Of frames that come before the step of the one before is
 * found out the newest counts, and the way is the line to that (frames_skipped in Status). The body has to be known to
 * the daemon (collided_sync). Does not wait. A frame that goes in parts is taken as a whole or not at all. */
collided_status collided_publish_vertices(collided *c, collided_body body, const collided_vertices *vertices);
/* Asks what its way there would meet, while all other soft bodies stand. Nothing moves; the answer is a
 * collided_soft_pair with `proposed`. Up to 8 of a body may wait. */
collided_status collided_propose_vertices(collided *c, collided_body body, const collided_vertices *vertices);
/* Puts them there without a way: frames may count back from here. */
collided_status collided_teleport_vertices(collided *c, collided_body body, const collided_vertices *vertices);

/* What meets. The first feature is A's, the second B's. */
typedef enum collided_feature_kind {
    COLLIDED_VERTEX_FACE,
    COLLIDED_FACE_VERTEX,
    COLLIDED_EDGE_EDGE,
    COLLIDED_FACE_SHAPE /* a face of the soft body, and the rigid shape beside it: a is the face, b is 0 */
} collided_feature_kind;

/* How sure it is. */
typedef enum collided_feature_proof {
    COLLIDED_MEETS,           /* they meet by t_hi, for certain */
    COLLIDED_WITHIN_ROUNDING, /* as near as rounding can tell */
    COLLIDED_NOT_DECIDED      /* nearer than was found out; not called free */
} collided_feature_proof;

/* Two features that meet on the way of a step. */
typedef struct collided_feature {
    collided_feature_kind kind;
    collided_feature_proof proof;
    uint32_t a, b;    /* vertex, edge or face, as the surfaces count them */
    float t_lo, t_hi; /* share of the way: apart before t_lo, met by t_hi; rounded outwards */
    float normal[3];  /* unit, from A to B at t_lo, world: to about 1e-4, for people and solvers, no proof */
    float bary[2];    /* likewise: of the face its corners 1 and 2; of edges how far along A's and along B's */
} collided_feature;

/* What the step of a pair came to: of two bodies, or of a soft body with itself (the names are equal). */
typedef struct collided_soft_pair {
    const char *name_a, *name_b;
    int32_t shape_a, shape_b;
    int64_t contact; /* id of the contact that its events tell of; 0: they are in none, or TOUCH is not asked */
    int64_t frame_a, frame_b; /* that the way leads to; of a rigid body 0 */
    bool proposed;            /* nothing has moved */
    bool
        unfinished; /* it took more work than a step may: what was not looked at is unknown, never free; safe_lo is 0 */
    uint64_t vertex_face, edge_edge, face_shape; /* features that meet on the way, all of them ... */
    uint64_t within, undecided;                  /* ... of these as near as rounding tells; not decided ... */
    uint64_t left_out;                           /* ... and, with each_feature, those that are not in `features` */
    double safe_lo, safe_hi; /* share of the common way: nothing meets before safe_lo, and something has by safe_hi, for
                                certain. 1 and INFINITY: all of it is free; safe_hi 2: not known. With the accuracy
                                COLLIDED_BY_VERDICT safe_lo may be less than it could be */
    const collided_feature *features; /* with each_feature: by kind, then A's, then B's */
    size_t feature_count;
} collided_soft_pair;

/* All steps of a tick that a subscription is about. */
typedef struct collided_soft_steps {
    collided_subscription subscription;
    int64_t tick, stamp_ns, step;
    const collided_soft_pair *pairs;
    size_t pair_count;
} collided_soft_steps;

/* Receives them, before the events of their tick, where those are received. They are no state: what is lost is not told
 * again, and a snapshot has contacts, but no steps. */
typedef void collided_soft_steps_told(void *context, const collided_soft_steps *steps);

/* What is told of steps, and to whom. Zeros and a callback: counts, no single features. */
typedef struct collided_soft_def {
    bool each_feature; /* with COLLIDED_FEATURES: each of them; false: how many there are */
    int32_t most;      /* of a pair, at most, the first ones; the others are counted (left_out). 0 = all: a frame may
                          have 100,000 (2.7 MB) */
    collided_soft_steps_told *callback;
    void *context;
} collided_soft_def;

/* Subscribes as collided_subscribe does, to pairs of soft bodies, too: with COLLIDED_FEATURES and COLLIDED_SAFE_STEP in
 * def->facts steps are told to soft->callback; with COLLIDED_TOUCH their contacts begin and end like all others. A soft
 * pair is in contact when features meet, or come as near as threshold_m besides the thicknesses, on the way of its last
 * step; how far apart they are at its end is not told (lo and hi of the events are infinite). */
collided_subscription collided_subscribe_soft(
    collided *c, const collided_subscription_def *def, const collided_soft_def *soft);

/* ---- observing: which bodies there are, what they look like, and where ---- */

/* How a body stands; bits of collided_seen_body.flags. */
typedef enum collided_seen {   /* numbers as on the wire */
    COLLIDED_SEEN_STALE = 1,   /* past its deadline: its pairs are unknown, never free */
    COLLIDED_SEEN_HELD = 2,    /* its client was lost, and it stays: unknown until that is back */
    COLLIDED_SEEN_PENDING = 4, /* some of its pairs are not decided yet */
    COLLIDED_SEEN_FIXED = 8,
    COLLIDED_SEEN_SOFT = 16, /* deformable; no body is, in this release */
    COLLIDED_SEEN_SWEPT = 32,
    COLLIDED_SEEN_ONE_WAY = 64
} collided_seen;

/* A body of anybody's, as whoever observes is told it. */
typedef struct collided_seen_body {
    int32_t id; /* the daemon's own; after it was told to be gone, another body may have it */
    unsigned flags;
    const char *name, *group, *owner; /* owner: the name of its client */
    int64_t client;
    double deadline_s; /* 0 = never stale */
    collided_pose pose;
    const collided_shape *shapes; /* hashes of geometries are those of its client: collided_query_geometry */
    size_t shape_count;
} collided_seen_body;

/* What has changed since the last call, or all. */
typedef struct collided_scene {
    collided_subscription subscription;
    int64_t epoch, tick, stamp_ns;
    int64_t revision; /* of the bodies: rises with each change of them */
    int64_t lost;     /* batches that were lost before this one; then all comes again */
    bool whole;       /* forget what you knew: all bodies follow, in this call and in those after it */
    bool closing;     /* nothing more comes */
    const int32_t *removed;
    size_t removed_count;
    const collided_seen_body *bodies; /* new ones, or with new shapes */
    size_t body_count;
    const int32_t *ids; /* bodies that have moved, or whose flags have changed; ... */
    const collided_pose *poses;
    const unsigned *flags; /* ... of each; arrays of pose_count */
    size_t pose_count;
} collided_scene;

/* Is told of a scene, inside collided_poll and functions that wait. What it gets is valid during the call. Who polls
 * too rarely gets fewer states, each of them new: nothing is kept for him but one. */
typedef void collided_observed(void *context, const collided_scene *scene);

/* What to look at; begin with collided_observation_def_default. Names are copied. */
typedef struct collided_observation_def {
    const char *select; /* bodies, by a pattern as in subscriptions; default "*" */
    double rate_hz;     /* at most so often; default 30; 0 = each tick */
    const char *stream; /* as in collided_subscription_def */
    collided_observed *callback;
    void *context;
} collided_observation_def;
/* The defaults that the members of collided_observation_def name; no callback. Any thread. */
collided_observation_def collided_observation_def_default(void);

/* Asks to be shown the bodies. First all of them, then what changes; collided_unsubscribe ends it. A daemon that was
 * built before there were scenes refuses it ("malformed"). COLLIDED_NONE if the definition is wrong. Nobody's pairs are
 * computed for it, and while nobody observes it costs the daemon nothing. */
collided_subscription collided_observe(collided *c, const collided_observation_def *def);

/* What a geometry is. */
typedef enum collided_geometry_kind { /* numbers as on the wire */
    COLLIDED_GEOMETRY_HULL = 1,
    COLLIDED_GEOMETRY_MESH,
    COLLIDED_GEOMETRY_HEIGHT_FIELD
} collided_geometry_kind;

/* The numbers of a geometry, as its client sent them; freed by collided_geometry_numbers_free. */
typedef struct collided_geometry_numbers {
    collided_geometry_kind kind;
    double *vertices; /* three a point (m); of a height field: spacing along x and y, base, then the heights by rows */
    size_t vertex_numbers;
    int32_t *indices; /* three a triangle; of a height field: columns, rows; of a hull none */
    size_t index_count;
} collided_geometry_numbers;

/* Asks for the numbers of a geometry. `body` is the name of a body that has it, `geometry` that of one of its shapes.
 * Waits, and runs callbacks meanwhile. COLLIDED_UNKNOWN_ID if that body has none of that hash (any more). */
collided_status collided_query_geometry(
    collided *c, const char *body, collided_geometry geometry, double timeout_s, collided_geometry_numbers *out);
/* Frees what collided_query_geometry put into it, not the struct. One of zeros may be freed. Any thread. */
void collided_geometry_numbers_free(collided_geometry_numbers *numbers);

/* ---- queries: they wait for the answer, and run callbacks meanwhile ---- */

/* One body, or one pair, of an answer. */
typedef struct collided_hit {
    const char *name_a, *name_b;
    double lo, hi;
    double axis[3], point_a[3], point_b[3];
    double orientation[4];      /* collided_query_bodies */
    double age_s;               /* -1 = not stamped */
    bool stale;                 /* unknown: past the deadline */
    collided_achieved achieved; /* of the tolerance that was asked for; of bodies and boxes: 0 */
} collided_hit;

typedef struct collided_result { /* freed by collided_result_free; NULL may stand for it: the status alone is told */
    collided_hit *hits;
    size_t count;
    char *text; /* explain: lines for people */
    bool truncated;
    int64_t epoch, tick;
} collided_result;
/* Frees what a query put into a result, not the result itself. A result of zeros may be freed. Any thread. */
void collided_result_free(collided_result *result);

/* Asks for the first body along a ray. It goes from `origin` (m, world), at most length_m long. No hit: count 0. */
collided_status collided_query_ray(collided *c, const double origin[3], const double direction[3], double length_m,
    double timeout_s, collided_result *out);
/* Asks for the certified distance of two bodies now, as an interval at most tolerance_m wide. */
collided_status collided_query_distance(
    collided *c, const char *name_a, const char *name_b, double tolerance_m, double timeout_s, collided_result *out);
/* Asks for the bodies that overlap a box, given by its pose in the world and its half sides (m). */
collided_status collided_query_box(
    collided *c, const collided_pose *pose, const double half[3], double timeout_s, collided_result *out);
/* Asks for the first body that a box meets on its way. It has these half extents (zero = a point) and moves from `pose`
 * along `direction`, which need not be unit, by at most length_m: lo and hi of the hit bracket the free length, m. No
 * hit: count 0. */
collided_status collided_query_cast(collided *c, const collided_pose *pose, const double half[3],
    const double direction[3], double length_m, double timeout_s, collided_result *out);
/* Asks what a body would meet first. It would move and turn at these velocities (m/s, rad/s, world; NULL = 0) from
 * where it is, for span_s seconds, while all others stand: lo and hi of the hit bracket the time, s; hi is INFINITY
 * where contact is not proven. No hit: count 0, proven. */
collided_status collided_query_sweep(collided *c, const char *name, const double linear[3], const double angular[3],
    double span_s, double tolerance_m, double timeout_s, collided_result *out);
/* Asks for the nearest bodies, by rising lower bound. They are the `most` (0 = all) within `within_m` (may be INFINITY)
 * of the body `name`, or with NULL of a box (half extents; zero = a point) at `pose`. Touching ones have a negative
 * distance. */
collided_status collided_query_nearest(collided *c, const char *name, const collided_pose *pose, const double half[3],
    double within_m, int32_t most, double timeout_s, collided_result *out);
/* Asks why two bodies are checked against each other, or not: out->text names the rule that decided. */
collided_status collided_query_explain(
    collided *c, const char *name_a, const char *name_b, double timeout_s, collided_result *out);
/* Asks for the bodies whose names match a pattern with '*' and '?'. Of each: name_a, its pose in the world (point_a,
 * orientation) and its age. */
collided_status collided_query_bodies(collided *c, const char *pattern, double timeout_s, collided_result *out);

/* Starts or ends a recording on the daemon. It is in its record_dir, under a plain name without '/'; NULL or "" ends
 * it, which only who began it may. The answer's text tells the path, or why not (COLLIDED_UNSUPPORTED). */
collided_status collided_record(collided *c, const char *name, double timeout_s, collided_result *out);

/* ---- checks: a robot's configurations and motions, tried out without moving anything ---- */

typedef enum collided_joint_type { /* numbers as on the wire */
    COLLIDED_JOINT_FIXED,
    COLLIDED_JOINT_REVOLUTE,
    COLLIDED_JOINT_CONTINUOUS, /* turns without limits */
    COLLIDED_JOINT_PRISMATIC
} collided_joint_type;

/* A link of a robot, and the joint that moves it, as in URDF. */
typedef struct collided_joint {
    int32_t parent; /* index of a link before this one; -1 = the robot's base */
    collided_joint_type type;
    collided_pose origin; /* of the joint at value 0, in the parent's frame */
    double axis[3];       /* that it turns about (rad) or slides along (m), in its own frame; any length but 0 */
    double lower, upper;  /* rad or m; of fixed and continuous joints not looked at */
    bool mimics;          /* its value is that of the joint `mimic`, which moves by itself, times factor, plus offset */
    int32_t mimic;
    double factor, offset;
    const char
        *body; /* the body that is the link: its frame is the link's. Anybody's; NULL or "" = the link has none */
} collided_joint;

/* A kinematic tree whose links are bodies: their shapes, rules, groups and masks are the robot's. */
typedef struct collided_robot {
    const collided_joint *joints; /* 1 to 128, each behind its parent */
    size_t joint_count;
    collided_pose base; /* world */
} collided_robot;

typedef enum collided_verdict { /* numbers as on the wire */
    COLLIDED_CHECK_FREE,        /* proven: nothing is within the margin, nowhere on the way */
    COLLIDED_CHECK_MEETS,       /* proven: something is */
    COLLIDED_CHECK_UNDECIDED, /* neither: the distance is the margin but for rounding, or a body that a link is to keep
                                 away from is stale or held, and may be anywhere. It is not free */
    COLLIDED_CHECK_NOT_DONE   /* the time ran out */
} collided_verdict;

/* Begin with collided_check_options_default. */
typedef struct collided_check_options {
    double margin_m;     /* links and what they are to keep away from must be farther apart than this. 0 */
    double resolution_m; /* an edge is not looked at in finer steps than in which its links move by this. 1e-4 */
    bool find_first;     /* of an edge that meets something, narrow down where it does so first. true */
    bool measure;        /* of a configuration, tell the least distance, too. false */
    double tolerance_m;  /* to which it is measured. 1e-6 */
} collided_check_options;

/* What is told of a configuration, or of an edge. */
typedef struct collided_check_item {
    collided_verdict verdict;
    double first_lo, first_hi;   /* of an edge, from 0 to 1: it is free before first_lo, proven. At first_hi it meets
                                    something, if it is MEETS */
    double lo, hi;               /* m, measured: the least distance is in [lo, hi]; else -INFINITY and INFINITY */
    const char *name_a, *name_b; /* who meets, or is in doubt, or is nearest: a link's body, and another link's or an
                                    obstacle; NULL = nobody */
} collided_check_item;

typedef struct collided_checked { /* freed by collided_checked_free */
    collided_check_item *items;
    size_t count;
    char *text;          /* what made items undecided, for people; "" = nothing did */
    int64_t epoch, tick; /* of the daemon: the world as its tick left it, in which the last of them were tried out */
    char **names;        /* those that items point to */
    size_t name_count;
} collided_checked;

/* margin_m 0, resolution_m 1e-4, find_first, tolerance_m 1e-6; nothing is measured. */
collided_check_options collided_check_options_default(void);

/* How many numbers a configuration has: those of the joints that move and mimic no other, in their order. */
size_t collided_robot_coordinates(const collided_robot *robot);

/* Makes bodies move with the joints of a robot. `carrier` is a body of this client that the robot is known by from now
 * on, as a rule its first link; the links' bodies are this client's, too, and have been created. Where each of them is
 * follows from the joints' values that collided_publish_joints sends, and from robot->base; until then all stay where
 * they are. Kept, and announced again where that is needed, like the body itself; collided_change_body of the carrier
 * ends it. The robot is copied. COLLIDED_UNKNOWN_ID: no such carrier, or a link's body is not this client's. Whether
 * the joints make a tree is told as with bodies, by collided_sync and the callback of collided_on_rejected. */
collided_status collided_set_robot(collided *c, collided_body carrier, const collided_robot *robot);

/* The joints of a robot, and where its base is. Begin with zeros: arrays that are NULL are not sent. */
typedef struct collided_joint_state {
    const double *positions;                  /* rad or m, of the joints that move and mimic no other, in their order */
    const double *velocities;                 /* rad/s or m/s, of the same; NULL: not known */
    const collided_pose *base;                /* of a robot that moves about, world; NULL: collided_robot.base */
    const double *base_linear, *base_angular; /* with base and velocities: m/s, rad/s, world axes; NULL: 0 */
    bool teleport;                            /* it did not move there: as collided_teleport */
} collided_joint_state;

/* Publishes the values of a robot's joints. The daemon makes the links' poses of them (forward kinematics, in double
 * precision), and with velocities their linear and angular ones; all that collided_publish says of poses, stamps and
 * steps holds for these. `count`: collided_robot_coordinates. A joint beyond its limits is taken as it is, since where
 * the robot stands is what counts; the daemon counts it (joints_beyond). COLLIDED_UNKNOWN_ID: the body carries no
 * robot. COLLIDED_REJECTED: the daemon has refused one of its bodies. */
collided_status collided_publish_joints(collided *c, collided_body carrier, const collided_joint_state *state,
    size_t count, int64_t stamp_ns, int64_t step);

/* Makes a body ride with a link of a robot, at a pose in the link's frame: a gripped part. From the next values of the
 * joints on it moves with them, in one batch with the links. The rules say, as ever, what it may touch. In checks it is
 * one more fixed link of the collided_robot that they are asked of. COLLIDED_UNKNOWN_ID: the robot, its link or the
 * part is not there; COLLIDED_BAD_ARGUMENT: it rides with the robot already, or the pose is none. */
collided_status collided_attach(
    collided *c, collided_body carrier, collided_body part, collided_body link, const collided_pose *in_link);
/* Lets go of a part that was attached: it stays where it was last. */
collided_status collided_detach(collided *c, collided_body carrier, collided_body part);

/* Tells which configurations are free. That is: of all that the links' bodies are to keep away from, and of each other.
 * `positions`: count times collided_robot_coordinates numbers, rad or m. Nothing is moved, and no subscriber hears of
 * it. Obstacles stand as the daemon's last tick left them: where many items take several ticks, not all in the same
 * one. What is proven holds for the poses, joints and shapes as given, the joints' values read as real numbers. Method:
 * balls around parts of the links, then exact shapes (daemon/robot/check.h). NULL options = the defaults.
 * COLLIDED_UNSUPPORTED: the robot or a configuration is refused, collided_error says which (a joint beyond its limits,
 * no body of that name). COLLIDED_TIMEOUT: the items that are done are told. `out` is to be freed, whatever is
 * returned. */
collided_status collided_check_states(collided *c, const collided_robot *robot, const collided_check_options *options,
    const double *positions, size_t count, double timeout_s, collided_checked *out);

/* Tells which straight lines in joint space are free. Each goes from the first to the second of two configurations.
 * The whole line is proven, not samples of it. Values of continuous joints go the way that they are given, not the
 * shorter one. */
collided_status collided_check_edges(collided *c, const collided_robot *robot, const collided_check_options *options,
    const double *positions, size_t count, double timeout_s, collided_checked *out);

/* Frees what an answer owns. */
void collided_checked_free(collided_checked *checked);

/* ---- the daemon's state ---- */

/* A number that only grows, by name. */
typedef struct collided_counter {
    const char *name;
    int64_t value;
} collided_counter;

/* How the daemon is. */
typedef struct collided_daemon_status { /* valid until the next call that takes the client */
    int64_t epoch, tick, stamp_ns, started_ns;
    const char *health; /* "starting", "ready", "degraded", "stopping" */
    const char *daemon, *release, *links, *limits;
    const collided_counter *counters; /* the daemon's, then this client's own ("client_repeats", ...) */
    size_t counter_count;
} collided_daemon_status;
/* The last Status of the daemon; waits for one for at most timeout_s. COLLIDED_NO_DAEMON if none is heard. */
collided_status collided_get_status(collided *c, double timeout_s, collided_daemon_status *out);

/* ---- proof ---- */

/* A claim about the signed distance of two shapes, and what proves it. */
typedef struct collided_certificate {
    double lo, hi;
    double axis[3], point_a[3], point_b[3]; /* world */
} collided_certificate;

/* Re-checks a certificate. Needs the two shapes (whose body poses are pose_a, pose_b) and the claim alone, and uses
 * support points along the axis and the witness points: is it true that lo <= signed distance, and that it is <= hi
 * when the points are apart? `hull_a`, `hull_b`: the points of hulls (count triples), NULL otherwise. Pure; any thread.
 * COLLIDED_OK; COLLIDED_REJECTED if the certificate does not prove its claim; COLLIDED_BAD_ARGUMENT if a shape, pose or
 * hull is not usable, or a shape is a mesh or height field: no axis proves the distance of what is not convex. (A
 * mesh's vertices, passed as a hull, with hi = INFINITY: what keeps their hull at least lo away keeps the mesh there,
 * too.) Of compounds, which are not convex either, the points prove hi, and the axis proves lo where it parts the
 * convex hulls by so much. What they neither prove nor contradict is COLLIDED_UNSUPPORTED: hi is proven where it is not
 * negative, lo is the daemon's word. Compounds whose children are hulls are COLLIDED_BAD_ARGUMENT: there is no room for
 * their points. With lo = -INFINITY hi alone is checked, with hi = INFINITY lo alone. Sizes whose squares overflow are
 * REJECTED. Rounding is allowed for by 64 * 2^-53 times the sizes of the shapes and the distance of the bodies (for the
 * points: and their coordinates), so a claim that is wrong by 1e-9 of these is refused. That the shapes overlap by as
 * much as a negative hi says is not proven by points; what contradicts it is refused. The points are the shapes' own:
 * with deviations they prove hi if they are nearer to each other than hi by both deviations; of a compound, by its own
 * and that of the child which has the point. */
collided_status collided_verify(const collided_shape *a, const collided_pose *pose_a, const double *hull_a,
    size_t hull_a_count, const collided_shape *b, const collided_pose *pose_b, const double *hull_b,
    size_t hull_b_count, const collided_certificate *claim);

/* A hull's points, looked at and sorted once, for whoever checks many certificates of it: collided_verify looks at
 * every point each time. Worth it from 64 points on; of two hulls of 256 it saves a fifth to a half (script/bench
 * narrow). */
typedef struct collided_prepared_hull collided_prepared_hull;

/* Looks at a hull's points (count triples x, y, z) and keeps a copy. NULL if there are none, one is not finite, or
 * memory ran out. What it makes is yours to free; nothing changes it, so that any threads may use it at once. */
collided_prepared_hull *collided_prepare_hull(const double *points, size_t count);

/* Frees what collided_prepare_hull made. NULL is no error. */
void collided_free_prepared_hull(collided_prepared_hull *hull);

/* As collided_verify, with prepared hulls: NULL for shapes that are none. Pure; any thread. */
collided_status collided_verify_prepared(const collided_shape *a, const collided_pose *pose_a,
    const collided_prepared_hull *hull_a, const collided_shape *b, const collided_pose *pose_b,
    const collided_prepared_hull *hull_b, const collided_certificate *claim);

#ifdef __cplusplus
}
#endif

#endif
