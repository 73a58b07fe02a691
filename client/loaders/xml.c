/* xml: libxml2 with everything that reaches outside the document switched off. One thread a document. */
#include "xml.h"

#include "text.h"

#include <libxml/parser.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { NUMBERS_MAX = 8 };

/* Called when a DOCTYPE begins, before any entity in it is read. */
static void refuse_doctype(void *context, const xmlChar *name, const xmlChar *external, const xmlChar *system)
{
    (void)name, (void)external, (void)system;
    xmlParserCtxt *parser = context;
    parser->_private = parser;
    xmlStopParser(parser);
}

static void say_why(const xml_file *f, xmlParserCtxt *parser)
{
    const xmlError *e = xmlCtxtGetLastError(parser);
    if (parser->_private)
        load_fail(f->report, "%s: has a DOCTYPE, which a model does not need and which is refused: remove it", f->name);
    else if (e && e->message)
        load_fail(f->report, "%s:%d: is not well-formed XML: %.*s", f->name, e->line, (int)strcspn(e->message, "\n"),
            e->message);
    else
        load_fail(f->report, "%s: is not well-formed XML", f->name);
}

bool xml_open(xml_file *f, const char *data, size_t size, const char *root)
{
    f->doc = NULL;
    if (size > XML_SIZE_MAX)
        return load_fail(f->report, "%s: has %zu bytes, more than the %d allowed", f->name, size, XML_SIZE_MAX);
    xmlParserCtxt *parser = xmlNewParserCtxt();
    if (!parser) return load_fail(f->report, "%s: out of memory", f->name);
    parser->sax->internalSubset = refuse_doctype;
    f->doc = xmlCtxtReadMemory(parser, data, (int)size, f->name, NULL,
        XML_PARSE_NONET | XML_PARSE_NOERROR | XML_PARSE_NOWARNING | XML_PARSE_NOCDATA | XML_PARSE_COMPACT |
            XML_PARSE_BIG_LINES);
    if (!f->doc || parser->_private) say_why(f, parser);
    bool ok = f->doc && !parser->_private;
    xmlFreeParserCtxt(parser);
    const xmlNode *top = ok ? xml_root(f) : NULL;
    if (ok && (!top || strcmp((const char *)top->name, root) != 0))
        ok = load_fail(f->report, "%s: the outermost element is not <%s>", f->name, root);
    if (!ok) xml_close(f);
    return ok;
}

void xml_close(xml_file *f)
{
    if (f->doc) xmlFreeDoc(f->doc);
    f->doc = NULL;
}

const xmlNode *xml_root(const xml_file *f)
{
    return xmlDocGetRootElement(f->doc);
}

static const xmlNode *from(const xmlNode *node, const char *element)
{
    while (node && (node->type != XML_ELEMENT_NODE || strcmp((const char *)node->name, element) != 0))
        node = node->next;
    return node;
}

const xmlNode *xml_first(const xmlNode *parent, const char *element)
{
    return from(parent->children, element);
}
const xmlNode *xml_next(const xmlNode *node, const char *element)
{
    return from(node->next, element);
}

size_t xml_count(const xmlNode *parent, const char *element)
{
    size_t count = 0;
    for (const xmlNode *n = xml_first(parent, element); n; n = xml_next(n, element)) count++;
    return count;
}

int xml_line(const xmlNode *node)
{
    return (int)xmlGetLineNo(node);
}

bool xml_fail(const xml_file *f, const xmlNode *node, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return load_fail(f->report, "%s:%d: %s", f->name, xml_line(node), text);
}

const char *xml_string(const xml_file *f, const xmlNode *node, const char *attribute)
{
    xmlChar *value = xmlGetNoNsProp(node, (const xmlChar *)attribute);
    const char *copy = pool_copy(f->pool, (const char *)value);
    xmlFree(value);
    return copy;
}

const char *xml_need(const xml_file *f, const xmlNode *node, const char *attribute)
{
    const char *value = xml_string(f, node, attribute);
    if (!value) xml_fail(f, node, "<%s> has no attribute '%s'", (const char *)node->name, attribute);
    return value;
}

const char *xml_name(const xml_file *f, const xmlNode *node, const char *attribute)
{
    const char *name = xml_need(f, node, attribute);
    const char *fault = name ? text_name_fault(name) : NULL;
    if (!fault) return name;
    xml_fail(f, node, "the %s '%s' of <%s> %s", attribute, name, (const char *)node->name, fault);
    return NULL;
}

bool xml_numbers(const xml_file *f, const xmlNode *node, const char *attribute, double *out, int count)
{
    const char *text = xml_string(f, node, attribute);
    if (!text) return true;
    double numbers[NUMBERS_MAX];
    if (text_numbers(text, " \t\r\n", numbers, NUMBERS_MAX) != count)
        return xml_fail(f, node, "%s=\"%s\" of <%s>: must be %d finite number%s", attribute, text,
            (const char *)node->name, count, count == 1 ? "" : "s");
    memcpy(out, numbers, (size_t)count * sizeof *out);
    return true;
}

bool xml_measure(const xml_file *f, const xmlNode *node, const char *attribute, double least, double *out)
{
    if (!xml_need(f, node, attribute) || !xml_numbers(f, node, attribute, out, 1)) return false;
    if (*out >= least) return true;
    return xml_fail(
        f, node, "%s=\"%g\" of <%s>: must be at least %g", attribute, *out, (const char *)node->name, least);
}
