/* Reads packings of other programs for sonopack convert. */
#include "base/base.h"
#include "cli/convert.h"
#include "cli/output.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

/* ---- is it one? ------------------------------------------------------------------------------------------------- */

/* Tables of ours end in .tsv and come with a table of contacts that exists. */
static bool is_our_table(const convert_arguments *a) {
    return a->grains || (cli_has_ending(a->in, ".tsv") && !(a->contacts && strcmp(a->contacts, "overlap") == 0));
}

sp_status convert_is_foreign(const convert_arguments *a, bool *foreign, sp_error *err) {
    sp_form form = SP_FORM_AUTO;
    *foreign = a->from != SP_FORM_AUTO;
    if (*foreign || !a->in || is_our_table(a) || access(a->in, F_OK) != 0)
        return SP_OK;
    sp_status status = sp_form_of_file(a->in, &form, err);
    *foreign = status == SP_OK && form != SP_FORM_AUTO && form != SP_FORM_OURS;
    return status;
}

sp_status convert_refuse_options(const convert_arguments *a, const cli_syntax *syntax, sp_error *err) {
    static const char *const names[] = {"walls",     "columns", "types",    "frame",     "length-unit", "force-unit",
                                        "mass-unit", "kn",      "kt-ratio", "thickness", "rest"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        if (cli_given(syntax, &a->common, names[k]))
            return sp_fail(
                err, SP_EINVAL,
                "--%s: applies to files of other programs; %s is not recognised as one (--from FORM says its "
                "form)",
                names[k], a->in ? a->in : "IN");
    return SP_OK;
}

sp_status convert_take_files(convert_arguments *a, sp_error *err) {
    if (a->common.output && a->out)
        return sp_fail(err, SP_EINVAL, "OUT is given twice, as %s and -o %s", a->out, a->common.output);
    a->out = a->common.output ? a->common.output : a->out;
    if (!a->in || !a->out)
        return sp_fail(
            err, SP_EINVAL,
            "no OUT: must be a file name that ends in .h5, .txt, .vtp, .pvd, .data, .dump, .xyz, .csv or .mat");
    if (a->grains)
        return sp_fail(err, SP_EINVAL, "--grain-table: IN is %s, the grains of another program; must not be given",
                       a->in);
    return SP_OK;
}

/* ---- import ----------------------------------------------------------------------------------------------------- */

sp_status convert_set_material(void *arguments, const char *text, sp_error *err) {
    cli_common *common = arguments;
    char whole[SP_MATERIAL_TEXT];
    const bool has_d = strncmp(text, "d=", 2) == 0 || strstr(text, ",d=") || strstr(text, " d=");
    if ((size_t)snprintf(whole, sizeof whole, "%s%s", text, has_d ? "" : ",d=1") >= sizeof whole)
        return sp_fail(err, SP_EINVAL, "--material: longer than %zu characters", sizeof whole - 1);
    sp_status status = cli_set_material(arguments, whole, err);
    if (status == SP_OK && !has_d)
        common->material.diameter = 0;
    return status;
}

static sp_status fill_options(const convert_arguments *a, const cli_syntax *syntax, sp_import_options *o,
                              sp_error *err) {
    *o = sp_import_options_default();
    o->form = (sp_form)a->from;
    o->contacts = a->contacts;
    o->walls = a->walls;
    o->columns = a->columns;
    o->types = a->types;
    o->frame = a->frame;
    o->frame_given = cli_given(syntax, &a->common, "frame");
    o->length_unit = a->length_unit;
    o->force_unit = a->force_unit;
    o->mass_unit = a->mass_unit;
    o->kn = a->kn;
    o->kt_ratio = a->kt_ratio;
    o->thickness = a->thickness;
    o->rest = a->rest;
    o->threads = a->common.threads;
    o->material = a->common.material;
    sp_status status = SP_OK;
    for (int k = 0; status == SP_OK && k < a->common.sets; k++)
        status = sp_import_set(o, a->common.set[k], err);
    return status;
}

static void print_report(const convert_arguments *a, const sp_import_report *r) {
    char hertz[120] = "";
    if (isfinite(r->hertz))
        snprintf(hertz, sizeof hertz, "; normal forces follow Hertz's law within %.1e",
                 fabs(r->hertz - 1) + r->hertz * r->hertz_spread);
    cli_note(&a->common, "%s: %s, %d grains, %d contacts, %d of them with walls; largest net force %.2g of the mean%s",
             a->in, sp_form_names[r->form], r->grains, r->contacts, r->wall_contacts, r->balance, hertz);
    if (r->left_out > 0)
        cli_note(&a->common, "%lld grain%s of other types %s left out", (long long)r->left_out,
                 r->left_out > 1 ? "s" : "", r->left_out > 1 ? "are" : "is");
    for (int k = 0; k < r->notes; k++)
        cli_note(&a->common, "%s", r->note[k]);
}

sp_status convert_give_material(const convert_arguments *a, sp_packing *p, sp_error *err) {
    if (!(a->common.material.young > 0))
        return SP_OK;
    if (!(a->common.material.diameter > 0))
        return sp_fail_key(err, SP_EINVAL, "material.d",
                           ": is missing in --material; only files of other programs give it by their mean diameter");
    p->material = a->common.material;
    return SP_OK;
}

sp_status convert_import(const convert_arguments *a, const cli_syntax *syntax, sp_packing *p, sp_error *err) {
    sp_import_options o;
    sp_import_report report;
    sp_status status = fill_options(a, syntax, &o, err);
    if (status == SP_OK)
        status = sp_import(a->in, &o, p, &report, err);
    if (status == SP_OK)
        print_report(a, &report);
    return status;
}
