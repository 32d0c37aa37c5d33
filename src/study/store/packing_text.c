/* Reads and writes a packing as one text file: a comment, a header line of keys and values, a line for each grain, a
 * line for each contact. The columns in 2D are 'x y R rattler' and 'i j nx ny overlap Fn Ft'. 1D has no y, ny and Ft;
 * 3D has z and nz as well, and Ft as a vector. */
#include "store/packing_text.h"

#include "base/base.h"
#include "base/text.h"
#include "packing/geometry.h"

#include <ctype.h>
#include <math.h>
#include <sonopack/study/store.h>
#include <string.h>

static const char *const axis[3] = {"x", "y", "z"};

bool sp_packing_text_looks(const char *text) {
    while (*text) {
        text += strspn(text, " \t\r\n\xef\xbb\xbf");
        if (*text != '#')
            break;
        text += strcspn(text, "\n");
    }
    return text[0] == 'N' && (text[1] == ' ' || text[1] == '\t') &&
           isdigit((unsigned char)text[1 + strspn(text + 1, " \t")]);
}

/* Behind blanks, and comments of scenes. */
static const char *skip_comments(const char *text) {
    for (;;) {
        text += strspn(text, " \t\r\n\xef\xbb\xbf");
        const bool line = *text == '#' || strncmp(text, "//", 2) == 0;
        const char *end = line ? strchr(text, '\n') : strncmp(text, "/*", 2) == 0 ? strstr(text + 2, "*/") : NULL;
        if (!end)
            return text;
        text = end + (line ? 1 : 2);
    }
}

const sp_packing_source *sp_packing_text_source(const char *text) {
    static const char *const groups[] = {"packing", "material", "network", "signal", "study", "@include"};
    static const sp_packing_source scene = {"a scene", "pack", "-o "};
    static const struct {
        const char *begins;
        sp_packing_source source;
    } others[] = {{"ITEM:", {"a dump of LAMMPS", "convert", ""}}, {"<", {"an XML file", "convert", ""}}};
    text = skip_comments(text);
    for (size_t k = 0; k < sizeof groups / sizeof *groups; k++) {
        const size_t length = strlen(groups[k]);
        if (strncmp(text, groups[k], length) != 0)
            continue;
        const char next = text[length + strspn(text + length, " \t\r\n")];
        if (next != '\0' && strchr("=:\"", next))
            return &scene;
    }
    for (size_t k = 0; k < sizeof others / sizeof *others; k++)
        if (strncmp(text, others[k].begins, strlen(others[k].begins)) == 0)
            return &others[k].source;
    return NULL;
}

/* ---- the tangential force in 2D -------------------------------------------------------------------------------- */

/* The rounded product. + 0.0 makes a negative zero positive. */
static void plain_product(const double n[3], double scalar, double ft[3]) {
    ft[0] = scalar * -n[1] + 0.0;
    ft[1] = scalar * n[0] + 0.0;
    ft[2] = 0.0;
}

static double steps_from(double x, int steps) {
    for (; steps > 0; steps--)
        x = nextafter(x, INFINITY);
    for (; steps < 0; steps++)
        x = nextafter(x, -INFINITY);
    return x;
}

/* The scalar of a vector ft = Ft (-ny, nx). With rounding this map is neither one to one nor onto: scalar -> vector ->
 * scalar is exact; vector -> scalar -> vector is exact for vectors that are the rounded product. */
static double tangent_scalar(const double n[3], const double ft[3]) {
    long double along = (long double)ft[0] * -(long double)n[1] + (long double)ft[1] * (long double)n[0];
    long double length2 = (long double)n[0] * (long double)n[0] + (long double)n[1] * (long double)n[1];
    double middle = (double)(along / length2) + 0.0; /* no negative zero */
    static const int steps[] = {0, 1, -1, 2, -2};
    for (size_t k = 0; k < sizeof steps / sizeof *steps; k++) {
        double scalar = steps_from(middle, steps[k]), product[3];
        plain_product(n, scalar, product);
        if (product[0] == ft[0] && product[1] == ft[1])
            return scalar;
    }
    return middle;
}

static void tangent_vector(const double n[3], double scalar, double ft[3]) {
    plain_product(n, scalar, ft);
    if (tangent_scalar(n, ft) == scalar)
        return;
    /* Two neighbouring scalars have the same product. Move the vector by an ulp, to one that is no product and is
     * converted to this scalar. */
    double product[3] = {ft[0], ft[1], 0};
    for (int a = -1; a <= 1; a++)
        for (int b = -1; b <= 1; b++) {
            double moved[3] = {steps_from(product[0], a), steps_from(product[1], b), 0};
            if (tangent_scalar(n, moved) == scalar) {
                ft[0] = moved[0];
                ft[1] = moved[1];
                return;
            }
        }
}

/* ---- header ---------------------------------------------------------------------------------------------------- */

typedef struct header {
    int64_t grains, pairs, bottom, top, walls; /* walls: of all of them, where the header has a cell */
    double edge[3], tilt[3], pressure, friction, poisson, gravity, frame, strain[SP_SERIES_STRAINS];
    uint64_t seed;
    sp_wall wall;
    sp_cell cell;
    int dim;
} header;

typedef enum header_kind { COUNT, NUMBER, LENGTH, SEED, WALL, CELL } header_kind;

/* The keys, those that every header has first. */
static const struct header_key {
    const char *name;
    header_kind kind;
    size_t offset;
} header_key[] = {{"N", COUNT, offsetof(header, grains)},        {"contacts", COUNT, offsetof(header, pairs)},
                  {"Lx", LENGTH, offsetof(header, edge[0])},     {"p", NUMBER, offsetof(header, pressure)},
                  {"mu", NUMBER, offsetof(header, friction)},    {"nu", NUMBER, offsetof(header, poisson)},
                  {"Ly", LENGTH, offsetof(header, edge[1])},     {"Lz", LENGTH, offsetof(header, edge[2])},
                  {"bottom", COUNT, offsetof(header, bottom)},   {"top", COUNT, offsetof(header, top)},
                  {"walls", COUNT, offsetof(header, walls)},     {"cell", CELL, offsetof(header, cell)},
                  {"xy", NUMBER, offsetof(header, tilt[0])},     {"xz", NUMBER, offsetof(header, tilt[1])},
                  {"yz", NUMBER, offsetof(header, tilt[2])},     {"gravity", NUMBER, offsetof(header, gravity)},
                  {"seed", SEED, offsetof(header, seed)},        {"wall", WALL, offsetof(header, wall)},
                  {"frame", NUMBER, offsetof(header, frame)},    {"e_xx", NUMBER, offsetof(header, strain[0])},
                  {"e_yy", NUMBER, offsetof(header, strain[1])}, {"e_zz", NUMBER, offsetof(header, strain[2])},
                  {"e_yz", NUMBER, offsetof(header, strain[3])}, {"e_xz", NUMBER, offsetof(header, strain[4])},
                  {"e_xy", NUMBER, offsetof(header, strain[5])}};
enum { HEADER_KEYS = sizeof header_key / sizeof *header_key, WORDS_MAX = 64 };
enum { ALWAYS = 6, KEY_LY = ALWAYS, KEY_LZ, KEY_BOTTOM, KEY_TOP, KEY_WALLS, KEY_CELL }; /* places in these rows */

/* Reads the value of a key. Counts must not exceed what the file can contain. */
static sp_status read_value(const sp_lines *at, const struct header_key *key, const char *word, header *h,
                            sp_error *err) {
    static const char *const right[] = {"a whole number >= 0",     "a finite number",
                                        "a finite number above 0", "a whole number of 64 bits",
                                        "rigid, grain or elastic", "piston, periodic, box or ring"};
    const int64_t bytes = at->end - at->next, most = bytes / 4 < INT32_MAX / 4 ? bytes / 4 : INT32_MAX / 4;
    void *to = (char *)h + key->offset;
    int64_t count = 0;
    int cell = 0;
    bool good = true;
    switch (key->kind) {
    case COUNT:
        good = sp_word_integer(word, &count) && count >= 0;
        memcpy(to, &count, sizeof count);
        break;
    case NUMBER: good = sp_word_number(word, to) && isfinite(*(double *)to); break;
    case LENGTH: good = sp_word_number(word, to) && isfinite(*(double *)to) && *(double *)to > 0; break;
    case SEED: good = sp_word_unsigned(word, to); break;
    case WALL: good = sp_wall_read(word, to); break;
    case CELL:
        while (sp_cell_names[cell] && strcmp(sp_cell_names[cell], word) != 0)
            cell++;
        good = sp_cell_names[cell] != NULL;
        h->cell = good ? (sp_cell)cell : SP_CELL_PISTON;
        break;
    }
    if (!good)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: %s is '%.60s'; must be %s", at->file, (long long)at->number,
                       key->name, word, right[key->kind]);
    if (count > most)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: %s is %lld, and the file has room for %lld at the most: truncated",
                       at->file, (long long)at->number, key->name, (long long)count, (long long)most);
    return SP_OK;
}

/* A header with a cell has the number of all contacts with walls; versions that do not know cells miss the other two.
 */
static sp_status check_given(const sp_lines *at, const bool given[HEADER_KEYS], header *h, sp_error *err) {
    const bool cell = given[KEY_CELL];
    for (int k = 0; k < HEADER_KEYS; k++)
        if (!given[k] &&
            (k < ALWAYS || (k == KEY_LY && given[KEY_LZ]) || (cell ? k == KEY_WALLS : k == KEY_BOTTOM || k == KEY_TOP)))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: the header has no %s; must be 'N 600 Lx 24 ...'", at->file,
                           (long long)at->number, header_key[k].name);
    h->dim = given[KEY_LZ] ? 3 : given[KEY_LY] ? 2 : 1;
    if (!cell) {
        h->walls = h->bottom + h->top;
        h->gravity = h->tilt[0] = h->tilt[1] = h->tilt[2] = 0;
    }
    return SP_OK;
}

static sp_status read_header(sp_lines *lines, header *h, sp_error *err) {
    char *line, *word[WORDS_MAX];
    bool given[HEADER_KEYS] = {false};
    sp_status status = sp_lines_next_data(lines, &line, err);
    if (status != SP_OK)
        return status;
    int words = line ? sp_line_words(line, word, WORDS_MAX) : 0;
    if (words < 2 || words > WORDS_MAX || words % 2 != 0)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: no header of keys and values, 'N 600 Lx 24 ...'", lines->file,
                       (long long)lines->number);
    *h = (header){.wall = SP_WALL_RIGID, .edge = {1, 1, 1}, .frame = NAN, .strain = {NAN, NAN, NAN, NAN, NAN, NAN}};
    for (int w = 0; w < words && status == SP_OK; w += 2)
        for (int k = 0; k < HEADER_KEYS && status == SP_OK; k++) {
            if (strcmp(word[w], header_key[k].name) != 0)
                continue;
            status = given[k] ? sp_fail(err, SP_EFORMAT, "%s:%lld: %s is given twice", lines->file,
                                        (long long)lines->number, header_key[k].name)
                              : read_value(lines, &header_key[k], word[w + 1], h, err);
            given[k] = true;
        }
    return status == SP_OK ? check_given(lines, given, h, err) : status;
}

/* ---- rows ------------------------------------------------------------------------------------------------------ */

/* Moves a coordinate along a periodic axis into [0, period). A coordinate inside remains the same, bit for bit. */
static double wrap(double x, double period) {
    if (x >= 0 && x < period)
        return x + 0.0; /* no negative zero */
    double inside = fmod(x, period);
    if (inside < 0)
        inside += period;
    return inside < period ? inside + 0.0 : 0.0;
}

/* Moves a grain that lies outside into the cell along the periodic axes. */
static void wrap_grain(const sp_packing *p, double x[3]) {
    double s[3] = {0, 0, 0};
    bool outside = false;
    for (int k = 0; k < p->dim; k++)
        x[k] = p->cell == SP_CELL_PISTON && k < p->dim - 1 ? wrap(x[k], p->box[k]) : x[k] + 0.0;
    if (p->cell != SP_CELL_PERIODIC)
        return;
    sp_packing_fractions(p, x, s);
    for (int k = 0; k < p->dim; k++)
        outside = outside || !(s[k] >= -1e-12 && s[k] <= 1 + 1e-12); /* what sp_packing_check allows */
    if (outside)
        sp_packing_wrap(p, x);
}

static bool is_wall(const sp_packing *p, int32_t j) { return j < 0 && j >= SP_BACK && sp_packing_has_wall(p, j); }

static sp_status check_contact(const sp_packing *p, const sp_contact *c, sp_error *err) {
    const bool walls[2] = {is_wall(p, c->i), is_wall(p, c->j)};
    const bool grains[2] = {c->i >= 0 && c->i < p->n, c->j >= 0 && c->j < p->n};
    if (!(grains[0] && grains[1] && c->i != c->j) && !(grains[0] && walls[1]) && !(walls[0] && grains[1]))
        return sp_fail(
            err, SP_EFORMAT,
            "a contact of %d and %d; must be two grains of 0..%d, or a grain and a wall of the cell, which is a %s",
            c->i, c->j, p->n - 1,
            p->cell == SP_CELL_PERIODIC ? "periodic one and has none"
            : p->cell == SP_CELL_BOX    ? "box: -1 bottom, -2 top, -3 left, -4 right, -5 front, -6 back (3D)"
            : p->cell == SP_CELL_RING   ? "ring: -1 inner, -2 outer"
                                        : "piston's: -1 bottom, -2 top");
    double length2 = 0;
    for (int k = 0; k < p->dim; k++)
        length2 += c->n[k] * c->n[k];
    if (!(fabs(sqrt(length2) - 1) <= 1e-9))
        return sp_fail(err, SP_EFORMAT, "the normal's length is %.12g; must be 1 within 1e-9", sqrt(length2));
    if (c->overlap < 0 || c->fn < 0)
        return sp_fail(err, SP_EFORMAT, "overlap %g and Fn %g; must be finite and >= 0", c->overlap, c->fn);
    return SP_OK;
}

/* Turns a contact round if j comes before i, or i is a wall. The force on i changes its sign; the scalar in 2D does
 * not, because t turns with n. */
static void put_in_order(sp_contact *c) {
    const int32_t i = c->i;
    if (!(c->i < 0 || (c->j >= 0 && c->i > c->j)))
        return;
    c->i = c->j;
    c->j = i;
    for (int k = 0; k < 3; k++) {
        c->n[k] = 0.0 - c->n[k];
        c->ft[k] = 0.0 - c->ft[k];
    }
}

/* Converts words to finite numbers. name[k] is what word k means. */
static sp_status finite_numbers(const sp_lines *at, int count, char *const *word, const char *const *name, double *out,
                                sp_error *err) {
    for (int k = 0; k < count; k++)
        if (!sp_word_number(word[k], &out[k]) || !isfinite(out[k]))
            return sp_fail(err, SP_EFORMAT, "%s:%lld: %s is '%.60s'; must be a finite number", at->file,
                           (long long)at->number, name[k], word[k]);
    return SP_OK;
}

/* Reads the words of the next line, which must be low .. high in number. */
static sp_status next_words(sp_lines *lines, const char *what, int low, int high, char **word, sp_error *err) {
    char *line;
    sp_status status = sp_lines_next_data(lines, &line, err);
    if (status != SP_OK)
        return status;
    if (!line)
        return sp_fail(err, SP_EFORMAT, "%s: ends after line %lld, where a %s should follow: truncated", lines->file,
                       (long long)lines->number, what);
    int words = sp_line_words(line, word, high);
    if (words < low || words > high)
        return sp_fail(err, SP_EFORMAT, "%s:%lld: %s%d words; a %s has %d", lines->file, (long long)lines->number,
                       words > high ? "more than " : "", words > high ? high : words, what, high);
    return SP_OK;
}

static sp_status read_grain(sp_lines *lines, sp_packing *p, int32_t i, sp_error *err) {
    char *word[5];
    const char *name[4];
    double number[4];
    for (int k = 0; k < p->dim; k++)
        name[k] = axis[k];
    name[p->dim] = "R";
    sp_status status = next_words(lines, "grain", p->dim + 1, p->dim + 2, word, err);
    if (status == SP_OK)
        status = finite_numbers(lines, p->dim + 1, word, name, number, err);
    if (status != SP_OK)
        return status;
    for (int k = 0; k < p->dim; k++)
        p->x[3 * i + k] = number[k];
    wrap_grain(p, p->x + 3 * i);
    p->r[i] = number[p->dim];
    if (!(p->r[i] > 0))
        return sp_fail(err, SP_EFORMAT, "%s:%lld: R is %g; must be positive", lines->file, (long long)lines->number,
                       p->r[i]);
    return SP_OK;
}

static sp_status read_contact(sp_lines *lines, sp_packing *p, int32_t c, sp_error *err) {
    static const char *const names[4][8] = {{0},
                                            {"nx", "overlap", "Fn"},
                                            {"nx", "ny", "overlap", "Fn", "Ft"},
                                            {"nx", "ny", "nz", "overlap", "Fn", "Ftx", "Fty", "Ftz"}};
    const int dim = p->dim, numbers = dim == 1 ? 3 : dim == 2 ? 5 : 8;
    char *word[10];
    double number[8];
    int64_t i, j;
    sp_status status = next_words(lines, "contact", numbers + 2, numbers + 2, word, err);
    if (status != SP_OK)
        return status;
    if (!sp_word_integer(word[0], &i) || !sp_word_integer(word[1], &j) || i < SP_BACK || j < SP_BACK || i >= p->n ||
        j >= p->n)
        return sp_fail(err, SP_EFORMAT,
                       "%s:%lld: contact of '%.30s' and '%.30s'; must be grains 0..%d, or walls, -1..-6", lines->file,
                       (long long)lines->number, word[0], word[1], p->n - 1);
    status = finite_numbers(lines, numbers, word + 2, names[dim], number, err);
    if (status != SP_OK)
        return status;
    sp_contact *to = &p->contacts[c];
    *to = (sp_contact){.i = (int32_t)i, .j = (int32_t)j, .overlap = number[dim], .fn = number[dim + 1]};
    for (int k = 0; k < dim; k++) /* no negative zeros */
        to->n[k] = number[k] + 0.0;
    if (dim == 2)
        tangent_vector(to->n, number[4], to->ft);
    for (int k = 0; dim == 3 && k < 3; k++)
        to->ft[k] = number[5 + k] + 0.0;
    status = check_contact(p, to, err);
    if (status != SP_OK)
        return sp_fail_prefix(err, "%s:%lld", lines->file, (long long)lines->number);
    put_in_order(to);
    return SP_OK;
}

/* Compares the numbers of contacts at the walls with the header. */
static sp_status check_counts(const char *path, const header *h, const sp_packing *p, sp_error *err) {
    int64_t bottom = 0, top = 0, walls = 0;
    for (int32_t c = 0; c < p->n_contacts; c++) {
        bottom += p->contacts[c].j == SP_BOTTOM;
        top += p->contacts[c].j == SP_TOP;
        walls += p->contacts[c].j < 0;
    }
    if (walls != h->walls)
        return sp_fail(err, SP_EFORMAT, "%s: %lld contacts with walls; the header says %lld", path, (long long)walls,
                       (long long)h->walls);
    if (h->bottom + h->top == 0 && h->walls > 0) /* a header with a cell */
        return SP_OK;
    if (bottom != h->bottom || top != h->top)
        return sp_fail(err, SP_EFORMAT,
                       "%s: %lld contacts at the bottom and %lld at the top; the header says %lld and %lld", path,
                       (long long)bottom, (long long)top, (long long)h->bottom, (long long)h->top);
    return SP_OK;
}

sp_status sp_packing_text_parse(const char *path, char *text, size_t size, sp_packing *out, sp_error *err) {
    sp_lines lines = sp_lines_of(path, text, size);
    sp_packing p = sp_packing_none();
    header h;
    sp_locale locale = sp_locale_enter();
    sp_status status = read_header(&lines, &h, err);
    if (status == SP_OK)
        status = sp_packing_alloc(&p, h.dim, (int32_t)h.grains, (int32_t)(h.pairs + h.walls), err);
    if (status == SP_OK) {
        memcpy(p.box, h.edge, sizeof p.box);
        memcpy(p.tilt, h.tilt, sizeof p.tilt);
        p.cell = h.cell;
        p.gravity = h.gravity;
        p.pressure = h.pressure;
        p.friction = h.friction;
        p.poisson = h.poisson;
        p.seed = h.seed;
        p.wall = h.wall;
        p.frame = h.frame;
        memcpy(p.strain, h.strain, sizeof p.strain);
    }
    for (int32_t i = 0; status == SP_OK && i < p.n; i++)
        status = read_grain(&lines, &p, i, err);
    for (int32_t c = 0; status == SP_OK && c < p.n_contacts; c++)
        status = read_contact(&lines, &p, c, err);
    char *line = NULL;
    if (status == SP_OK)
        status = sp_lines_next_data(&lines, &line, err);
    if (status == SP_OK && line)
        status = sp_fail(err, SP_EFORMAT, "%s:%lld: more lines than the header says", path, (long long)lines.number);
    if (status == SP_OK)
        status = check_counts(path, &h, &p, err);
    sp_locale_leave(&locale);
    if (status != SP_OK) {
        sp_packing_free(&p);
        return status;
    }
    sp_packing_sort(&p);
    *out = p;
    return SP_OK;
}

/* ---- writing --------------------------------------------------------------------------------------------------- */

static void add_numbers(sp_text *t, const double *value, int count) {
    for (int k = 0; k < count; k++) {
        sp_text_number(t, value[k]);
        sp_text_add(t, " ");
    }
}

/* Words of the comment line, by dimension. */
static const char *const centre[3] = {"x", "x y", "x y z"}, *const normal[3] = {"nx", "nx ny", "nx ny nz"};
static const char *const columns[3] = {"", " Ft", " Ftx Fty Ftz"};
static const char *const meaning[3] = {"", "; Ft = force on i along t=(-ny,nx)", "; Ft = force on i"};

static const char *wall_words(const sp_packing *p) {
    switch (p->cell) {
    case SP_CELL_PERIODIC: return "no walls";
    case SP_CELL_BOX: return "walls: j=-1 bottom, -2 top, -3 left, -4 right, -5 front, -6 back";
    case SP_CELL_RING: return "j=-1 inner wall, j=-2 outer wall";
    default: return "j=-1 bottom wall, j=-2 top wall";
    }
}

/* The cell, in place of the numbers of contacts at the bottom and at the top. */
static void add_cell(sp_text *t, const sp_packing *p, int32_t walls) {
    static const char *const tilt[3] = {"xy", "xz", "yz"};
    sp_text_add(t, " walls %d cell %s", walls, sp_cell_names[p->cell]);
    for (int k = 0; k < 3; k++)
        if (p->tilt[k] != 0)
            sp_text_add(t, " %s %.17g", tilt[k], p->tilt[k]);
    if (p->gravity != 0)
        sp_text_add(t, " gravity %.17g", p->gravity);
}

static void add_series(sp_text *t, const sp_packing *p) {
    if (isnan(p->frame))
        return;
    sp_text_add(t, " frame %.17g", p->frame);
    for (int k = 0; k < SP_SERIES_STRAINS; k++)
        if (!isnan(p->strain[k]))
            sp_text_add(t, " %s %.17g", sp_strain_names[k], p->strain[k]);
}

static void add_header(sp_text *t, const sp_packing *p) {
    int32_t bottom = 0, top = 0, walls = 0;
    for (int32_t c = 0; c < p->n_contacts; c++) {
        bottom += p->contacts[c].j == SP_BOTTOM;
        top += p->contacts[c].j == SP_TOP;
        walls += p->contacts[c].j < 0;
    }
    sp_text_add(t,
                "# packing: header, then N grain lines '%s R rattler', then contact lines 'i j %s overlap Fn%s' (%s; n "
                "from i to j%s)\nN %d ",
                centre[p->dim - 1], normal[p->dim - 1], columns[p->dim - 1], wall_words(p), meaning[p->dim - 1], p->n);
    for (int k = 0; k < p->dim; k++)
        sp_text_add(t, "L%s %.17g ", axis[k], p->box[k]);
    sp_text_add(t, "p %.17g mu %.17g nu %.17g contacts %d", p->pressure, p->friction, p->poisson,
                p->n_contacts - walls);
    if (p->cell != SP_CELL_PISTON || p->gravity != 0)
        add_cell(t, p, walls);
    else
        sp_text_add(t, " bottom %d top %d", bottom, top);
    if (p->seed)
        sp_text_add(t, " seed %llu", (unsigned long long)p->seed);
    if (p->wall != SP_WALL_RIGID)
        sp_text_add(t, " wall %s", sp_wall_names[p->wall]);
    add_series(t, p);
    sp_text_add(t, "\n");
}

static void add_rows(sp_text *t, const sp_packing *p, const uint8_t *rattler) {
    for (int32_t i = 0; i < p->n; i++) {
        add_numbers(t, p->x + 3 * i, p->dim);
        add_numbers(t, &p->r[i], 1);
        sp_text_add(t, "%d\n", rattler[i]);
    }
    for (int32_t c = 0; c < p->n_contacts; c++) {
        const sp_contact *k = &p->contacts[c];
        sp_text_add(t, "%d %d ", k->i, k->j);
        add_numbers(t, k->n, p->dim);
        double scalar = p->dim == 2 ? tangent_scalar(k->n, k->ft) : 0;
        sp_text_add(t, "%.17g %.17g", k->overlap, k->fn);
        if (p->dim == 2)
            sp_text_add(t, " %.17g", scalar);
        else if (p->dim == 3)
            sp_text_add(t, " %.17g %.17g %.17g", k->ft[0], k->ft[1], k->ft[2]);
        sp_text_add(t, "\n");
    }
}

sp_status sp_packing_save_text(const sp_packing *p, const char *path, sp_error *err) {
    sp_text text = {0};
    uint8_t *rattler = NULL;
    sp_status status = sp_packing_check(p, err);
    if (status == SP_OK && !sp_packing_hertzian(p))
        status =
            sp_fail(err, SP_EINVAL,
                    "%s: this form has no place for masses and stiffnesses of their own: write .h5, or tables", path);
    if (status != SP_OK)
        return status;
    rattler = sp_alloc((size_t)p->n, sizeof *rattler);
    if (!rattler)
        return sp_fail_memory(err, (size_t)p->n);
    status = sp_packing_rattlers(p, 1e-4, rattler, NULL, NULL, err);
    if (status == SP_OK) {
        sp_locale locale = sp_locale_enter();
        add_header(&text, p);
        add_rows(&text, p, rattler);
        sp_locale_leave(&locale);
        status = text.failed ? sp_fail_memory(err, text.capacity) : sp_text_save(path, text.data, text.size, err);
    }
    sp_free(rattler);
    sp_text_free(&text);
    return status;
}
