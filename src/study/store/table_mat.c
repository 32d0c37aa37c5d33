/* Writes tables as MATLAB 5 MAT-files: a header, and then one matrix after another. Each element has a type, a size and
 * data, filled up to 8 bytes. */
#include "base/base.h"
#include "base/text.h"

#include <ctype.h>
#include <sonopack/study/export_file.h>
#include <sonopack/version.h>
#include <stdio.h>
#include <string.h>

enum { INT8 = 1, UINT16 = 4, INT32 = 5, UINT32 = 6, DOUBLE = 9, MATRIX = 14 }; /* types of elements */
enum { CELL_CLASS = 1, STRUCT_CLASS = 2, CHAR_CLASS = 4, DOUBLE_CLASS = 6 };   /* of matrices */
enum { NAME_MAX_LENGTH = 63, FIELD_LENGTH = 64 };
static const size_t element_limit = 0x7fffffff;

/* Failures other than of memory, which sets text->failed, are kept until the end. */
typedef struct sp_mat {
    sp_text *text;
    bool large; /* a variable exceeds the 2 GB of the format */
} sp_mat;

/* ---- elements --------------------------------------------------------------------------------------------------- */

static void add_element(sp_text *t, uint32_t type, const void *data, size_t size) {
    static const char zeros[8];
    const uint32_t tag[2] = {type, (uint32_t)size};
    sp_text_bytes(t, (const char *)tag, sizeof tag);
    if (size > 0) /* without memory there are no data */
        sp_text_bytes(t, data, size);
    sp_text_bytes(t, zeros, (8 - size % 8) % 8);
}

/* A valid name: letters, digits and underscores, a letter first. */
static void clean_name(const char *name, char out[FIELD_LENGTH]) {
    int n = 0;
    if (!isalpha((unsigned char)name[0]) && name[0] != '\0')
        out[n++] = 'x';
    for (; *name && n < NAME_MAX_LENGTH; name++)
        out[n++] = isalnum((unsigned char)*name) ? *name : '_';
    out[n] = '\0';
}

/* What every matrix begins with. */
static void add_head(sp_text *t, uint32_t class, int64_t rows, int64_t columns, const char *name) {
    const uint32_t flags[2] = {class, 0};
    const int32_t size[2] = {(int32_t)rows, (int32_t)columns};
    char valid[FIELD_LENGTH];
    clean_name(name, valid);
    add_element(t, UINT32, flags, sizeof flags);
    add_element(t, INT32, size, sizeof size);
    add_element(t, INT8, valid, strlen(valid));
}

/* A matrix that has been made in `body` becomes an element of t. */
static void add_matrix(sp_mat *m, sp_text *t, sp_text *body) {
    m->large = m->large || body->size > element_limit;
    t->failed = t->failed || body->failed;
    if (!m->large)
        add_element(t, MATRIX, body->data, body->size);
    sp_text_free(body);
}

static void add_doubles(sp_mat *m, sp_text *t, const char *name, int64_t rows, int64_t columns, const double *value) {
    sp_text body = {0};
    const size_t size = (size_t)rows * (size_t)columns * sizeof *value;
    m->large = m->large || size > element_limit;
    add_head(&body, DOUBLE_CLASS, rows, columns, name);
    if (!m->large)
        add_element(&body, DOUBLE, value, size);
    add_matrix(m, t, &body);
}

/* The next character of UTF-8 that 16 bits can hold, or '?'. */
static uint16_t next_character(const char **text) {
    const unsigned char *s = (const unsigned char *)*text;
    const int more = s[0] < 0x80 ? 0 : s[0] >= 0xf0 ? 3 : s[0] >= 0xe0 ? 2 : s[0] >= 0xc0 ? 1 : 0;
    unsigned code = more == 0 ? s[0] : s[0] & (0x3fu >> more);
    int k = 1;
    for (; k <= more && (s[k] & 0xc0) == 0x80; k++)
        code = code << 6 | (s[k] & 0x3fu);
    *text += k;
    return (more == 0 && s[0] >= 0x80) || k <= more || code > 0xffff ? '?' : (uint16_t)code;
}

static void add_characters(sp_mat *m, sp_text *t, const char *name, const char *text) {
    sp_text body = {0};
    int64_t length = 0;
    uint16_t *wide = sp_alloc(strlen(text), sizeof *wide);
    t->failed = t->failed || !wide;
    for (const char *s = text; wide && *s; length++)
        wide[length] = next_character(&s);
    add_head(&body, CHAR_CLASS, length > 0 ? 1 : 0, length, name);
    add_element(&body, UINT16, wide, (size_t)length * sizeof *wide);
    add_matrix(m, t, &body);
    sp_free(wide);
}

/* ---- columns ---------------------------------------------------------------------------------------------------- */

static void add_numbers(sp_mat *m, sp_text *t, const char *name, const sp_table *from, int column) {
    double *value = sp_alloc((size_t)from->rows, sizeof *value);
    t->failed = t->failed || !value;
    for (int64_t r = 0; value && r < from->rows; r++)
        value[r] = sp_table_number(from, r, column);
    if (value)
        add_doubles(m, t, name, from->rows, 1, value);
    sp_free(value);
}

static void add_texts(sp_mat *m, sp_text *t, const char *name, const sp_table *from, int column) {
    sp_text body = {0};
    add_head(&body, CELL_CLASS, from->rows, 1, name);
    for (int64_t r = 0; r < from->rows; r++)
        add_characters(m, &body, "", from->cells[r * from->columns + column].text);
    add_matrix(m, t, &body);
}

static void add_column(sp_mat *m, sp_text *t, const char *name, const sp_table *from, int column) {
    if (from->column[column].kind == SP_COLUMN_TEXT)
        add_texts(m, t, name, from, column);
    else
        add_numbers(m, t, name, from, column);
}

/* The beginning of a struct with a field for each column. */
static void add_fields(sp_text *t, const char *name, const sp_table *from) {
    const int32_t length = FIELD_LENGTH;
    const uint32_t short_tag = 4u << 16 | INT32; /* a size of up to 4 bytes is stored beside the type */
    sp_text names = {0};
    add_head(t, STRUCT_CLASS, 1, 1, name);
    sp_text_bytes(t, (const char *)&short_tag, 4);
    sp_text_bytes(t, (const char *)&length, 4);
    for (int c = 0; c < from->columns; c++) {
        char field[FIELD_LENGTH] = {0};
        clean_name(from->column[c].name, field);
        sp_text_bytes(&names, field, sizeof field);
    }
    t->failed = t->failed || names.failed;
    add_element(t, INT8, names.data, names.size);
    sp_text_free(&names);
}

/* ---- the file --------------------------------------------------------------------------------------------------- */

static void begin(sp_text *text) {
    char head[124];
    const uint16_t version[2] = {0x0100, 'M' << 8 | 'I'};
    memset(head, ' ', sizeof head);
    const int length = snprintf(head, sizeof head, "MATLAB 5.0 MAT-file, written by sonopack " SONOPACK_VERSION);
    head[length] = ' ';
    memset(head + 116, 0, 8); /* no data of subsystems */
    sp_text_bytes(text, head, sizeof head);
    sp_text_bytes(text, (const char *)version, sizeof version);
}

/* The units of the columns as a struct of texts. */
static void add_units(sp_mat *m, const sp_table *t) {
    sp_text body = {0};
    add_fields(&body, "units", t);
    for (int c = 0; c < t->columns; c++)
        add_characters(m, &body, "", t->column[c].unit);
    add_matrix(m, m->text, &body);
}

static void add_comments(sp_mat *m, const sp_table *t) {
    sp_text body = {0};
    add_head(&body, CELL_CLASS, t->comments, t->comments > 0 ? 1 : 0, "comments");
    for (int k = 0; k < t->comments; k++)
        add_characters(m, &body, "", t->comment[k]);
    add_matrix(m, m->text, &body);
}

sp_status sp_table_save_mat(const sp_table *t, const char *path, sp_error *err) {
    sp_text text = {0};
    sp_mat m = {.text = &text};
    begin(&text);
    for (int c = 0; c < t->columns; c++)
        add_column(&m, &text, t->column[c].name, t, c);
    add_units(&m, t);
    add_comments(&m, t);
    sp_status status =
        m.large ? sp_fail(err, SP_EREFUSED, "a variable has more than 2 GB, the limit of a MAT-file") : SP_OK;
    if (status == SP_OK && text.failed)
        status = sp_fail_memory(err, text.capacity);
    if (status == SP_OK)
        status = sp_text_save(path, text.data, text.size, err);
    sp_text_free(&text);
    return status;
}
