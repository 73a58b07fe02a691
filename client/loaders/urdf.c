/* urdf: from XML to links and joints. Whatever a number or a name can be wrong in is refused here, with its line; what
 * is wrong with the whole (urdf_tree.c) comes after. One thread a pool. */
#include "urdf.h"

#include "rigid.h"
#include "text.h"
#include "xml.h"

#include <math.h>
#include <string.h>

static bool read_origin(const xml_file *f, const xmlNode *parent, collided_pose *out)
{
    *out = rigid_identity();
    const xmlNode *origin = xml_first(parent, "origin");
    double rpy[3] = {0, 0, 0};
    if (!origin) return true;
    if (!xml_numbers(f, origin, "xyz", out->position, 3) || !xml_numbers(f, origin, "rpy", rpy, 3)) return false;
    rigid_from_rpy(rpy, out->orientation);
    return true;
}

/* ---- geometry ---- */

static bool read_box(const xml_file *f, const xmlNode *n, load_shape *out)
{
    double size[3];
    out->shape.type = COLLIDED_BOX;
    if (!xml_need(f, n, "size") || !xml_numbers(f, n, "size", size, 3)) return false;
    for (int i = 0; i < 3; i++) {
        if (!(size[i] >= 0)) return xml_fail(f, n, "size of <box>: %g is negative", size[i]);
        out->shape.half[i] = size[i] / 2;
    }
    return true;
}

static bool read_sphere(const xml_file *f, const xmlNode *n, load_shape *out)
{
    out->shape.type = COLLIDED_SPHERE;
    return xml_measure(f, n, "radius", 0, &out->shape.radius);
}

static bool read_cylinder(const xml_file *f, const xmlNode *n, load_shape *out)
{
    double radius, length;
    out->shape.type = COLLIDED_CYLINDER;
    if (!xml_measure(f, n, "radius", 0, &radius) || !xml_measure(f, n, "length", 0, &length)) return false;
    out->shape.half[0] = out->shape.half[1] = radius;
    out->shape.half[2] = length / 2;
    return true;
}

static bool read_capsule(const xml_file *f, const xmlNode *n, load_shape *out)
{
    double length;
    out->shape.type = COLLIDED_CAPSULE;
    if (!xml_measure(f, n, "radius", 0, &out->shape.radius) || !xml_measure(f, n, "length", 0, &length)) return false;
    out->shape.half[2] = length / 2;
    return true;
}

static bool read_mesh(const xml_file *f, const xmlNode *n, load_shape *out)
{
    out->shape.type = COLLIDED_HULL;
    out->mesh = xml_need(f, n, "filename");
    if (!out->mesh) return false;
    if (!*out->mesh) return xml_fail(f, n, "the filename of <mesh> is empty");
    return xml_numbers(f, n, "scale", out->scale, 3);
}

static const struct {
    const char *element;
    bool (*read)(const xml_file *f, const xmlNode *n, load_shape *out);
} geometries[] = {
    {"box", read_box},
    {"sphere", read_sphere},
    {"cylinder", read_cylinder},
    {"capsule", read_capsule},
    {"mesh", read_mesh},
};

static bool read_collision(const xml_file *f, const xmlNode *collision, load_shape *out)
{
    *out = (load_shape){.scale = {1, 1, 1}};
    if (!read_origin(f, collision, &out->shape.pose)) return false;
    const xmlNode *geometry = xml_first(collision, "geometry");
    if (!geometry) return xml_fail(f, collision, "<collision> has no <geometry>");
    for (size_t i = 0; i < sizeof geometries / sizeof *geometries; i++) {
        const xmlNode *n = xml_first(geometry, geometries[i].element);
        if (n) return geometries[i].read(f, n, out);
    }
    return xml_fail(f, geometry, "<geometry> is none of box, sphere, cylinder, capsule, mesh");
}

/* ---- links ---- */

static bool read_link(const xml_file *f, const xmlNode *n, urdf_link *out)
{
    out->name = xml_name(f, n, "name");
    out->line = xml_line(n);
    out->joint = -1;
    if (!out->name) return false;
    size_t count = xml_count(n, "collision");
    if (count > LOAD_SHAPES_MAX)
        return xml_fail(f, n, "link '%s' has %zu collisions, more than %d", out->name, count, LOAD_SHAPES_MAX);
    out->shapes = pool_alloc(f->pool, count, sizeof *out->shapes);
    for (const xmlNode *c = xml_first(n, "collision"); c; c = xml_next(c, "collision"))
        if (!read_collision(f, c, &out->shapes[out->shape_count++])) return false;
    return true;
}

static bool read_links(const xml_file *f, urdf *u)
{
    size_t count = xml_count(xml_root(f), "link");
    if (count > URDF_LINKS_MAX)
        return load_fail(f->report, "%s: has %zu links, more than %d", f->name, count, URDF_LINKS_MAX);
    u->links = pool_alloc(f->pool, count, sizeof *u->links);
    for (const xmlNode *n = xml_first(xml_root(f), "link"); n; n = xml_next(n, "link")) {
        urdf_link link = {0};
        if (!read_link(f, n, &link)) return false;
        if (urdf_find_link(u, link.name) >= 0) return xml_fail(f, n, "there are two links named '%s'", link.name);
        u->links[u->link_count++] = link;
    }
    return true;
}

/* ---- joints ---- */

static const struct {
    const char *name;
    urdf_joint_type type;
    bool stands_still; /* it has freedoms that we do not move */
} joint_types[] = {
    {"fixed", URDF_FIXED, false},
    {"revolute", URDF_REVOLUTE, false},
    {"continuous", URDF_CONTINUOUS, false},
    {"prismatic", URDF_PRISMATIC, false},
    {"planar", URDF_FIXED, true},
    {"floating", URDF_FIXED, true},
};

static bool read_type(const xml_file *f, const xmlNode *n, urdf_joint *out)
{
    const char *type = xml_need(f, n, "type");
    if (!type) return false;
    for (size_t i = 0; i < sizeof joint_types / sizeof *joint_types; i++) {
        if (strcmp(type, joint_types[i].name) != 0) continue;
        out->type = joint_types[i].type;
        out->stands_still = joint_types[i].stands_still;
        if (joint_types[i].stands_still)
            load_warn(f->report, "%s:%d: joint '%s' is %s: it is taken as fixed", f->name, out->line, out->name, type);
        return true;
    }
    return xml_fail(f, n, "joint '%s' is of the unknown type '%s'", out->name, type);
}

static bool read_end(const xml_file *f, const xmlNode *n, const urdf *u, const char *element, int *link)
{
    const xmlNode *end = xml_first(n, element);
    if (!end) return xml_fail(f, n, "<joint> has no <%s>", element);
    const char *name = xml_need(f, end, "link");
    if (!name) return false;
    *link = urdf_find_link(u, name);
    return *link >= 0 || xml_fail(f, end, "<%s> names the link '%s', which does not exist", element, name);
}

static bool read_axis(const xml_file *f, const xmlNode *n, urdf_joint *out)
{
    const xmlNode *axis = xml_first(n, "axis");
    if (axis && !xml_numbers(f, axis, "xyz", out->axis, 3)) return false;
    if (out->type == URDF_FIXED) return true; /* exporters write "0 0 0" there */
    double most = fmax(fabs(out->axis[0]), fmax(fabs(out->axis[1]), fabs(out->axis[2])));
    if (!(most > 0)) return xml_fail(f, axis, "the axis of joint '%s' is zero", out->name);
    double norm = 0;
    for (int i = 0; i < 3; i++) out->axis[i] /= most, norm += out->axis[i] * out->axis[i];
    for (int i = 0; i < 3; i++) out->axis[i] /= sqrt(norm);
    return true;
}

static bool read_limits(const xml_file *f, const xmlNode *n, urdf_joint *out)
{
    const xmlNode *limit = xml_first(n, "limit");
    out->limited = out->type == URDF_REVOLUTE || out->type == URDF_PRISMATIC;
    if (!out->limited) return true;
    if (!limit) return xml_fail(f, n, "joint '%s' needs a <limit>", out->name);
    if (!xml_numbers(f, limit, "lower", &out->lower, 1) || !xml_numbers(f, limit, "upper", &out->upper, 1))
        return false;
    if (out->lower <= out->upper) return true;
    return xml_fail(
        f, limit, "joint '%s': its lower limit %g is above its upper limit %g", out->name, out->lower, out->upper);
}

static bool read_joint(const xml_file *f, const xmlNode *n, const urdf *u, urdf_joint *out)
{
    *out = (urdf_joint){.axis = {1, 0, 0}, .mimic = -1, .mimic_factor = 1, .line = xml_line(n)};
    out->name = xml_name(f, n, "name");
    return out->name && read_type(f, n, out) && read_origin(f, n, &out->origin) &&
           read_end(f, n, u, "parent", &out->parent) && read_end(f, n, u, "child", &out->child) &&
           read_axis(f, n, out) && read_limits(f, n, out);
}

static bool read_joints(const xml_file *f, urdf *u)
{
    size_t count = xml_count(xml_root(f), "joint");
    if (count > URDF_LINKS_MAX)
        return load_fail(f->report, "%s: has %zu joints, more than %d", f->name, count, URDF_LINKS_MAX);
    u->joints = pool_alloc(f->pool, count, sizeof *u->joints);
    for (const xmlNode *n = xml_first(xml_root(f), "joint"); n; n = xml_next(n, "joint")) {
        urdf_joint joint;
        if (!read_joint(f, n, u, &joint)) return false;
        if (urdf_find_joint(u, joint.name) >= 0) return xml_fail(f, n, "there are two joints named '%s'", joint.name);
        u->joints[u->joint_count++] = joint;
    }
    return true;
}

/* After all joints: a joint may mimic one that comes later in the file. */
static bool read_mimics(const xml_file *f, urdf *u)
{
    int i = 0;
    for (const xmlNode *n = xml_first(xml_root(f), "joint"); n; n = xml_next(n, "joint"), i++) {
        const xmlNode *mimic = xml_first(n, "mimic");
        urdf_joint *j = &u->joints[i];
        if (!mimic) continue;
        const char *name = xml_need(f, mimic, "joint");
        if (!name) return false;
        j->mimic = urdf_find_joint(u, name);
        if (j->mimic < 0) return xml_fail(f, mimic, "'%s' mimics the joint '%s', which does not exist", j->name, name);
        if (!xml_numbers(f, mimic, "multiplier", &j->mimic_factor, 1) ||
            !xml_numbers(f, mimic, "offset", &j->mimic_offset, 1))
            return false;
    }
    return true;
}

/* The first element of xacro's in the document, in its order. (What xacro has written often still declares its name
 * space, so that alone means nothing.) */
static const xmlNode *find_xacro(const xmlNode *root)
{
    for (const xmlNode *n = root; n;) {
        bool own = n->ns && n->ns->prefix && strcmp((const char *)n->ns->prefix, "xacro") == 0;
        if (n->type == XML_ELEMENT_NODE && (own || strncmp((const char *)n->name, "xacro:", 6) == 0)) return n;
        if (n->type == XML_ELEMENT_NODE && n->children) {
            n = n->children;
            continue;
        }
        while (n != root && !n->next) n = n->parent;
        n = n == root ? NULL : n->next;
    }
    return NULL;
}

static bool refuse_xacro(const xml_file *f)
{
    const xmlNode *n = find_xacro(xml_root(f));
    return !n || xml_fail(f, n,
                     "this is a xacro file, from which a URDF is made: run 'xacro FILE > robot.urdf' (ROS) "
                     "and load what it writes");
}

bool urdf_parse(urdf *out, pool *p, const char *data, size_t size, const char *file, load_report *r)
{
    *out = (urdf){.file = pool_copy(p, file)};
    xml_file f = {.name = out->file, .pool = p, .report = r};
    if (!xml_open(&f, data, size, "robot")) return false;
    bool ok = refuse_xacro(&f);
    if (ok) out->name = xml_name(&f, xml_root(&f), "name");
    ok = ok && out->name && read_links(&f, out) && read_joints(&f, out) && read_mimics(&f, out);
    xml_close(&f);
    return ok && urdf_make_tree(out, p, r);
}

int urdf_find_link(const urdf *u, const char *name)
{
    for (int i = 0; i < u->link_count; i++)
        if (strcmp(u->links[i].name, name) == 0) return i;
    return -1;
}

int urdf_find_joint(const urdf *u, const char *name)
{
    for (int i = 0; i < u->joint_count; i++)
        if (strcmp(u->joints[i].name, name) == 0) return i;
    return -1;
}
