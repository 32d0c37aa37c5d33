/* Turns units of tables into markup, and finds those that tables share. */
#include "figure/unit.h"

#include "base/base.h"
#include "figure/markup.h"

#include <stdio.h>
#include <string.h>

#define RHO "|\xcf\x81|"

typedef struct spelling {
    const char *unit, *markup, *square, *inverse; /* NULL: by the general rule */
} spelling;

/* Units with roots read better as powers of the ratio. */
static const spelling spellings[] = {
    {UNIT_LENGTH, "|d|", "|d|^{2}", "1/|d|"},
    {UNIT_WAVE, "1/|d|", NULL, "|d|"},
    {UNIT_PRESSURE, "|E|*", NULL, NULL},
    {UNIT_FORCE, "|E|* |d|^{2}", NULL, NULL},
    {"E* d", "|E|* |d|", NULL, NULL},
    {UNIT_SPEED, "(|E|*/" RHO ")^{1/2}", NULL, NULL},
    {UNIT_TIME, "|d| (" RHO "/|E|*)^{1/2}", NULL, "(|E|*/" RHO ")^{1/2}/|d|"},
    {"d sqrt(E* / rho)", "|d| (|E|*/" RHO ")^{1/2}", NULL, NULL},
    {"modes d/sqrt(E* / rho)", "modes |d| (" RHO "/|E|*)^{1/2}", NULL, NULL},
    {UNIT_FREQUENCY, "(|E|*/" RHO ")^{1/2}/|d|", "|E|*/(" RHO " |d|^{2})", "|d| (" RHO "/|E|*)^{1/2}"},
    {"rad/s", "rad/s", NULL, "s"}, /* a density of states is in s, or us: a radian has no unit */
    {"E* d^3/sqrt(E* / rho)", "|E|* |d|^{3} (" RHO "/|E|*)^{1/2}", NULL, NULL},
    {"l/c", "|\xe2\x84\x93|/|c|", NULL, NULL},
    {"K l", "|K| |\xe2\x84\x93|", NULL, NULL}};

static const spelling *find(const char *unit) {
    for (size_t k = 0; k < sizeof spellings / sizeof *spellings; k++)
        if (sp_unit_same(unit, spellings[k].unit))
            return &spellings[k];
    return NULL;
}

bool sp_unit_same(const char *a, const char *b) {
    for (;; a++, b++) {
        a += strspn(a, " ");
        b += strspn(b, " ");
        if (*a != *b || !*a)
            return *a == *b;
    }
}

static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

/* Whether the letter u at `at' stands for micro: it begins a word of a unit, as in us or um. */
static bool is_micro(const char *unit, const char *at) {
    return *at == 'u' && at[1] != '\0' && strchr("smNgPJ", at[1]) && (at == unit || !is_letter(at[-1])) &&
           (at[1] == 'P' || !is_letter(at[2]));
}

/* Copies a unit of another program: numbers after ^ are raised, and u for micro becomes its letter. */
static void foreign(const char *unit, char out[UNIT_MARKUP]) {
    size_t n = 0;
    out[0] = '\0';
    for (const char *s = unit; *s && n + 48 < UNIT_MARKUP;) {
        const size_t power = *s == '^' ? strspn(s + 1, "-0123456789") : 0;
        const bool minus = power > 0 && s[1] == '-', micro = is_micro(unit, s);
        size_t length = power > 0 ? power + 1 : 1;
        char plain[64], one[UNIT_MARKUP];
        if (power > 0 && power < 20) {
            n += (size_t)snprintf(out + n, UNIT_MARKUP - n, "^{%s%.*s}", minus ? MINUS : "", (int)power - minus,
                                  s + 1 + minus);
        } else {
            while (s[length] && s[length] != '^' && !is_micro(unit, s + length) && length < 40)
                length++;
            snprintf(plain, sizeof plain, "%.*s", (int)length - micro, s + micro);
            sp_figure_text_escape(one, sizeof one, plain, 40);
            n += (size_t)snprintf(out + n, UNIT_MARKUP - n, "%s%s", micro ? "\xc2\xb5" : "", one);
        }
        s += length;
    }
}

void sp_unit_markup(const char *unit, char out[UNIT_MARKUP]) {
    const spelling *own = find(unit);
    if (own)
        snprintf(out, UNIT_MARKUP, "%s", own->markup);
    else
        foreign(unit, out);
}

/* Writes a form of a unit that has no spelling of its own, such as "(rad/s)" before an exponent. */
static void general(const char *unit, const char *format, char out[UNIT_MARKUP]) {
    char markup[UNIT_MARKUP], whole[UNIT_MARKUP];
    sp_unit_markup(unit, markup);
    const bool simple = !strpbrk(unit, " /*^(");
    snprintf(whole, sizeof whole, simple ? "%.190s" : "(%.190s)", markup);
    snprintf(out, UNIT_MARKUP, format, *unit ? whole : "");
}

void sp_unit_square(const char *unit, char out[UNIT_MARKUP]) {
    const spelling *own = find(unit);
    if (own && own->square)
        snprintf(out, UNIT_MARKUP, "%s", own->square);
    else
        general(unit, *unit ? "%.190s^{2}" : "%s", out);
}

void sp_unit_inverse(const char *unit, char out[UNIT_MARKUP]) {
    const spelling *own = find(unit);
    if (own && own->inverse)
        snprintf(out, UNIT_MARKUP, "%s", own->inverse);
    else
        general(unit, *unit ? "1/%.190s" : "%s", out);
}

const char *sp_unit_label(const char *name, const char *unit, char *out, size_t size) {
    char markup[UNIT_MARKUP];
    sp_unit_markup(unit, markup);
    snprintf(out, size, *markup ? "%s  [%s]" : "%s", name, markup);
    return out;
}

sp_status sp_unit_common(int tables, const sp_plot_table *table, const char *column, const char *own, const char **out,
                         sp_error *err) {
    int first = -1;
    *out = own;
    for (int j = 0; j < tables; j++) {
        const int at = sp_table_find_column(table[j].table, column);
        const char *unit = at < 0 ? "" : table[j].table->column[at].unit;
        if (!*unit)
            continue;
        if (first >= 0 && !sp_unit_same(unit, *out))
            return sp_fail(err, SP_EINVAL, "table %d has %s in %s, table %d in %s: must be the same unit", first + 1,
                           column, *out, j + 1, unit);
        if (first < 0)
            *out = unit;
        first = first < 0 ? j : first;
    }
    return SP_OK;
}
