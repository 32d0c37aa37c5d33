/* Equations (35) and (37) as printed: growth rates and speeds of their linear waves, and the refusal to run them. */
#include "base/base.h"
#include "paper/blackmore.h"

#include <stdio.h>
#include <string.h>

static const double step = 0.01; /* the paper's steps [s, cm] */

enum { WAVES = 241, CURVES = 4 };

/* Growth rates and squared speeds against k, linearised about y_z = 1. */
typedef struct symbols {
    double k[WAVES], growth[CURVES][WAVES], speed2[CURVES][WAVES];
} symbols;

static const char *const names[CURVES] = {"eq35", "eq37", "longwave", "lattice"};

static sp_status evaluate(const sp_tapped_spec *c, symbols *s, sp_error *err) {
    static const sp_tapped_model models[] = {SP_TAPPED_EQ35, SP_TAPPED_EQ37, SP_TAPPED_LONGWAVE};
    const double h = 2 * sp_tapped_radius(c, 1), unit = sp_blackmore_speed2(c);
    sp_status status = SP_OK;
    for (int i = 0; i < WAVES; i++) {
        const double k = s->k[i] = 0.01 * pow(10, 4.5 * i / (WAVES - 1)), x = sin(0.5 * k * h) / (0.5 * k * h);
        for (int j = 0; j < 3 && status == SP_OK; j++) {
            sp_tapped_symbol at;
            status = sp_tapped_symbol_at(c, models[j], 1 / h, 1, k, &at, err);
            if (status != SP_OK)
                return status;
            s->growth[j][i] = at.growth;
            s->speed2[j][i] = at.speed2 / unit;
        }
        s->growth[3][i] = 0;
        s->speed2[3][i] = k * h <= blackmore_pi ? x * x : NAN;
    }
    return status;
}

static sp_status save(blackmore *p, const symbols *s, sp_error *err) {
    sp_table t = sp_table_none();
    char name[40];
    sp_status status = sp_table_add_comment(&t, err,
                                            "linearised about y = z, alpha = 1/h; ten particles of Fig. 1; "
                                            "speed2 in K h^2/m; the lattice's waves end at k = pi/h");
    if (status == SP_OK)
        status = sp_table_add_column(&t, "k", "1/cm", SP_COLUMN_NUMBER, err);
    for (int j = 0; j < 2 * CURVES && status == SP_OK; j++) {
        snprintf(name, sizeof name, "%s_%s", j % 2 ? "speed2" : "growth", names[j / 2]);
        status = sp_table_add_column(&t, name, j % 2 ? "" : "1/s", SP_COLUMN_NUMBER, err);
    }
    for (int i = 0; i < WAVES && status == SP_OK; i++) {
        double row[1 + 2 * CURVES] = {s->k[i]};
        for (int j = 0; j < 2 * CURVES; j++)
            row[1 + j] = j % 2 ? s->speed2[j / 2][i] : s->growth[j / 2][i];
        status = sp_table_add_numbers(&t, row, err);
    }
    if (status == SP_OK)
        status = sp_blackmore_save(p, "symbols-waves", &t, err);
    sp_table_free(&t);
    return status;
}

static sp_status draw(blackmore *p, symbols *s, sp_error *err) {
    static const char *const labels[CURVES] = {"(35) as printed", "(37) as printed", "long wave here", "lattice"};
    static const sp_dash dash[CURVES] = {SP_DASH_SOLID, SP_DASH_DASHED, SP_DASH_SOLID, SP_DASH_DOTTED};
    sp_curve growth[2], speed[CURVES];
    for (int j = 0; j < CURVES; j++) {
        for (int i = 0; i < WAVES && j < 2; i++)
            if (!(s->growth[j][i] > 0))
                s->growth[j][i] = NAN; /* a logarithmic axis cannot show it */
        speed[j] = (sp_curve){.label = j < 2 ? NULL : labels[j],
                              .n = WAVES,
                              .x = s->k,
                              .y = s->speed2[j],
                              .ink = j < 3 ? j + 1 : 0,
                              .dash = dash[j]};
        if (j < 2) {
            growth[j] = speed[j];
            growth[j].label = labels[j];
            growth[j].y = s->growth[j];
        }
    }
    const sp_panel panel[2] = {{.tag = "(a)",
                                .x = {.label = "|k| [1/cm]", .log = true, .low = 0.01, .high = 316},
                                .y = {.label = "growth rate [1/s]", .log = true, .low = 1, .high = 5e7},
                                .curves = 2,
                                .curve = growth},
                               {.tag = "(b)",
                                .x = {.label = "|k| [1/cm]", .log = true, .low = 0.01, .high = 316},
                                .y = {.label = "|c|^{2}/(|K| |h|^{2}/|m|)", .low = -8, .high = 8},
                                .curves = CURVES,
                                .curve = speed,
                                .zero_line = true,
                                .tight = true}};
    const sp_sheet sheet = {.title = "symbols of (35) and (37)", .rows = 1, .columns = 2, .panel = panel};
    return sp_blackmore_draw_sheet(
        p, BLACKMORE_SYMBOLS, "symbols-waves", &sheet,
        "(a) Growth rates of waves exp(i k z) by (35) and (37) as printed, about y = z; the "
        "lattice and the long wave here have none. (b) Squares of their speeds; below 0 there is "
        "no wave; (35) and (37) as in (a).",
        err);
}

/* ---- rows ------------------------------------------------------------------------------------------------------- */

static blackmore_row value(const char *equation, const char *unit, double paper, double ours, const char *note) {
    blackmore_row row = {.item = BLACKMORE_SYMBOLS, .equation = equation, .unit = unit, .paper = paper, .ours = ours};
    sp_blackmore_note(&row, "%s", note);
    return row;
}

static void add_coefficients(blackmore *p, const sp_tapped_spec *c) {
    const double h = 2 * sp_tapped_radius(c, 1);
    const blackmore_coefficients a = sp_blackmore_coefficients(0.5 * h, 1 / h);
    blackmore_row row = value("(38)", "", 2.5, a.plus, "");
    row.precision = 0.05;
    sp_blackmore_add(p, row, "A(+) at chi(0) = 1/2, alpha = 1/h");
    sp_blackmore_add(p, value("(38)", "1/h", -1, a.b * h, ""), "B at alpha = 1/h");
}

/* Adds the largest growth rate of (37), and that of (35) on the paper's grid. */
static sp_status add_growth(blackmore *p, const sp_tapped_spec *c, const symbols *s, sp_error *err) {
    const double h = 2 * sp_tapped_radius(c, 1);
    double most = 0, at = 0;
    for (int i = 0; i < WAVES; i++)
        if (s->growth[1][i] > most) {
            most = s->growth[1][i];
            at = s->k[i];
        }
    for (double k = at / 1.05; k < at * 1.05; k *= 1.0001) {
        sp_tapped_symbol here;
        sp_status status = sp_tapped_symbol_at(c, SP_TAPPED_EQ37, 1 / h, 1, k, &here, err);
        if (status != SP_OK)
            return status;
        if (here.growth > most) {
            most = here.growth;
            at = k;
        }
    }
    sp_tapped_symbol grid;
    sp_status status = sp_tapped_symbol_at(c, SP_TAPPED_EQ35, 1 / h, 1, blackmore_pi / step, &grid, err);
    if (status != SP_OK)
        return status;
    blackmore_row row = value("(37)", "1/s", NAN, most, "");
    row.err = 1e-6 * most; /* error of the maximum, quadratic in the step of k */
    sp_blackmore_note(&row, "at k = %.4g /cm: a factor of %.3g in each step of 0.01 s", at, exp(step * most));
    sp_blackmore_add(p, row, "largest growth rate of all waves");
    row = value("(35)", "1/s", NAN, grid.growth, "grows as k^2, without bound: a finer grid is worse");
    sp_blackmore_add(p, row, "growth rate of the shortest wave on dz = 0.01 cm");
    sp_blackmore_say(
        p, BLACKMORE_SYMBOLS,
        "(37) has no waves below k = %.3g /cm: they grow, by up to %.4g /s. (35), of the other sign, has waves "
        "there and growth above, without bound in k. No scheme helps: a finer one follows the growth better.",
        at * sqrt(2), most);
    return SP_OK;
}

static sp_status add_speeds(blackmore *p, const sp_tapped_spec *c, sp_error *err) {
    const double h = 2 * sp_tapped_radius(c, 1), unit = sp_blackmore_speed2(c);
    blackmore_row row = value("(35)", "K h^2/m", NAN, sp_tapped_expansion_speed2(c, 1 / h, 1) / unit,
                              "the lattice has +1/2: all orders of the expansion are as large as the last");
    sp_blackmore_add(p, row, "c^2 of the expansion with its coefficients put right");
    row = value("Sect. 7", "", 1, sqrt(unit), "dt = dz = 0.01 is printed; above 1 central differences blow up");
    row.relation = BLACKMORE_BELOW;
    sp_blackmore_add(p, row, "CFL number of the paper's steps, N = 10");
    sp_tapped_symbol wave = {0};
    const sp_status status = sp_tapped_symbol_at(c, SP_TAPPED_LONGWAVE, 1 / h, 0.95, blackmore_pi / h, &wave, err);
    if (status != SP_OK)
        return status;
    row = value("-", "1/s", NAN, wave.growth, "of the model that is run instead, at y_z = 0.95: damped, as all k are");
    sp_blackmore_add(p, row, "growth rate of the long wave here, k = pi/h");
    return SP_OK;
}

/* Adds the library's refusals of both. */
static void add_refusals(blackmore *p, const sp_tapped_spec *c) {
    static const sp_tapped_model models[2] = {SP_TAPPED_EQ35, SP_TAPPED_EQ37};
    for (int k = 0; k < 2; k++) {
        sp_tapped_spec own = *c;
        sp_error why = {0};
        own.model = models[k];
        const bool refused = sp_tapped_run(&own, 0, NULL, NULL, NULL, NULL, &why) == SP_EREFUSED;
        blackmore_row row =
            value(k == 0 ? "(35)" : "(37)", "", k == 0 ? NAN : 1, refused ? 0 : 1, "refused; the command says why");
        sp_blackmore_add(p, row, "can be run as printed (1: yes)");
        sp_blackmore_say(p, BLACKMORE_SYMBOLS, "The command refuses %s: %s.", row.equation, why.text);
    }
}

sp_status sp_blackmore_make_symbols(blackmore *p, sp_error *err) {
    const sp_tapped_spec c = sp_blackmore_column(10);
    symbols *s = sp_alloc(1, sizeof *s);
    if (!s)
        return sp_fail_memory(err, sizeof *s);
    sp_status status = evaluate(&c, s, err);
    add_coefficients(p, &c);
    if (status == SP_OK)
        status = add_growth(p, &c, s, err);
    if (status == SP_OK)
        status = add_speeds(p, &c, err);
    add_refusals(p, &c);
    if (status == SP_OK)
        status = save(p, s, err);
    if (status == SP_OK)
        status = draw(p, s, err);
    sp_free(s);
    return status;
}
