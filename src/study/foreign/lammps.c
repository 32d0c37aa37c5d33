/* Reads LAMMPS data files, and dumps of LAMMPS and LIGGGHTS. */
#include "base/base.h"
#include "base/text.h"
#include "foreign/forms.h"

#include <math.h>
#include <string.h>

/* ---- data files ------------------------------------------------------------------------------------------------ */

static bool ends_with(const char *line, size_t length, const char *text) {
    const size_t n = strlen(text);
    for (const char *hash = memchr(line, '#', length); hash; hash = NULL)
        length = (size_t)(hash - line);
    while (length > 0 && (line[length - 1] == ' ' || line[length - 1] == '\t'))
        length--;
    return length >= n && memcmp(line + length - n, text, n) == 0;
}

/* Reads a line of the header. */
static sp_status read_header_line(sp_number_sheet *s, const char *line, size_t length, int64_t number, int64_t *atoms,
                                  sp_error *err) {
    static const char *const edge[3] = {"xlo xhi", "ylo yhi", "zlo zhi"};
    double value[3];
    for (int a = 0; a < 3; a++)
        if (ends_with(line, length, edge[a])) {
            if (sp_line_numbers(line, length, 2, value) != 2 || !(value[1] > value[0]))
                return sp_fail(err, SP_EFORMAT, "%s:%lld: '%.*s'; must be two growing numbers before %s", s->file,
                               (long long)number, (int)length, line, edge[a]);
            s->box[a] = true;
            s->low[a] = value[0];
            s->high[a] = value[1];
        }
    if (ends_with(line, length, "xy xz yz") && sp_line_numbers(line, length, 3, s->tilt) != 3)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: '%.*s'; must be three numbers before xy xz yz", s->file,
                       (long long)number, (int)length, line);
    if (ends_with(line, length, " avec") || ends_with(line, length, " bvec") || ends_with(line, length, " cvec"))
        return sp_fail(err, SP_EFORMAT,
                       "%s:%lld: '%.*s': a box of any direction; must be given by xlo xhi ... xy xz yz", s->file,
                       (long long)number, (int)length, line);
    if (ends_with(line, length, " atoms")) {
        if (sp_line_numbers(line, length, 1, value) != 1 || !(value[0] >= 1 && value[0] < 1e9))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: '%.*s'; must be the number of atoms, 1 or more", s->file,
                           (long long)number, (int)length, line);
        *atoms = (int64_t)value[0];
    }
    return SP_OK;
}

/* Refuses other atom styles than sphere. */
static sp_status check_style(const sp_number_sheet *s, const char *line, size_t length, int64_t number, sp_error *err) {
    char style[SP_SHEET_NAME] = "";
    const char *hash = memchr(line, '#', length), *from = hash ? hash + 1 : line + length;
    if (sp_next_cell(&from, line + length, ' ', style) && strcmp(style, "sphere") != 0)
        return sp_fail(err, SP_EFORMAT,
                       "%s:%lld: atom style %s; must be sphere, whose rows have a diameter and a density", s->file,
                       (long long)number, style);
    return SP_OK;
}

static sp_status read_atoms(sp_number_sheet *s, sp_cursor *at, int64_t atoms, sp_error *err) {
    static const char plain[] = "id type diameter density x y z", images[] = "id type diameter density x y z ix iy iz";
    sp_cursor ahead = *at;
    size_t length;
    const char *line = sp_cursor_words(&ahead, &length), *from = line;
    char word[SP_SHEET_NAME];
    int cells = 0;
    while (line && sp_next_cell(&from, line + length, ' ', word) && word[0] != '#')
        cells++;
    const char *names = cells == 10 ? images : plain;
    sp_status status = sp_sheet_header(s, names, strlen(names), at->number, err);
    return status == SP_OK ? sp_sheet_rows(s, at, atoms, "atoms", err) : status;
}

sp_status sp_read_lammps_data(sp_number_sheet *s, sp_cursor *at, sp_frame_choice frame, sp_error *err) {
    int64_t atoms = 0;
    size_t length;
    sp_status status = SP_OK;
    (void)frame;
    const char *line = sp_cursor_line(at, &length); /* a comment */
    s->head = line;
    s->head_length = length;
    while (status == SP_OK && (line = sp_cursor_words(at, &length))) {
        if (sp_begins(line, length, "Atoms")) {
            if (atoms == 0)
                return sp_fail(err, SP_EFORMAT, "%s:%lld: Atoms before a line '... atoms'", s->file,
                               (long long)at->number);
            s->frames = 1;
            status = check_style(s, line, length, at->number, err);
            return status == SP_OK ? read_atoms(s, at, atoms, err) : status;
        }
        status = read_header_line(s, line, length, at->number, &atoms, err);
    }
    return status != SP_OK ? status
                           : sp_fail(err, SP_EFORMAT, "%s:%lld: the file ends without a section 'Atoms # sphere'",
                                     s->file, (long long)at->number);
}

/* ---- dumps ----------------------------------------------------------------------------------------------------- */

/* One frame of a dump: what its header says, and where its rows are. */
typedef struct dump_frame {
    double step, count;
    bool box[3];
    double low[3], high[3], tilt[3];
    int periodic[3];
    const char *names; /* of the columns */
    size_t names_length;
    int64_t names_number;
    sp_cursor rows;
} dump_frame;

/* Bounds of a tilted box are those of the smallest box with right angles around it. */
static sp_status straighten(const sp_number_sheet *s, const sp_cursor *at, dump_frame *f, sp_error *err) {
    const double *t = f->tilt;
    f->low[0] -= fmin(fmin(0, t[0]), fmin(t[1], t[0] + t[1]));
    f->high[0] -= fmax(fmax(0, t[0]), fmax(t[1], t[0] + t[1]));
    f->low[1] -= fmin(0, t[2]);
    f->high[1] -= fmax(0, t[2]);
    for (int a = 0; a < 2; a++)
        if (!(f->high[a] > f->low[a]))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: the bounds along %c leave nothing of the box at these tilts",
                           s->file, (long long)at->number, "xyz"[a]);
    return SP_OK;
}

static sp_status read_bounds(const sp_number_sheet *s, sp_cursor *at, const char *line, size_t length, dump_frame *f,
                             sp_error *err) {
    const char *from = line + strlen("ITEM: BOX BOUNDS");
    char word[SP_SHEET_NAME];
    bool tilted = false;
    for (int a = 0; sp_next_cell(&from, line + length, ' ', word);) {
        if (strcmp(word, "abc") == 0)
            return sp_fail(err, SP_EFORMAT, "%s:%lld: a box of any direction (abc origin); must be given by xy xz yz",
                           s->file, (long long)at->number);
        tilted = tilted || strcmp(word, "xy") == 0;
        if (a < 3 && strlen(word) == 2 && !strchr("xyz", word[0]))
            f->periodic[a++] = strcmp(word, "pp") == 0;
    }
    for (int a = 0; a < 3; a++) {
        double value[3];
        size_t n;
        const char *row = sp_cursor_line(at, &n);
        const int numbers = tilted ? 3 : 2;
        if (!row || sp_line_numbers(row, n, numbers, value) != numbers || !(value[1] > value[0]))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: '%.*s'; must be two growing numbers%s, the box along %c", s->file,
                           (long long)at->number, row ? (int)n : 0, row ? row : "", tilted ? " and the tilt" : "",
                           "xyz"[a]);
        f->box[a] = true;
        f->low[a] = value[0];
        f->high[a] = value[1];
        f->tilt[a] = tilted ? value[2] : 0;
    }
    return tilted ? straighten(s, at, f, err) : SP_OK;
}

static sp_status read_single(const sp_number_sheet *s, sp_cursor *at, const char *what, double *out, sp_error *err) {
    size_t length;
    const char *line = sp_cursor_line(at, &length);
    if (!line || sp_line_numbers(line, length, 1, out) != 1 || !(*out >= 0))
        return sp_fail(err, SP_EFORMAT, "%s:%lld: '%.*s'; must be the %s", s->file, (long long)at->number,
                       line ? (int)length : 0, line ? line : "", what);
    return SP_OK;
}

/* Reads the header of a frame. Leaves names = NULL at the end of the file. */
static sp_status read_frame(const sp_number_sheet *s, sp_cursor *at, dump_frame *f, sp_error *err) {
    sp_status status = SP_OK;
    size_t length;
    const char *line;
    *f = (dump_frame){.step = -1, .count = -1, .periodic = {-1, -1, -1}};
    bool any = false;
    while (status == SP_OK && (line = sp_cursor_words(at, &length))) {
        any = true;
        if (sp_begins(line, length, "ITEM: TIMESTEP")) {
            status = read_single(s, at, "time step", &f->step, err);
        } else if (sp_begins(line, length, "ITEM: NUMBER OF")) {
            status = read_single(s, at, "number of rows", &f->count, err);
        } else if (sp_begins(line, length, "ITEM: BOX BOUNDS")) {
            status = read_bounds(s, at, line, length, f, err);
        } else if (sp_begins(line, length, "ITEM: ATOMS") || sp_begins(line, length, "ITEM: ENTRIES")) {
            const size_t skip = strlen(line[6] == 'A' ? "ITEM: ATOMS" : "ITEM: ENTRIES");
            f->names = line + skip;
            f->names_length = length - skip;
            f->names_number = at->number;
            f->rows = *at;
            break;
        } else if (!sp_begins(line, length, "ITEM:")) {
            return sp_fail(err, SP_EFORMAT, "%s:%lld: '%.*s' where a line 'ITEM: ...' must be", s->file,
                           (long long)at->number, length < 60 ? (int)length : 60, line);
        } else { /* such as ITEM: UNITS, ITEM: TIME, which have one line */
            sp_cursor_line(at, &length);
        }
    }
    if (status == SP_OK && any && (!f->names || f->count < 0))
        return sp_fail(err, SP_EFORMAT, "%s:%lld: the file ends inside of a frame, before its rows", s->file,
                       (long long)at->number);
    return status;
}

static sp_status fail_frame(const sp_number_sheet *s, int64_t wanted, int64_t last, sp_error *err) {
    return sp_fail(err, SP_EINVAL, "%s: no frame of step %lld; it has %d, the last of step %lld", s->file,
                   (long long)wanted, s->frames, (long long)last);
}

static sp_status take_frame(sp_number_sheet *s, const dump_frame *f, sp_error *err) {
    for (int a = 0; a < 3; a++) {
        s->box[a] = f->box[a];
        s->low[a] = f->low[a];
        s->high[a] = f->high[a];
        s->periodic[a] = f->periodic[a];
        s->tilt[a] = f->tilt[a];
    }
    s->frame = (int64_t)f->step;
    sp_cursor rows = f->rows;
    sp_status status = sp_sheet_header(s, f->names, f->names_length, f->names_number, err);
    if (status == SP_OK && s->columns == 0)
        status = sp_fail(err, SP_EFORMAT, "%s:%lld: no names of columns", s->file, (long long)f->names_number);
    return status == SP_OK ? sp_sheet_rows(s, &rows, (int64_t)f->count, "rows", err) : status;
}

sp_status sp_read_dump(sp_number_sheet *s, sp_cursor *at, sp_frame_choice choice, sp_error *err) {
    dump_frame f, chosen = {0};
    sp_status status = SP_OK;
    int64_t last = -1;
    while (status == SP_OK) {
        status = read_frame(s, at, &f, err);
        if (status != SP_OK || !f.names)
            break;
        s->frames++;
        last = (int64_t)f.step;
        if (!choice.given || choice.frame == last)
            chosen = f;
        size_t length;
        for (double k = 0; k < f.count; k++)
            if (!sp_cursor_line(at, &length))
                break; /* sp_sheet_rows says so, if the frame is wanted */
    }
    if (status != SP_OK)
        return status;
    if (s->frames == 0)
        return sp_fail(err, SP_EFORMAT, "%s: no frame: no line 'ITEM: TIMESTEP'", s->file);
    return chosen.names ? take_frame(s, &chosen, err) : fail_frame(s, choice.frame, last, err);
}
