/* cad: closed meshes of the kinds that machines are drawn with, of random sizes: extruded profiles, plates and bars
 * with holes, tubes, stepped shafts, gears, brackets of several bodies. */
#ifndef MESH_CAD_H
#define MESH_CAD_H

#include "solids.h"

typedef enum cad_kind {
    CAD_BOX,
    CAD_CYLINDER,
    CAD_L,
    CAD_U,
    CAD_T,
    CAD_I,
    CAD_FRAME, /* a box with a square hole through it */
    CAD_TUBE,
    CAD_PLATE_WITH_HOLE,
    CAD_SHAFT, /* stepped */
    CAD_GEAR,
    CAD_BRACKET, /* two plates and a rib, that overlap: three closed pieces */
    CAD_CONE,
    CAD_KIND_COUNT
} cad_kind;

const char *cad_name(cad_kind kind);
soup cad_solid(cad_kind kind, dice *d);

/* An outline in x, y, counter-clockwise, drawn out from z = -half to half; with a hole of as many corners (counter-
 * clockwise, too, each beside the outer one of its number), or NULL. At most CAD_OUTLINE_MAX corners. */
enum { CAD_OUTLINE_MAX = 128 };
soup cad_extruded(const double (*outline)[2], const double (*hole)[2], int count, double half);

/* Turned about z: radii and heights from the lower end to the upper; closed by its ends. */
soup cad_turned(const double (*profile)[2], int count, int around);

#endif
