/* Reads tables with a header row, also those of photoelastic experiments, and Yade's x_y_z_r. */
#include "base/base.h"
#include "base/text.h"
#include "foreign/forms.h"

#include <string.h>

static char separator_of(const char *line, size_t length) {
    if (memchr(line, ',', length))
        return ',';
    if (memchr(line, ';', length))
        return ';';
    return memchr(line, '\t', length) ? '\t' : ' ';
}

/* Skips comments. Returns the header row. */
static const char *find_header(sp_cursor *at, size_t *length) {
    const char *line = sp_cursor_words(at, length);
    while (line && line[0] == '#')
        line = sp_cursor_words(at, length);
    return line;
}

/* Keeps the rows of one frame: the given one, or the last. */
static sp_status choose_frame(sp_number_sheet *s, sp_frame_choice choice, sp_error *err) {
    const int column = sp_sheet_find(s, "frame");
    s->frames = 1;
    if (column < 0 || s->rows == 0)
        return SP_OK;
    int64_t last, kept = 0, before = -1;
    sp_status status = sp_sheet_integer(s, s->rows - 1, column, &last, err);
    s->frame = choice.given ? choice.frame : last;
    s->frames = 0;
    for (int64_t row = 0; status == SP_OK && row < s->rows; row++) {
        int64_t frame;
        status = sp_sheet_integer(s, row, column, &frame, err);
        s->frames += row == 0 || frame != before;
        before = frame;
        if (frame != s->frame)
            continue;
        memmove(s->value + kept * s->columns, s->value + row * s->columns, (size_t)s->columns * sizeof *s->value);
        s->line[kept] = s->line[row];
        s->number[kept++] = s->number[row];
    }
    if (status == SP_OK && kept == 0)
        status = sp_fail(err, SP_EINVAL, "%s: no row of frame %lld; the last row is of frame %lld", s->file,
                         (long long)s->frame, (long long)last);
    s->rows = kept;
    return status;
}

sp_status sp_read_table(sp_number_sheet *s, sp_cursor *at, sp_frame_choice choice, sp_error *err) {
    size_t length;
    const char *line = find_header(at, &length);
    if (!line)
        return sp_fail(err, SP_EFORMAT, "%s: empty: must have a header row with the names of the columns", s->file);
    s->separator = separator_of(line, length);
    sp_status status = sp_sheet_header(s, line, length, at->number, err);
    double number;
    if (status == SP_OK && sp_word_number(s->name[0], &number))
        status = sp_fail(err, SP_EFORMAT,
                         "%s:%lld: '%.*s': a row of numbers; must be a header row with the names of the columns",
                         s->file, (long long)at->number, length < 60 ? (int)length : 60, line);
    while (status == SP_OK && (line = sp_cursor_words(at, &length)))
        if (line[0] != '#')
            status = sp_sheet_row(s, line, length, at->number, err);
    return status == SP_OK ? choose_frame(s, choice, err) : status;
}

/* ---- Yade ------------------------------------------------------------------------------------------------------ */

/* '#format x_y_z_r', or id_x_y_z_r_matId and the like: the names of the columns between underscores. */
sp_status sp_read_yade(sp_number_sheet *s, sp_cursor *at, sp_frame_choice choice, sp_error *err) {
    char names[1024] = "x y z r";
    size_t length;
    sp_status status = SP_OK;
    const char *line = sp_cursor_words(at, &length);
    (void)choice;
    if (line && sp_begins(line, length, "#format")) {
        const char *format = line + strlen("#format");
        size_t n = length - strlen("#format");
        n = n < sizeof names - 1 ? n : sizeof names - 1;
        memcpy(names, format, n);
        names[n] = '\0';
        for (char *c = names; *c; c++)
            *c = *c == '_' ? ' ' : *c;
    } else if (line) {
        return sp_fail(err, SP_EFORMAT, "%s:%lld: '%.*s'; must be '#format x_y_z_r'", s->file, (long long)at->number,
                       length < 60 ? (int)length : 60, line);
    }
    status = sp_sheet_header(s, names, strlen(names), 1, err);
    s->frames = 1;
    while (status == SP_OK && (line = sp_cursor_words(at, &length)))
        if (line[0] != '#')
            status = sp_sheet_row(s, line, length, at->number, err);
    return status;
}
