/* Writes JSON for a page: escaped so that it can stand in a <script> element, with binary arrays in base64. */
#include "view/json.h"

#include "base/base.h"

#include <math.h>
#include <string.h>

static const struct {
    const char *name;
    size_t size;
} types[] = {[VIEW_UINT8] = {"uint8", 1},   [VIEW_INT8] = {"int8", 1},   [VIEW_INT16] = {"int16", 2},
             [VIEW_UINT16] = {"uint16", 2}, [VIEW_INT32] = {"int32", 4}, [VIEW_FLOAT32] = {"float32", 4}};

size_t view_letter(const char *text) {
    const unsigned char *s = (const unsigned char *)text;
    const size_t length = s[0] < 0x80 ? 1 : s[0] < 0xc2 ? 0 : s[0] < 0xe0 ? 2 : s[0] < 0xf0 ? 3 : s[0] < 0xf5 ? 4 : 0;
    for (size_t k = 1; k < length; k++)
        if ((s[k] & 0xc0) != 0x80)
            return 0;
    return length;
}

/* A string. Letters that mean something to HTML, and bytes that are no UTF-8, do not appear as themselves. */
static void add_string(sp_text *t, const char *value) {
    sp_text_bytes(t, "\"", 1);
    for (const char *s = value; *s;) {
        const size_t length = view_letter(s);
        const bool plain = length > 1 || (*s >= 0x20 && *s != 0x7f && !strchr("\"\\<>&'", *s));
        if (length == 0)
            sp_text_add(t, "\\ufffd");
        else if (plain)
            sp_text_bytes(t, s, length);
        else
            sp_text_add(t, "\\u%04x", (unsigned)*s);
        s += length ? length : 1;
    }
    sp_text_bytes(t, "\"", 1);
}

static void begin_value(view_json *j, const char *key) {
    if (j->follows)
        sp_text_bytes(j->text, ",\n", 2);
    j->follows = true;
    if (key) {
        add_string(j->text, key);
        sp_text_bytes(j->text, ":", 1);
    }
}

void view_open(view_json *j, const char *key, char bracket) {
    begin_value(j, key);
    sp_text_bytes(j->text, &bracket, 1);
    j->follows = false;
}

void view_close(view_json *j, char bracket) {
    sp_text_bytes(j->text, &bracket, 1);
    j->follows = true;
}

void view_number(view_json *j, const char *key, double value) {
    begin_value(j, key);
    if (isfinite(value))
        sp_text_number(j->text, value);
    else
        sp_text_add(j->text, "null");
}

void view_integer(view_json *j, const char *key, int64_t value) {
    begin_value(j, key);
    sp_text_add(j->text, "%lld", (long long)value);
}

void view_truth(view_json *j, const char *key, bool value) {
    begin_value(j, key);
    sp_text_add(j->text, value ? "true" : "false");
}

void view_text(view_json *j, const char *key, const char *value) {
    begin_value(j, key);
    if (value)
        add_string(j->text, value);
    else
        sp_text_add(j->text, "null");
}

void view_numbers(view_json *j, const char *key, int64_t n, const double *value) {
    view_open(j, key, '[');
    for (int64_t k = 0; k < n; k++)
        view_number(j, NULL, value[k]);
    view_close(j, ']');
}

static void add_base64(sp_text *t, const unsigned char *data, size_t size) {
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    enum { GROUPS = 4096 };
    char block[4 * GROUPS];
    size_t used = 0;
    for (size_t k = 0; k < size; k += 3) {
        const unsigned b = k + 1 < size ? data[k + 1] : 0, c = k + 2 < size ? data[k + 2] : 0;
        const unsigned group = (unsigned)data[k] << 16 | b << 8 | c;
        block[used++] = letters[group >> 18];
        block[used++] = letters[group >> 12 & 63];
        block[used++] = k + 1 < size ? letters[group >> 6 & 63] : '=';
        block[used++] = k + 2 < size ? letters[group & 63] : '=';
        if (used == sizeof block || k + 3 >= size) {
            sp_text_bytes(t, block, used);
            used = 0;
        }
    }
}

/* Bytes in the order of the file, whatever that of the machine is. */
static void add_values(sp_text *t, size_t count, size_t size, const void *data) {
    static const uint16_t one = 1;
    const unsigned char *bytes = data;
    if (*(const unsigned char *)&one == 1 || size == 1) {
        add_base64(t, bytes, count * size);
        return;
    }
    unsigned char *swapped = sp_alloc(count, size);
    if (!swapped) {
        t->failed = true;
        return;
    }
    for (size_t k = 0; k < count * size; k++)
        swapped[k] = bytes[k / size * size + (size - 1 - k % size)];
    add_base64(t, swapped, count * size);
    sp_free(swapped);
}

void view_array(view_json *j, const char *key, view_type type, const int64_t shape[4], const void *data) {
    size_t count = 1;
    view_open(j, key, '{');
    view_text(j, "type", types[type].name);
    view_open(j, "shape", '[');
    for (int k = 0; k < 4 && (k == 0 || shape[k] > 0); k++) {
        view_integer(j, NULL, shape[k]);
        count *= (size_t)shape[k];
    }
    view_close(j, ']');
    begin_value(j, "data");
    sp_text_bytes(j->text, "\"", 1);
    add_values(j->text, count, types[type].size, data);
    sp_text_bytes(j->text, "\"", 1);
    view_close(j, '}');
}
