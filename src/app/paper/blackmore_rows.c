/* Rows of the reproduction of the paper on the tapped column: their verdicts, and their table. */
#include "base/base.h"
#include "paper/blackmore.h"

#include <stdarg.h>
#include <stdio.h>

static bool holds(const blackmore_row *row) {
    const double err = isfinite(row->err) ? row->err : 0;
    switch (row->relation) {
    case BLACKMORE_ABOVE: return row->ours - err > row->paper;
    case BLACKMORE_BELOW: return row->ours + err < row->paper;
    case BLACKMORE_EQUAL: break;
    }
    return fabs(row->ours - row->paper) <= row->precision + err;
}

/* Whether our value lies within its error of the limit of the claim. */
static bool is_near(const blackmore_row *row) {
    const double off = fabs(row->ours - row->paper), err = isfinite(row->err) ? row->err : 0;
    return row->relation == BLACKMORE_EQUAL
               ? off <= row->precision + err && off > row->precision && err > row->precision
               : off <= err;
}

void sp_blackmore_set_verdict(blackmore_row *row) {
    if (isnan(row->ours))
        row->verdict = "missing";
    else if (isnan(row->paper))
        row->verdict = row->misprint ? "erratum" : "not given";
    else if (row->claim)
        row->verdict = is_near(row) ? "undecided" : holds(row) ? "holds" : "contradicted";
    else if (holds(row))
        row->verdict = "agrees";
    else
        row->verdict = row->misprint ? "erratum" : "deviates";
}

void sp_blackmore_add(blackmore *p, blackmore_row row, const char *quantity, ...) {
    va_list args;
    va_start(args, quantity);
    vsnprintf(row.quantity, sizeof row.quantity, quantity, args);
    va_end(args);
    if (!row.unit)
        row.unit = "";
    sp_blackmore_set_verdict(&row);
    blackmore_row *rows = sp_grow(p->row, (size_t)p->rows + 1, &p->capacity, sizeof row);
    if (rows) {
        p->row = rows;
        p->row[p->rows++] = row;
    } else
        p->failed = true;
}

void sp_blackmore_note(blackmore_row *row, const char *format, ...) {
    va_list args;
    va_start(args, format);
    vsnprintf(row->note, sizeof row->note, format, args);
    va_end(args);
}

static sp_status add_comments(sp_table *t, sp_error *err) {
    static const char *const line[] = {
        "Blackmore et al., J. Mech. Mater. Struct. 6 (2011), beside our values; units cm, g, s",
        "paper: what is printed, or what follows from a printed equation or claim; nan: no number is given",
        "precision: how sharply it is printed, or a claim in words is meant; relation: what it says of ours",
        "err: bound of our error, or an estimate (see the note); 0: rounding alone, nan: none, as the note says",
        "verdict agrees: the relation holds within precision and err; deviates: it does not",
        "verdict erratum: the paper is wrong by its own premises, and ours is right; paper nan: no number is wrong",
        "verdict not given: the paper has no number; missing: there is none of ours",
        "claims in words: verdict holds, contradicted, or undecided where ours lies within its error of the limit"};
    sp_status status = SP_OK;
    for (size_t k = 0; k < sizeof line / sizeof *line && status == SP_OK; k++)
        status = sp_table_add_comment(t, err, "%s", line[k]);
    return status;
}

sp_status sp_blackmore_rows_table(const blackmore *p, int item, sp_table *out, sp_error *err) {
    static const struct {
        const char *name;
        sp_column_kind kind;
    } column[] = {{"item", SP_COLUMN_TEXT},        {"equation", SP_COLUMN_TEXT}, {"quantity", SP_COLUMN_TEXT},
                  {"unit", SP_COLUMN_TEXT},        {"relation", SP_COLUMN_TEXT}, {"paper", SP_COLUMN_NUMBER},
                  {"precision", SP_COLUMN_NUMBER}, {"ours", SP_COLUMN_NUMBER},   {"err", SP_COLUMN_NUMBER},
                  {"verdict", SP_COLUMN_TEXT},     {"note", SP_COLUMN_TEXT}};
    static const char *const relation[] = {"=", ">", "<"};
    sp_table t = sp_table_none();
    sp_status status = add_comments(&t, err);
    for (size_t k = 0; k < sizeof column / sizeof *column && status == SP_OK; k++)
        status = sp_table_add_column(&t, column[k].name, "", column[k].kind, err);
    for (int64_t k = 0; k < p->rows && status == SP_OK; k++) {
        const blackmore_row *r = &p->row[k];
        if (item < 0 || r->item == item)
            status = sp_table_add_row(&t, err, p->items[r->item].name, r->equation, r->quantity,
                                      *r->unit ? r->unit : "-", relation[r->relation], r->paper, r->precision, r->ours,
                                      r->err, r->verdict, *r->note ? r->note : "-");
    }
    if (status == SP_OK)
        *out = t;
    else
        sp_table_free(&t);
    return status;
}
