/* Converts tables to SI. */
#include "units/unit.h"

#include "base/base.h"

#include <stdio.h>
#include <string.h>

/* ---- comments --------------------------------------------------------------------------------------------------- */

static void free_lines(char **line, int n) {
    for (int k = 0; line && k < n; k++)
        sp_free(line[k]);
    sp_free(line);
}

/* The comments of the table in SI. NULL without memory. */
static char **converted_comments(const sp_table *t, const sp_material *m) {
    char **line = sp_alloc((size_t)t->comments + 1, sizeof *line);
    bool known;
    for (int k = 0; line && k < t->comments; k++) {
        line[k] = sp_comment_to_si(t->comment[k], t, m, &known);
        if (!line[k]) {
            free_lines(line, t->comments);
            line = NULL;
        }
    }
    return line;
}

/* Removes all comments and metadata. */
static void clear_comments(sp_table *t) {
    free_lines(t->comment, t->comments);
    for (int k = 0; k < t->values; k++) {
        sp_free(t->value[k].key);
        sp_free(t->value[k].text);
    }
    sp_free(t->value);
    t->comment = NULL;
    t->value = NULL;
    t->comments = t->values = 0;
}

static sp_status replace_comments(sp_table *t, const sp_material *m, sp_error *err) {
    const int comments = t->comments;
    char **line = converted_comments(t, m), material[SP_MATERIAL_TEXT];
    sp_status status = line ? SP_OK : sp_fail_memory(err, (size_t)comments * 80);
    if (status == SP_OK)
        clear_comments(t);
    for (int k = 0; k < comments && status == SP_OK; k++)
        status = sp_table_add_comment(t, err, "%s", line[k]);
    free_lines(line, comments);
    if (status == SP_OK && !sp_table_get_text(t, "material"))
        status = sp_table_set_text(t, "material", sp_material_text(m, material), err);
    return status;
}

/* ---- columns ---------------------------------------------------------------------------------------------------- */

/* Whether all of our units in the columns can be converted. */
static sp_status check_columns(const sp_table *t, const sp_material *m, sp_error *err) {
    char si[SP_UNIT_TEXT];
    double factor;
    sp_status status = sp_material_check(m, err);
    for (int c = 0; c < t->columns && status == SP_OK; c++) {
        const sp_column *column = &t->column[c];
        if (!sp_unit_is_ours(column->unit))
            continue;
        status = sp_unit_to_si(column->unit, m, &factor, si, err);
        if (status == SP_OK && column->kind != SP_COLUMN_NUMBER)
            status = sp_fail(err, SP_EINVAL, "column %s: has the unit %s but no numbers with a fraction", column->name,
                             column->unit);
    }
    return status;
}

static void convert_column(sp_table *t, int c, const sp_material *m) {
    char si[SP_UNIT_TEXT];
    double factor;
    if (!sp_unit_is_ours(t->column[c].unit) || sp_unit_to_si(t->column[c].unit, m, &factor, si, NULL) != SP_OK)
        return;
    for (int64_t row = 0; row < t->rows; row++)
        t->cells[row * t->columns + c].number *= factor;
    snprintf(t->column[c].unit, sizeof t->column[c].unit, "%s", si);
}

sp_status sp_table_to_si(sp_table *t, const sp_material *m, sp_error *err) {
    sp_status status = check_columns(t, m, err);
    if (status == SP_OK)
        status = replace_comments(t, m, err); /* first: forms look up the units of columns */
    for (int c = 0; c < t->columns && status == SP_OK; c++)
        convert_column(t, c, m);
    return status;
}
