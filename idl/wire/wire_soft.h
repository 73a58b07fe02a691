/* wire_soft: what messages carry of soft bodies beyond their fields, as records of `extensions` (wire_extensions.h):
 * frames of vertices in parts and in single precision, what a subscriber wants of them, and what a step of them comes
 * to. All numbers in the records are little-endian, without padding. Pure; any thread. */
#ifndef COLLIDED_WIRE_SOFT_H
#define COLLIDED_WIRE_SOFT_H

#include "wire.h"

enum {                      /* ids of records */
    WIRE_SOFT_FRAME = 7,    /* of a VertexBatch: frame, part, parts, mode */
    WIRE_SOFT_SINGLES = 8,  /* of a VertexBatch: an origin and vertices in single precision, instead of `vertices` */
    WIRE_SOFT_INTEREST = 9, /* of a Subscription: most, grain */
    WIRE_SOFT_STEP = 10     /* of an EventBatch: pairs, and their features */
};

enum {                      /* of frames */
    WIRE_SOFT_MOVE = 0,     /* the vertices move there, each on a straight line */
    WIRE_SOFT_PROPOSE = 1,  /* is that way free? Nothing moves */
    WIRE_SOFT_TELEPORT = 2, /* they are there, without a way */
    WIRE_SOFT_MODES
};

enum { WIRE_SOFT_PARTS_MAX = 4096, WIRE_SOFT_VERTICES_MAX = 87000 /* singles of one message */ };

/* What a VertexBatch means with its records. Without a record of its frame it is one by itself, that moves. */
typedef struct wire_soft_frame {
    int64_t frame; /* the client's count of them, rising; 0: not counted */
    int32_t part, parts, mode;
    uint32_t vertices;      /* in this message */
    bool single;            /* of which: */
    double origin[3];       /* m; a vertex is origin + its singles, added in double */
    const uint8_t *singles; /* three floats each */
} wire_soft_frame;
bool wire_soft_read_frame(const wire_vertex_batch *m, wire_soft_frame *out); /* false: a record is damaged */
void wire_soft_vertex(const wire_vertex_batch *m, const wire_soft_frame *f, uint32_t i, double out[3]);

/* Room for the records of one message: its extensions are in `to`, which has room for
 * WIRE_SOFT_FRAME_BYTES + 12 * vertices octets. Returns how many they are. */
enum { WIRE_SOFT_FRAME_BYTES = 64 };
uint32_t wire_soft_put_frame(const wire_soft_frame *f, const float *singles, uint8_t *to);

enum {                     /* grain */
    WIRE_SOFT_SUMMARY = 0, /* a line a pair */
    WIRE_SOFT_EACH = 1,    /* and its features */
    WIRE_SOFT_GRAINS
};

typedef struct wire_soft_interest {
    int32_t grain; /* WIRE_SOFT_SUMMARY ... */
    int32_t most;  /* features of a pair that are told at most; 0: all. The others are counted */
} wire_soft_interest;
void wire_soft_read_interest(wire_u8s extensions, wire_soft_interest *out); /* none: a summary */
enum { WIRE_SOFT_INTEREST_BYTES = 16 };
uint32_t wire_soft_put_interest(const wire_soft_interest *of, uint8_t to[WIRE_SOFT_INTEREST_BYTES]);

enum { /* kinds of features that meet: the first is A's, the second B's */
    WIRE_SOFT_VERTEX_FACE = 0,
    WIRE_SOFT_FACE_VERTEX = 1,
    WIRE_SOFT_EDGE_EDGE = 2,
    WIRE_SOFT_FACE_SHAPE = 3 /* a face of the soft body, and the rigid shape as a whole */
};
enum { WIRE_SOFT_CERTAIN = 0, WIRE_SOFT_WITHIN = 1, WIRE_SOFT_UNDECIDED = 2 }; /* proofs */

typedef struct wire_soft_feature {
    uint8_t kind, proof;
    uint32_t a,
        b; /* vertices, edges and faces of the soft surfaces, as their geometries count them; b of a rigid shape: 0 */
    float t_lo, t_hi; /* of the way, in [0, 1]: apart before, met by; rounded outwards */
    float normal[3];  /* unit, from A's feature to B's at t_lo, world; to 1e-4 */
    float bary[2];    /* of the face its corners 1 and 2, of the edges how far along A's and B's; 0 to 1, to 1e-4 */
} wire_soft_feature;

enum {                       /* flags of a pair */
    WIRE_SOFT_PROPOSED = 1,  /* of a proposed frame: nothing has moved */
    WIRE_SOFT_UNFINISHED = 2 /* it took more work than a step may: what was not looked at is unknown, never free */
};

typedef struct wire_soft_pair {
    int64_t contact;          /* id of the contact, 0: they are in none */
    int64_t frame_a, frame_b; /* that the way leads to; of a rigid body 0 */
    int32_t shape_a, shape_b;
    uint8_t flags;
    uint64_t vertex_face, edge_edge, face_shape; /* contacts on the way */
    uint64_t within, undecided;  /* of these: as near as rounding can tell; not decided, and not called free */
    uint64_t left_out;           /* of these, not told for want of room (most) */
    double safe_lo, safe_hi;     /* nothing meets before lo; by hi something has for certain. 1 and infinity: free. Of a
                                    pair     nobody asked a safe step of: as far as the verdicts show */
    const char *name_a, *name_b; /* the same for a body with itself */
    uint32_t features;           /* of this pair in this message */
} wire_soft_pair;

/* One part of a step, as an EventBatch carries it. Writing: begin, then for each pair wire_soft_put_pair and its
 * features. The octets are in `to`, which grows: the caller's wire_soft_bytes. */
typedef struct wire_soft_writer {
    uint8_t *at;
    size_t count, capacity;
    uint32_t pairs;
} wire_soft_writer;
void wire_soft_begin(wire_soft_writer *w); /* keeps its room */
void wire_soft_put_pair(wire_soft_writer *w, const wire_soft_pair *p);
void wire_soft_put_feature(wire_soft_writer *w, const wire_soft_feature *f);
wire_u8s wire_soft_end(wire_soft_writer *w); /* as extensions; valid until the next begin */
void wire_soft_free(wire_soft_writer *w);
enum { WIRE_SOFT_FEATURE_BYTES = 24, WIRE_SOFT_FEATURES_A_PART = 32768 };

/* Reading: the pairs one after the other, each with its features behind it. */
typedef struct wire_soft_reader {
    wire_u8s rest;
    uint32_t pairs, features; /* that are left; of the last pair */
    char names[2][WIRE_NAME_MAX + 1];
} wire_soft_reader;
bool wire_soft_read(wire_u8s extensions, wire_soft_reader *out);    /* false: there is nothing of soft bodies */
bool wire_soft_next_pair(wire_soft_reader *r, wire_soft_pair *out); /* names are the reader's, until the next pair */
bool wire_soft_next_feature(wire_soft_reader *r, wire_soft_feature *out);

#endif
