/* Reads extended XYZ: for each frame the number of atoms, a line of key="value", and the rows. */
#include "base/base.h"
#include "foreign/forms.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static sp_status read_lattice(sp_number_sheet *s, const char *line, size_t length, int64_t number, sp_error *err) {
    char text[1024];
    double v[9], origin[3] = {0, 0, 0};
    if (!sp_line_said(line, length, "Lattice", text, sizeof text))
        return SP_OK;
    if (sp_line_numbers(text, strlen(text), 9, v) != 9)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: Lattice=\"%s\"; must be nine numbers", s->file, (long long)number,
                       text);
    if (v[1] != 0 || v[2] != 0 || v[5] != 0)
        return sp_fail(err, SP_EFORMAT,
                       "%s:%lld: Lattice=\"%s\": the first vector must lie along x, the second in the plane of x and y",
                       s->file, (long long)number, text);
    s->tilt[0] = v[3];
    s->tilt[1] = v[6];
    s->tilt[2] = v[7];
    if (sp_line_said(line, length, "Origin", text, sizeof text))
        sp_line_numbers(text, strlen(text), 3, origin);
    for (int a = 0; a < 3; a++) {
        s->box[a] = v[4 * a] > 0;
        s->low[a] = origin[a];
        s->high[a] = origin[a] + v[4 * a];
    }
    if (sp_line_said(line, length, "pbc", text, sizeof text)) {
        int a = 0;
        for (const char *c = text; *c && a < 3; c++)
            if (strchr("TtFf01", *c))
                s->periodic[a++] = *c == 'T' || *c == 't' || *c == '1';
    }
    return SP_OK;
}

static void add_column(sp_number_sheet *s, const char *name, const char *suffix) {
    if (s->columns < SP_SHEET_COLUMNS)
        snprintf(s->name[s->columns++], SP_SHEET_NAME, "%.50s%s", name, suffix);
}

/* Names the columns by Properties=name:type:count:... Positions become x y z, other vectors name_x ... */
static sp_status read_properties(sp_number_sheet *s, const char *line, size_t length, int64_t number, sp_error *err) {
    static const char *const axis[3] = {"x", "y", "z"};
    char text[4096] = "species:S:1:pos:R:3", *rest = text;
    sp_line_said(line, length, "Properties", text, sizeof text);
    s->columns = 0;
    s->room = 0;
    for (char *name; (name = strsep(&rest, ":"));) {
        const char *type = strsep(&rest, ":"), *count = strsep(&rest, ":");
        char *end = NULL;
        const long n = count ? strtol(count, &end, 10) : 0;
        if (!type || !count || *end || n < 1 || n > 100)
            return sp_fail(err, SP_EFORMAT, "%s:%lld: Properties: '%.60s' must be followed by its type and count",
                           s->file, (long long)number, name);
        for (int k = 0; k < n; k++) {
            char suffix[16] = "";
            if (n == 3)
                snprintf(suffix, sizeof suffix, "_%s", axis[k]);
            else if (n > 1)
                snprintf(suffix, sizeof suffix, "_%d", k + 1);
            add_column(s, strcmp(name, "pos") == 0 && n == 3 ? axis[k] : name,
                       strcmp(name, "pos") == 0 && n == 3 ? "" : suffix);
        }
    }
    return SP_OK;
}

sp_status sp_read_xyz(sp_number_sheet *s, sp_cursor *at, sp_frame_choice choice, sp_error *err) {
    size_t length;
    const char *line;
    sp_cursor chosen = {0};
    double count = 0, rows = 0;
    while ((line = sp_cursor_words(at, &length))) {
        if (sp_line_numbers(line, length, 1, &count) != 1 || !(count >= 1 && count < 1e9))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: '%.*s'; must be the number of atoms of a frame", s->file,
                           (long long)at->number, length < 60 ? (int)length : 60, line);
        if (!choice.given || choice.frame == s->frames) {
            chosen = *at;
            rows = count;
            s->frame = s->frames;
        }
        s->frames++;
        for (double k = 0; k < count + 1; k++)
            if (!sp_cursor_line(at, &length))
                break;
    }
    if (!chosen.next)
        return sp_fail(err, s->frames > 0 ? SP_EINVAL : SP_EFORMAT, "%s: no frame %lld; it has %d, from 0", s->file,
                       (long long)choice.frame, s->frames);
    line = sp_cursor_line(&chosen, &length);
    if (!line)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: the file ends before the line of Lattice= and Properties=", s->file,
                       (long long)at->number);
    s->head = line;
    s->head_length = length;
    sp_status status = read_lattice(s, line, length, chosen.number, err);
    if (status == SP_OK)
        status = read_properties(s, line, length, chosen.number, err);
    return status == SP_OK ? sp_sheet_rows(s, &chosen, (int64_t)rows, "atoms", err) : status;
}
