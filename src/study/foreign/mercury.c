/* Reads MercuryDPM's .data (grains) and .fstat (contacts). */
#include "base/base.h"
#include "foreign/forms.h"

#include <math.h>
#include <string.h>

/* ---- .data: for each frame a line 'N time xmin ymin [zmin] xmax ymax [zmax]', then N rows ------------------------ */

static sp_status take_frame(sp_number_sheet *s, sp_cursor *at, const double head[8], int dim, sp_error *err) {
    static const char flat[] = "x y vx vy radius angle omega info",
                      solid[] = "x y z vx vy vz radius qx qy qz wx wy wz info";
    const char *names = dim == 2 ? flat : solid;
    for (int a = 0; a < dim; a++) {
        s->box[a] = head[2 + dim + a] > head[2 + a];
        s->low[a] = head[2 + a];
        s->high[a] = head[2 + dim + a];
    }
    sp_sheet_clear(s);
    sp_status status = sp_sheet_header(s, names, strlen(names), at->number, err);
    return status == SP_OK ? sp_sheet_rows(s, at, (int64_t)head[0], "grains", err) : status;
}

sp_status sp_read_mercury_data(sp_number_sheet *s, sp_cursor *at, sp_frame_choice choice, sp_error *err) {
    size_t length;
    const char *line;
    double head[9], chosen[9];
    sp_cursor rows = {0};
    int dim = 0;
    while ((line = sp_cursor_words(at, &length))) {
        const int count = sp_line_numbers(line, length, 9, head);
        if ((count != 8 && count != 6) || !(head[0] >= 1 && head[0] < 1e9) || head[0] != trunc(head[0]))
            return sp_fail(err, SP_EFORMAT,
                           "%s:%lld: '%.*s'; must be the head of a frame: N time xmin ymin zmin xmax ymax zmax",
                           s->file, (long long)at->number, length < 80 ? (int)length : 80, line);
        if (!choice.given || choice.frame == s->frames) {
            memcpy(chosen, head, sizeof chosen);
            rows = *at;
            dim = count == 8 ? 3 : 2;
            s->frame = s->frames;
        }
        s->frames++;
        for (double k = 0; k < head[0]; k++)
            if (!sp_cursor_line(at, &length))
                break;
    }
    if (s->frames == 0)
        return sp_fail(err, SP_EFORMAT, "%s: no frame", s->file);
    if (!rows.next)
        return sp_fail(err, SP_EINVAL, "%s: no frame %lld; must be 0 .. %d", s->file, (long long)choice.frame,
                       s->frames - 1);
    return take_frame(s, &rows, chosen, dim, err);
}

/* ---- .fstat: frames begin with comment lines; rows of 16 numbers ------------------------------------------------- */

sp_status sp_read_mercury_fstat(sp_number_sheet *s, sp_cursor *at, sp_frame_choice choice, sp_error *err) {
    static const char names[] = "time id1 id2 p_x p_y p_z overlap stretch fn ft nx ny nz t_x t_y t_z";
    sp_status status = sp_sheet_header(s, names, strlen(names), 1, err);
    size_t length;
    const char *line;
    bool comment = false;
    while (status == SP_OK && (line = sp_cursor_words(at, &length))) {
        if (line[0] == '#') { /* three of them in front of a frame */
            if (!comment) {
                if (!choice.given || s->frames <= choice.frame)
                    sp_sheet_clear(s);
                s->frame = s->frames++;
            }
            comment = true;
            continue;
        }
        comment = false;
        if (!choice.given || s->frames == 0 || s->frame == choice.frame)
            status = sp_sheet_row(s, line, length, at->number, err);
    }
    return status;
}
