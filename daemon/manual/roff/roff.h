/* roff: plain text as input of groff's man macros. Escapes what roff would take for its own: backslashes, quotes, and a
 * dot or apostrophe that begins a line; two minus signs, or one before a word, stay minus signs. Build time only. */
#ifndef COLLIDED_MANUAL_ROFF_H
#define COLLIDED_MANUAL_ROFF_H

#include <stdio.h>

void roff_text(FILE *out, const char *text); /* within a line, or beginning one */
void roff_bold(FILE *out, const char *text); /* a word of one's own within a line */
void roff_italic(FILE *out, const char *text);
/* `text` as paragraphs: newlines are spaces, an empty line begins a paragraph, and lines that begin with two spaces
 * stand as they are. */
void roff_paragraphs(FILE *out, const char *text);
void roff_sentence(FILE *out, const char *text); /* first letter large, a full stop at the end, and a newline */

#endif
