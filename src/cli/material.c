/* The material of the grains, which turns options and tables into SI units. */
#include "cli/cli.h"

#include "base/base.h"
#include "scene/field.h"
#include "store/packing_text.h"

#include <stdio.h>
#include <string.h>

/* Values of grains, in SI, and in another unit that may have been meant where a value is beyond these. */
static const struct {
    const char *key;
    size_t offset;
    double low, high, other;
    const char *unit, *other_unit;
} usual[] = {{"E", offsetof(sp_material, young), 1e3, 2e12, 1e9, "Pa", "GPa"},
             {"rho", offsetof(sp_material, density), 10, 3e4, 1e3, "kg/m^3", "g/cm^3"},
             {"d", offsetof(sp_material, diameter), 1e-7, 0.1, 1e-3, "m", "mm"}};

/* ---- --material -------------------------------------------------------------------------------------------------- */

/* Appends KEY=VALUE with the value in its SI unit, if it is given with one. */
static sp_status put_value(const char *word, size_t length, char *text, size_t size, sp_error *err) {
    char pair[80], key[96], number[SP_NUMBER_TEXT];
    double value;
    snprintf(pair, sizeof pair, "%.*s", (int)(length < 79 ? length : 79), word);
    char *equals = strchr(pair, '=');
    const size_t used = strlen(text), digits = equals ? strspn(equals + 1, "0123456789+-.eE") : 0;
    snprintf(key, sizeof key, "material.%.*s", equals ? (int)(equals - pair) : 0, pair);
    const sp_field *f = sp_field_find(key);
    const sp_key *limits = f ? sp_field_limits(f) : NULL;
    if (!limits || !limits->unit[0] || digits == 0 || equals[1 + digits] == '\0') {
        snprintf(text + used, size - used, "%s,", pair);
        return SP_OK;
    }
    sp_status status = sp_quantity_read(equals + 1, limits->unit, NULL, &value, err);
    if (status != SP_OK)
        return sp_fail_prefix_key(err, key);
    snprintf(text + used, size - used, "%.*s=%s,", (int)(equals - pair), pair, sp_number_text(value, number));
    return SP_OK;
}

sp_status cli_set_material(void *arguments, const char *text, sp_error *err) {
    char plain[400] = "";
    sp_status status = SP_OK;
    for (const char *at = text; *at && status == SP_OK; at += strspn(at, ",")) {
        const size_t length = strcspn(at, ",");
        status = put_value(at, length, plain, sizeof plain, err);
        at += length;
    }
    CLI_THEN(status, sp_material_read(plain, &((cli_common *)arguments)->material, err));
    return status == SP_OK ? SP_OK : sp_fail_prefix(err, "--material");
}

/* ---- options that wait ------------------------------------------------------------------------------------------- */

static const char *unit_of(const cli_option *o) {
    const sp_key *range = o->key ? sp_field_limits(sp_field_find(o->key)) : NULL;
    return o->unit ? o->unit : range ? range->unit : "";
}

bool cli_keep_quantity(cli_common *common, const cli_option *option, void *field, const char *text) {
    const size_t number = strspn(text, "0123456789+-.eE");
    if (!unit_of(option)[0] || number == 0 || text[number] == '\0' || common->quantities == CLI_QUANTITIES_MAX)
        return false;
    common->quantity[common->quantities++] = (cli_quantity){option, text, field};
    return true;
}

sp_status cli_set_quantities(void *arguments, const sp_material *m, sp_error *err) {
    cli_common *common = arguments;
    for (int k = 0; k < common->quantities; k++) {
        const cli_option *o = common->quantity[k].option;
        const sp_key *range = o->key ? sp_field_limits(sp_field_find(o->key)) : NULL;
        char name[64], number[SP_NUMBER_TEXT];
        double value;
        snprintf(name, sizeof name, "--%s", o->name);
        sp_status status = sp_quantity_read(common->quantity[k].text, unit_of(o), m, &value, err);
        if (status != SP_OK)
            return sp_fail_prefix(err, "%s", name);
        status = cli_number(name, sp_number_text(value, number), range ? range->low : o->low,
                            range ? range->high : o->high, common->quantity[k].field, err);
        if (status != SP_OK)
            return sp_fail_prefix(err, "%s", common->quantity[k].text);
    }
    common->converted = common->converted || common->quantities > 0;
    common->quantities = 0;
    return SP_OK;
}

/* ---- the material that counts ------------------------------------------------------------------------------------ */

static bool is_known(const sp_material *m) { return m->young > 0; }

static bool is_same(const sp_material *a, const sp_material *b) {
    char one[SP_MATERIAL_TEXT], other[SP_MATERIAL_TEXT];
    return strcmp(sp_material_text(a, one), sp_material_text(b, other)) == 0; /* with all digits */
}

const sp_material *cli_material(const cli_common *common) {
    if (is_known(&common->material))
        return &common->material;
    return is_known(&common->found) && !common->mixed ? &common->found : NULL;
}

static sp_status no_material(const char *what, const char *from, sp_error *err) {
    return sp_fail(err, SP_EINVAL,
                   "%s: needs a material, and %s has none: give it, as in --material "
                   "E=70e9,nu=0.22,rho=2500,d=1e-3 (Pa, kg/m^3, m)",
                   what, from);
}

static sp_status differ(const cli_common *common, const char *from, sp_error *err) {
    return sp_fail(err, SP_EINVAL, "%s and %s are of different materials: choose one by --material", common->found_in,
                   from);
}

/* One warning for all values that grains hardly have. */
static void note_unusual(const cli_common *common, const sp_material *m) {
    char line[400] = "", meant[80];
    for (size_t k = 0; k < sizeof usual / sizeof *usual; k++) {
        double value;
        memcpy(&value, (const char *)m + usual[k].offset, sizeof value);
        const double other = value * usual[k].other;
        if (value >= usual[k].low && value <= usual[k].high)
            continue;
        const bool large = other >= 1e6;
        snprintf(meant, sizeof meant, "if %s were meant, %g%s %s", usual[k].other_unit, large ? other / 1e9 : other,
                 large ? "e9" : "", usual[k].unit);
        if (other < usual[k].low || other > usual[k].high)
            snprintf(meant, sizeof meant, "usual are %g .. %g", usual[k].low, usual[k].high);
        const size_t used = strlen(line);
        snprintf(line + used, sizeof line - used, "%smaterial.%s = %g %s (%s)", used ? ", " : "", usual[k].key, value,
                 usual[k].unit, meant);
    }
    if (line[0])
        cli_note(common, "warning: %s: no usual grains", line);
}

sp_status cli_take_material(void *arguments, const sp_material *m, const char *from, sp_error *err) {
    cli_common *common = arguments;
    const bool si = common->units == CLI_UNITS_SI;
    char text[SP_MATERIAL_TEXT];
    if (is_known(&common->material)) {
        if (is_known(m) && !is_same(m, &common->material))
            cli_note(common, "%s: --material replaces its material %s", from, sp_material_text(m, text));
        if (!common->found_in)
            note_unusual(common, &common->material);
        common->found_in = from;
        return SP_OK;
    }
    if (!is_known(m) && si)
        return no_material("--units si", from, err);
    const bool differs = is_known(&common->found) && !is_same(m, &common->found);
    if (differs && (si || common->converted))
        return differ(common, from, err);
    if (!is_known(m) || differs) {
        common->mixed = true;
        return cli_set_quantities(arguments, m, err);
    }
    if (!is_known(&common->found))
        note_unusual(common, m);
    common->found = *m;
    common->found_in = from;
    return cli_set_quantities(arguments, m, err);
}

sp_status cli_take_table_material(void *arguments, const sp_table *t, const char *from, sp_error *err) {
    const char *text = sp_table_get_text(t, "material");
    sp_material m = {0};
    sp_status status = text ? sp_material_read(text, &m, err) : SP_OK;
    if (status != SP_OK)
        return sp_fail_prefix(err, "%s", from);
    bool ours = false, units = false; /* a table in SI, or of a laboratory, needs none */
    for (int c = 0; c < t->columns; c++) {
        ours = ours || sp_unit_is_ours(t->column[c].unit);
        units = units || t->column[c].unit[0] != '\0';
    }
    const cli_common *common = arguments;
    if (common->units == CLI_UNITS_SI && !units)
        return sp_fail(
            err, SP_EINVAL,
            "%s: names no units, so --units si can convert nothing: must be a table with the line # units:", from);
    if (text && !ours && is_known(&common->material) && !is_same(&m, &common->material))
        return sp_fail(err, SP_EINVAL, "%s: is in SI units already, of the material %s; --material must be this one",
                       from, text);
    return text || ours ? cli_take_material(arguments, &m, from, err) : SP_OK;
}

/* Says so where what should be a scene is a packing. */
static sp_status tell_packing(const char *path, sp_status status, sp_error *err) {
    sp_packing p = sp_packing_none();
    bool looks;
    if (sp_packing_file_looks(path, &looks, NULL) == SP_OK && looks && sp_packing_read(path, &p, NULL) == SP_OK)
        status = sp_fail(err, SP_EINVAL,
                         "%s: is a packing, must be a scene; a scene with packing.file = \"%s\" goes on from it", path,
                         path);
    sp_packing_free(&p);
    return status;
}

sp_status cli_read_scene(const cli_common *common, const char *path, sp_scene *out, sp_error *err) {
    enum { SETS = sizeof common->set / sizeof *common->set };
    char *set[SETS + 1], text[sizeof "material=" + SP_MATERIAL_TEXT] = "material=";
    memcpy(set, common->set, sizeof common->set);
    int sets = common->sets;
    if (is_known(&common->material)) {
        sp_material_text(&common->material, text + strlen(text));
        set[sets++] = text;
    }
    const sp_status status = sp_scene_read(path, sets, set, out, err);
    return status == SP_OK || !path ? status : tell_packing(path, status, err);
}

void cli_note_material(const cli_common *common, const sp_scene *scene) {
    const sp_material *m = is_known(&common->material) ? &common->material : &scene->material;
    if (is_known(m) && (m->poisson < scene->pack.poisson || m->poisson > scene->pack.poisson))
        cli_note(
            common,
            "warning: material.nu = %g, but packing.poisson = %g: the tangential stiffnesses of the packing are of "
            "another material",
            m->poisson, scene->pack.poisson);
}

/* ---- tables ------------------------------------------------------------------------------------------------------ */

static bool has_own_units(const sp_table *t) {
    for (int c = 0; c < t->columns; c++)
        if (sp_unit_is_ours(t->column[c].unit))
            return true;
    return false;
}

sp_status cli_convert_table(const cli_common *common, sp_table *t, sp_error *err) {
    const sp_material *m = cli_material(common);
    char text[SP_MATERIAL_TEXT];
    if (common->units == CLI_UNITS_SI && m)
        return sp_table_to_si(t, m, err);
    if (!has_own_units(t))
        return SP_OK;
    if (common->units == CLI_UNITS_SI)
        return no_material("--units si", "this table", err);
    if (!m || sp_table_get_text(t, "material"))
        return SP_OK;
    return sp_table_set_text(t, "material", sp_material_text(m, text), err);
}
