/* mesh_import: assimp's calls for files, answered from memory: what a mesh names is opened by text_read_file, so that a
 * FIFO or a device in its place is an error, and no wait. */
#include "mesh_import.h"

#include "text.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <stdlib.h>
#include <string.h>

typedef struct mesh_reading {
    const char *path; /* the mesh, whose bytes are here already */
    const char *data;
    size_t size;
    load_report fault; /* of the last file that it names and that was not read */
} mesh_reading;

typedef struct mesh_stream {
    struct aiFile head;
    pool memory; /* empty: the mesh's own bytes */
    const char *data;
    size_t size, at;
} mesh_stream;

static mesh_stream *stream_of(struct aiFile *f)
{
    return (mesh_stream *)f;
}

static size_t stream_read(struct aiFile *f, char *to, size_t width, size_t count)
{
    mesh_stream *s = stream_of(f);
    size_t most = width ? (s->size - s->at) / width : 0;
    if (count > most) count = most;
    if (count) memcpy(to, s->data + s->at, width * count);
    s->at += width * count;
    return count;
}

static size_t stream_write(struct aiFile *f, const char *from, size_t width, size_t count)
{
    (void)f;
    (void)from;
    (void)width;
    (void)count;
    return 0;
}

static size_t stream_report(struct aiFile *f)
{
    return stream_of(f)->at;
}

static size_t stream_size(struct aiFile *f)
{
    return stream_of(f)->size;
}

/* An offset from the end counts backwards, as assimp's own streams in memory have it. */
static enum aiReturn stream_seek(struct aiFile *f, size_t offset, enum aiOrigin origin)
{
    mesh_stream *s = stream_of(f);
    size_t base = origin == aiOrigin_CUR ? s->at : 0, left = s->size - base;
    if (offset > left) return aiReturn_FAILURE;
    s->at = origin == aiOrigin_END ? s->size - offset : base + offset;
    return aiReturn_SUCCESS;
}

static void stream_flush(struct aiFile *f)
{
    (void)f;
}

static void close_stream(struct aiFileIO *io, struct aiFile *f)
{
    (void)io;
    pool_free(&stream_of(f)->memory);
    free(f);
}

static struct aiFile *open_stream(struct aiFileIO *io, const char *path, const char *mode)
{
    mesh_reading *m = (mesh_reading *)io->UserData;
    mesh_stream *s = *mode == 'r' ? calloc(1, sizeof *s) : NULL;
    if (!s) return NULL;
    s->head = (struct aiFile){.ReadProc = stream_read,
        .WriteProc = stream_write,
        .TellProc = stream_report,
        .FileSizeProc = stream_size,
        .SeekProc = stream_seek,
        .FlushProc = stream_flush};
    s->data = m->data;
    s->size = m->size;
    if (strcmp(path, m->path) != 0) s->data = text_read_file(&s->memory, path, MESH_FILE_MAX, &s->size, &m->fault);
    if (s->data) return &s->head;
    close_stream(io, &s->head);
    return NULL;
}

const struct aiScene *mesh_import(const char *path, const char *data, size_t size, unsigned steps, load_report *r)
{
    mesh_reading m = {.path = path, .data = data, .size = size};
    struct aiFileIO io = {.OpenProc = open_stream, .CloseProc = close_stream, .UserData = (aiUserData)&m};
    const struct aiScene *scene = aiImportFileEx(path, steps, &io);
    if (!scene)
        load_fail(r, "%s: cannot be read as a mesh: %s%s%s", path, aiGetErrorString(),
            *m.fault.error ? "; it names " : "", m.fault.error);
    return scene;
}
