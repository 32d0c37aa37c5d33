/* Reads a table from a file. */
#include "base/base.h"
#include "base/text.h"
#include "table/words.h"

#include <sonopack/table.h>
#include <stdio.h>
#include <string.h>

/* Reads the line "units: name [unit] name [unit] ...". */
static void take_units(sp_table *t, const char *text) {
    for (;;) {
        text += strspn(text, " ");
        const char *open = strstr(text, " ["), *close = open ? strchr(open, ']') : NULL;
        if (!close)
            return;
        for (int c = 0; c < t->columns; c++) {
            sp_column *column = &t->column[c];
            if (strlen(column->name) == (size_t)(open - text) && memcmp(column->name, text, strlen(column->name)) == 0)
                snprintf(column->unit, sizeof column->unit, "%.*s", (int)(close - open - 2), open + 2);
        }
        text = close + 1;
    }
}

static bool numeric_column(const sp_word_table *s, int column) {
    double value;
    for (int64_t k = 0; k < s->rows; k++)
        if (!sp_word_number(sp_word_table_cell(s, k, column), &value))
            return false;
    return true;
}

static sp_status add_columns(const sp_word_table *s, sp_table *t, sp_error *err) {
    for (int c = 0; c < s->columns; c++) {
        char name[sizeof t->column[0].name];
        snprintf(name, sizeof name, "c%d", c + 1);
        if (s->name[c] && strlen(s->name[c]) >= sizeof name)
            return sp_fail(err, SP_EFORMAT, "%s: the name of column %d has %zu characters; at most %zu", s->file, c + 1,
                           strlen(s->name[c]), sizeof name - 1);
        sp_status status = sp_table_add_column(t, s->name[c] ? s->name[c] : name, "",
                                               numeric_column(s, c) ? SP_COLUMN_NUMBER : SP_COLUMN_TEXT, err);
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

static sp_status add_cells(const sp_word_table *s, sp_table *t, sp_error *err) {
    size_t cells = (size_t)s->rows * (size_t)s->columns;
    t->cells = sp_alloc(cells, sizeof *t->cells);
    if (!t->cells)
        return sp_fail_memory(err, cells * sizeof *t->cells);
    t->capacity = t->rows = s->rows;
    for (size_t k = 0; k < cells; k++) {
        const char *word = s->cell[k];
        if (t->column[k % (size_t)s->columns].kind == SP_COLUMN_NUMBER)
            sp_word_number(word, &t->cells[k].number);
        else if (!(t->cells[k].text = sp_strdup(word)))
            return sp_fail_memory(err, strlen(word));
    }
    return SP_OK;
}

static sp_status add_comments(const sp_word_table *s, sp_table *t, sp_error *err) {
    for (int c = 0; c < s->comments; c++) {
        sp_status status = SP_OK;
        if (strncmp(s->comment[c], "units:", 6) == 0)
            take_units(t, s->comment[c] + 6);
        else
            status = sp_table_add_comment(t, err, "%s", s->comment[c]);
        if (status != SP_OK)
            return status;
    }
    return SP_OK;
}

sp_status sp_table_read(const char *path, sp_table *out, sp_error *err) {
    sp_word_table s = {0};
    sp_table t = sp_table_none();
    sp_locale locale = sp_locale_enter();
    sp_status status = sp_word_table_read(path, &s, err);
    if (status == SP_OK)
        status = add_columns(&s, &t, err);
    if (status == SP_OK)
        status = add_cells(&s, &t, err);
    if (status == SP_OK)
        status = add_comments(&s, &t, err);
    sp_locale_leave(&locale);
    sp_word_table_free(&s);
    if (status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    return status;
}
