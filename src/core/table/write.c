/* Writes a table as TSV, CSV or JSON. */
#include "base/text.h"

#include "base/base.h"

#include <math.h>
#include <sonopack/table.h>
#include <string.h>

/* ---- one text of each format ----------------------------------------------------------------------------------- */

/* TSV: escapes the characters that would end a cell or a row, or start a comment. */
static void tsv_text(sp_text *out, const char *text, bool first) {
    if (first && *text == '#')
        sp_text_bytes(out, "\\", 1);
    for (; *text; text++) {
        switch (*text) {
        case '\t': sp_text_bytes(out, "\\t", 2); break;
        case '\n': sp_text_bytes(out, "\\n", 2); break;
        case '\r': sp_text_bytes(out, "\\r", 2); break;
        case '\\': sp_text_bytes(out, "\\\\", 2); break;
        default: sp_text_bytes(out, text, 1);
        }
    }
}

/* CSV according to RFC 4180. */
static void csv_text(sp_text *out, const char *text, bool first) {
    (void)first;
    size_t length = strlen(text);
    bool blanks = length > 0 && (*text == ' ' || text[length - 1] == ' ');
    if (!blanks && !strpbrk(text, ",\"\r\n")) {
        sp_text_bytes(out, text, length);
        return;
    }
    sp_text_bytes(out, "\"", 1);
    for (; *text; text++)
        sp_text_bytes(out, *text == '"' ? "\"\"" : text, *text == '"' ? 2 : 1);
    sp_text_bytes(out, "\"", 1);
}

/* Length of the UTF-8 character at text [bytes]; 0 if it is invalid, overlong forms and surrogates included. */
static size_t utf8_length(const unsigned char *text) {
    size_t length = text[0] < 0x80 ? 1 : text[0] >= 0xc2 && text[0] < 0xe0 ? 2 : (text[0] & 0xf0) == 0xe0 ? 3 : 0;
    if (text[0] >= 0xf0 && text[0] < 0xf5)
        length = 4;
    for (size_t k = 1; k < length; k++)
        if ((text[k] & 0xc0) != 0x80)
            return 0;
    if ((text[0] == 0xe0 && text[1] < 0xa0) || (text[0] == 0xed && text[1] > 0x9f) ||
        (text[0] == 0xf0 && text[1] < 0x90) || (text[0] == 0xf4 && text[1] > 0x8f))
        return 0;
    return length;
}

static void json_text(sp_text *out, const char *text) {
    sp_text_bytes(out, "\"", 1);
    while (*text) {
        unsigned char c = (unsigned char)*text;
        size_t length = utf8_length((const unsigned char *)text);
        if (c == '"' || c == '\\')
            sp_text_add(out, "\\%c", c);
        else if (c < ' ')
            sp_text_add(out, "\\u%04x", c);
        else if (length == 0)
            sp_text_add(out, "\\ufffd"); /* not UTF-8, as file names may be */
        else
            sp_text_bytes(out, text, length);
        text += length ? length : 1;
    }
    sp_text_bytes(out, "\"", 1);
}

/* ---- tables ---------------------------------------------------------------------------------------------------- */

/* first: nothing but empty cells stands before it in its row. */
typedef void (*text_writer)(sp_text *out, const char *text, bool first);

static void header_and_rows(sp_text *out, const sp_table *t, text_writer text, const char *separator) {
    size_t begin = out->size;
    for (int c = 0; c < t->columns; c++) {
        sp_text_add(out, "%s", c ? separator : "");
        text(out, t->column[c].name, out->size == begin + (size_t)c);
    }
    sp_text_add(out, "\n");
    for (int64_t row = 0; row < t->rows; row++) {
        begin = out->size;
        for (int c = 0; c < t->columns; c++) {
            const sp_entry *cell = &t->cells[row * t->columns + c];
            sp_text_add(out, "%s", c ? separator : "");
            switch (t->column[c].kind) {
            case SP_COLUMN_NUMBER: sp_text_number(out, cell->number); break;
            case SP_COLUMN_INTEGER: sp_text_add(out, "%lld", (long long)cell->integer); break;
            case SP_COLUMN_TEXT: text(out, cell->text ? cell->text : "", out->size == begin + (size_t)c); break;
            }
        }
        sp_text_add(out, "\n");
    }
}

static void tsv_comments(sp_text *out, const sp_table *t) {
    for (int k = 0; k < t->comments; k++) {
        sp_text_add(out, "# ");
        for (const char *c = t->comment[k]; *c; c++)
            sp_text_bytes(out, *c == '\n' ? "\n# " : c, *c == '\n' ? 3 : 1);
        sp_text_add(out, "\n");
    }
    bool any = false;
    for (int c = 0; c < t->columns; c++) {
        if (!t->column[c].unit[0])
            continue;
        sp_text_add(out, "%s%s [%s]", any ? " " : "# units: ", t->column[c].name, t->column[c].unit);
        any = true;
    }
    if (any)
        sp_text_add(out, "\n");
}

static void json_cell(sp_text *out, const sp_entry *cell, sp_column_kind kind) {
    switch (kind) {
    case SP_COLUMN_NUMBER:
        if (isfinite(cell->number))
            sp_text_number(out, cell->number);
        else
            sp_text_add(out, "null");
        break;
    case SP_COLUMN_INTEGER: sp_text_add(out, "%lld", (long long)cell->integer); break;
    case SP_COLUMN_TEXT: json_text(out, cell->text ? cell->text : ""); break;
    }
}

static void json(sp_text *out, const sp_table *t) {
    sp_text_add(out, "{\"comments\":[");
    for (int k = 0; k < t->comments; k++) {
        sp_text_add(out, "%s", k ? "," : "");
        json_text(out, t->comment[k]);
    }
    sp_text_add(out, "],\n\"columns\":[");
    for (int c = 0; c < t->columns; c++) {
        sp_text_add(out, "%s", c ? "," : "");
        json_text(out, t->column[c].name);
    }
    sp_text_add(out, "],\n\"units\":[");
    for (int c = 0; c < t->columns; c++) {
        sp_text_add(out, "%s", c ? "," : "");
        json_text(out, t->column[c].unit);
    }
    sp_text_add(out, "],\n\"rows\":[");
    for (int64_t row = 0; row < t->rows; row++) {
        sp_text_add(out, "%s", row ? ",\n[" : "\n[");
        for (int c = 0; c < t->columns; c++) {
            sp_text_add(out, "%s", c ? "," : "");
            json_cell(out, &t->cells[row * t->columns + c], t->column[c].kind);
        }
        sp_text_add(out, "]");
    }
    sp_text_add(out, "]}\n");
}

char *sp_table_text(const sp_table *t, sp_table_format format) {
    sp_text out = {0};
    sp_locale locale = sp_locale_enter();
    switch (format) {
    case SP_TSV:
        tsv_comments(&out, t);
        header_and_rows(&out, t, tsv_text, "\t");
        break;
    case SP_CSV: header_and_rows(&out, t, csv_text, ","); break;
    case SP_JSON: json(&out, t); break;
    }
    sp_locale_leave(&locale);
    if (out.failed)
        sp_text_free(&out);
    return out.data;
}
