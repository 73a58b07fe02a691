/* xml: a small reading layer over libxml2: attributes as checked strings and numbers, errors with file and line.
 *
 * Nothing outside the given bytes is ever read: no network, no external files, and a document with a DOCTYPE (the only
 * place where entities can be defined) is refused before its entities are seen. One thread a document. */
#ifndef COLLIDED_LOADERS_XML_H
#define COLLIDED_LOADERS_XML_H

#include "pool.h"
#include "report.h"

#include <libxml/tree.h>
#include <stdbool.h>
#include <stddef.h>

enum { XML_SIZE_MAX = 16 << 20 /* bytes of a document */ };

typedef struct xml_file {
    const char *name; /* for messages */
    pool *pool;       /* strings are copied there */
    load_report *report;
    xmlDoc *doc;
} xml_file;

/* Parses `data`; its root element must be `root`. On false there is nothing to close. */
bool xml_open(xml_file *f, const char *data, size_t size, const char *root);
void xml_close(xml_file *f);

const xmlNode *xml_root(const xml_file *f);
const xmlNode *xml_first(const xmlNode *parent, const char *element); /* NULL = none */
const xmlNode *xml_next(const xmlNode *node, const char *element);
size_t xml_count(const xmlNode *parent, const char *element);
int xml_line(const xmlNode *node);

/* Always false; "file:line: ..." into the report. */
__attribute__((format(printf, 3, 4))) bool xml_fail(const xml_file *f, const xmlNode *node, const char *format, ...);

/* An attribute as a string; NULL = absent. */
const char *xml_string(const xml_file *f, const xmlNode *node, const char *attribute);
/* The same, where it must be there; NULL = it was not, and the report says so. */
const char *xml_need(const xml_file *f, const xmlNode *node, const char *attribute);
/* A name that can stand in the world (text_name_fault). */
const char *xml_name(const xml_file *f, const xmlNode *node, const char *attribute);

/* `count` numbers divided by spaces. Absent: true, and `out` keeps what it held. */
bool xml_numbers(const xml_file *f, const xmlNode *node, const char *attribute, double *out, int count);
/* One number that must be there, and at least `least`. */
bool xml_measure(const xml_file *f, const xmlNode *node, const char *attribute, double least, double *out);

#endif
