/* Writes VTK XML PolyData. */
#include "foreign/vtk.h"

#include "base/base.h"

/* ---- base64 ----------------------------------------------------------------------------------------------------- */

/* Bytes that wait until there are three, and letters that wait until there are many. */
typedef struct encoder {
    sp_text *text;
    unsigned char byte[3];
    char letter[4096];
    size_t bytes, letters;
} encoder;

static void flush(encoder *e) {
    sp_text_bytes(e->text, e->letter, e->letters);
    e->letters = 0;
}

static void encode_three(encoder *e) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned three = (unsigned)e->byte[0] << 16 | (unsigned)e->byte[1] << 8 | e->byte[2];
    if (e->letters + 4 > sizeof e->letter)
        flush(e);
    for (int k = 0; k < 4; k++)
        e->letter[e->letters++] = digits[three >> (18 - 6 * k) & 63];
}

static void encode(encoder *e, const void *data, size_t size) {
    const unsigned char *from = data;
    for (size_t k = 0; k < size; k++) {
        e->byte[e->bytes++] = from[k];
        if (e->bytes == 3) {
            encode_three(e);
            e->bytes = 0;
        }
    }
}

/* The last one or two bytes, filled up with '='. */
static void encode_end(encoder *e) {
    const size_t left = e->bytes;
    for (size_t k = left; left > 0 && k < 3; k++)
        e->byte[k] = 0;
    if (left > 0) {
        encode_three(e);
        for (size_t k = left; k < 3; k++)
            e->letter[e->letters - 3 + k] = '=';
    }
    flush(e);
}

static void add_base64(sp_text *t, const void *data, size_t size) {
    encoder e = {.text = t};
    const uint64_t bytes = size;
    encode(&e, &bytes, sizeof bytes);
    encode(&e, data, size);
    encode_end(&e);
}

/* ---- the file --------------------------------------------------------------------------------------------------- */

void sp_vtk_begin(sp_text *t, const char *note) {
    const uint16_t one = 1;
    const bool little = *(const unsigned char *)&one == 1;
    sp_text_add(t,
                "<?xml version=\"1.0\"?>\n"
                "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"%sEndian\" header_type=\"UInt64\">\n"
                "<!-- %s -->\n<PolyData>\n",
                little ? "Little" : "Big", note);
}

void sp_vtk_piece(sp_text *t, sp_vtk_cells cells, int64_t count) {
    const long long n = (long long)count;
    sp_text_add(t,
                "<Piece NumberOfPoints=\"%lld\" NumberOfVerts=\"%lld\" NumberOfLines=\"%lld\" NumberOfStrips=\"0\" "
                "NumberOfPolys=\"0\">\n",
                cells == SP_VTK_LINES ? 2 * n : n, cells == SP_VTK_VERTICES ? n : 0, cells == SP_VTK_LINES ? n : 0);
}

void sp_vtk_array(sp_text *t, const char *name, sp_vtk_type type, int components, int64_t count, const void *data) {
    static const char *const names[] = {"Float64", "Int64", "Int32"};
    static const size_t sizes[] = {8, 8, 4};
    sp_text_add(
        t, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" NumberOfTuples=\"%lld\" format=\"binary\">",
        names[type], name, components, (long long)count);
    add_base64(t, data, (size_t)count * (size_t)components * sizes[type]);
    sp_text_add(t, "</DataArray>\n");
}

/* Cells of one vertex, or of two points. */
static void add_cells(sp_text *t, const char *element, int each, int64_t count) {
    int64_t *index = sp_alloc((size_t)count * (size_t)each, sizeof *index);
    t->failed = t->failed || !index;
    if (t->failed) {
        sp_free(index);
        return;
    }
    sp_text_add(t, "<%s>\n", element);
    for (int64_t k = 0; k < count * each; k++)
        index[k] = k;
    sp_vtk_array(t, "connectivity", SP_VTK_I64, 1, count * each, index);
    for (int64_t k = 0; k < count; k++)
        index[k] = each * (k + 1);
    sp_vtk_array(t, "offsets", SP_VTK_I64, 1, count, index);
    sp_text_add(t, "</%s>\n", element);
    sp_free(index);
}

void sp_vtk_points(sp_text *t, sp_vtk_cells cells, int64_t count, const double *points) {
    const int each = cells == SP_VTK_LINES ? 2 : 1;
    sp_text_add(t, "<Points>\n");
    sp_vtk_array(t, "Points", SP_VTK_F64, 3, count * each, points);
    sp_text_add(t, "</Points>\n");
    add_cells(t, each == 2 ? "Lines" : "Verts", each, count);
    sp_text_add(t, "</Piece>\n");
}

void sp_vtk_field(sp_text *t) { sp_text_add(t, "<FieldData>\n"); }

void sp_vtk_end(sp_text *t) { sp_text_add(t, "</FieldData>\n</PolyData>\n</VTKFile>\n"); }

void sp_vtk_escaped(sp_text *t, const char *name) {
    for (; *name; name++)
        switch (*name) {
        case '&': sp_text_add(t, "&amp;"); break;
        case '<': sp_text_add(t, "&lt;"); break;
        case '"': sp_text_add(t, "&quot;"); break;
        default: sp_text_bytes(t, name, 1);
        }
}
