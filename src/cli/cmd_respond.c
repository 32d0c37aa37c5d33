/* sonopack respond: prints the static response of a packing to a load, by grains or by contacts. */
#include "base/base.h"
#include "cli/motion.h"

#include <stdio.h>
#include <string.h>

typedef struct arguments {
    cli_common common;
    int loads;     /* how many were given */
    char load[64]; /* as it was given */
    sp_load_kind kind;
    int64_t at;  /* grain or contact of the packing */
    int axis[2]; /* of a strain; both are that of a force */
    bool contacts;
} arguments;

static const char axes[] = "xyz";

/* The axis of a letter, or -1. */
static int axis_of(char letter) {
    const char *found = letter ? strchr(axes, letter) : NULL;
    return found ? (int)(found - axes) : -1;
}

/* A load as it is given, such as "swell 3". */
static void take(arguments *a, sp_load_kind kind, const char *word, const char *text) {
    snprintf(a->load, sizeof a->load, "%s %s", word, text);
    a->loads++;
    a->kind = kind;
}

static sp_status read_push(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    const char *colon = strchr(text, ':');
    char number[32] = "";
    take(a, SP_LOAD_FORCE, "push", text);
    if (!colon || colon - text >= (long)sizeof number || axis_of(colon[1]) < 0 || colon[2])
        return sp_fail(err, SP_EINVAL, "--push %.60s: must be GRAIN:x, GRAIN:y or GRAIN:z", text);
    memcpy(number, text, (size_t)(colon - text));
    a->axis[0] = a->axis[1] = axis_of(colon[1]);
    return cli_integer("--push", number, 0, INT32_MAX, &a->at, err);
}

static sp_status read_dipole(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    take(a, SP_LOAD_DIPOLE, "dipole", text);
    return cli_integer("--dipole", text, 0, INT32_MAX, &a->at, err);
}

static sp_status read_swell(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    take(a, SP_LOAD_SWELL, "swell", text);
    return cli_integer("--swell", text, 0, INT32_MAX, &a->at, err);
}

static sp_status read_strain(void *user, const char *text, sp_error *err) {
    arguments *a = user;
    take(a, SP_LOAD_STRAIN, "strain", text);
    for (int k = 0; k < 2; k++)
        a->axis[k] = axis_of(text[0] ? text[k] : '\0');
    if (a->axis[0] < 0 || a->axis[1] < a->axis[0] || text[2])
        return sp_fail(err, SP_EINVAL, "--strain %.60s: must be xx, yy, zz, xy, xz or yz", text);
    return SP_OK;
}

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    return a->loads == 1 ? SP_OK
                         : sp_fail(err, SP_EINVAL,
                                   "must have one of --push, --dipole, --swell and --strain, there are %d", a->loads);
}

static const cli_option options[] = {
    {"push", "GRAIN:AXIS", "A force of 1 on a grain along x, y or z", .parse = read_push},
    {"dipole", "CONTACT", "Two forces of 1 that push the ends of a contact apart", .parse = read_dipole},
    {"swell", "GRAIN", "A grain whose radius grows by 1 of itself", .parse = read_swell},
    {"strain", "AB", "The affine displacement u_A = x_B: xx, yy, zz (extension), xy, xz or yz (shear)",
     .parse = read_strain},
    {"contacts", NULL, "Print the changes of the forces of all contacts in place of displacements", CLI_FLAG,
     CLI_FIELD(contacts)},
    {0}};

const cli_syntax cmd_respond_syntax = {
    .usage = "FILE",
    .help =
        "Static linear response of a packing to one load, between fixed walls or in a fixed cell: the displacements of "
        "its grains, or the changes of its forces.\vLoads are unit loads: results are for each unit of force [E* d^2], "
        "of relative growth, or of strain. Numbers of grains and contacts are those of the packing, from 0. Of a "
        "strain the displacements are what the grains add to the affine field (the nonaffine ones), and forces are "
        "those of both. Where a packing can move as a whole, in a periodic cell or between smooth walls, a force is "
        "balanced by the opposite one, spread over all masses. fn is positive in compression; ft is the size of the "
        "change of the tangential force. opens and slides are the amplitudes of the load, of either sign and nearest "
        "to 0, at which the linear response takes the normal force of the contact to 0, and its forces to Coulomb's "
        "limit (inf: never).\n"
        "\n"
        "The comment load_error is a bound: the displacements are exact for a load that differs by this part of it. "
        "compliance is the displacement of the load itself, work half of the load times the displacements; of a strain "
        "2 work/V is what the grains take off the affine modulus. Rattlers are left out. With friction --prestress is "
        "refused. --set takes keys of the group network.",
    CLI_ONE_PACKING,
    .options = options,
    .springs = true,
    .check = check};

/* ---- the load ---------------------------------------------------------------------------------------------------- */

static sp_status find_grain(const arguments *a, const sp_network *net, const char *option, int32_t *out,
                            sp_error *err) {
    if (a->at >= net->n_all)
        return sp_fail(err, SP_EINVAL, "%s %lld: must be a grain 0 .. %d", option, (long long)a->at, net->n_all - 1);
    for (*out = 0; *out < net->n; ++*out)
        if (net->grain[*out] == a->at)
            return SP_OK;
    return sp_fail(err, SP_EREFUSED, "%s %lld: is a rattler, which nothing holds", option, (long long)a->at);
}

static sp_status find_spring(const arguments *a, const cli_file *file, int32_t *out, sp_error *err) {
    if (a->at >= file->packing.n_contacts)
        return sp_fail(err, SP_EINVAL, "--dipole %lld: must be a contact 0 .. %d", (long long)a->at,
                       file->packing.n_contacts - 1);
    for (*out = 0; *out < file->network.n_springs; ++*out)
        if (file->network.springs[*out].contact == a->at)
            return SP_OK;
    return sp_fail(err, SP_EREFUSED, "--dipole %lld: this contact carries no force", (long long)a->at);
}

/* In the order of Voigt: 11, 22, 12, or 11, 22, 33, 23, 13, 12. */
static int strain_of(int dim, const int axis[2]) {
    if (axis[0] == axis[1])
        return axis[0];
    return dim == 2 ? 2 : 6 - axis[0] - axis[1];
}

static sp_status find_load(const arguments *a, const cli_file *file, sp_load *load, sp_error *err) {
    const int dim = file->packing.dim, last = a->axis[1];
    *load = (sp_load){.kind = a->kind};
    if (dim == 1)
        return sp_fail(err, SP_EREFUSED, "is a chain: must have two or three dimensions");
    if (last >= dim)
        return sp_fail(err, SP_EINVAL, "%s: axis %c, must be one of the packing's %d",
                       a->kind == SP_LOAD_FORCE ? "--push" : "--strain", axes[last], dim);
    switch (a->kind) {
    case SP_LOAD_FORCE: load->axis = last; return find_grain(a, &file->network, "--push", &load->at, err);
    case SP_LOAD_SWELL: return find_grain(a, &file->network, "--swell", &load->at, err);
    case SP_LOAD_DIPOLE: return find_spring(a, file, &load->at, err);
    case SP_LOAD_STRAIN: load->axis = strain_of(dim, a->axis); break;
    }
    return SP_OK;
}

/* ---- the table --------------------------------------------------------------------------------------------------- */

static bool is_force(const arguments *a) { return a->kind == SP_LOAD_FORCE || a->kind == SP_LOAD_DIPOLE; }

static void grain_rows(const arguments *a, const cli_file *file, const sp_response *r, cli_writer *w) {
    const sp_network *net = &file->network;
    const bool forced = is_force(a);
    cli_motion_columns(net, forced ? "1/(E* d)" : "d", forced ? "1/(E* d^2)" : "", w);
    for (int32_t i = 0; i < net->n && w->status == SP_OK; i++)
        cli_motion_row(net, i, r->u + (int64_t)i * net->dof, w);
}

static void contact_rows(const arguments *a, const cli_file *file, const sp_response *r, cli_writer *w) {
    const sp_network *net = &file->network;
    const char *unit = is_force(a) ? "" : "E* d^2", *amplitude = is_force(a) ? "E* d^2" : "";
    double opens, slides;
    cli_columns(w, SP_COLUMN_INTEGER, "contact", "", "i", "", "j", "", NULL);
    cli_columns(w, SP_COLUMN_NUMBER, "fn", unit, "ft", unit, "opens", amplitude, "slides", amplitude, NULL);
    for (int32_t k = 0; k < net->n_springs && w->status == SP_OK; k++) {
        const sp_spring *s = &net->springs[k];
        sp_response_limits(&file->packing, net, r, k, &opens, &slides);
        cli_put(w, s->contact, net->grain[s->i], s->j < 0 ? s->j : net->grain[s->j], r->fn[k], r->ft[k], opens, slides);
        cli_end_row(w);
    }
}

static sp_status add_rows(void *user, cli_file *file, cli_writer *w) {
    const arguments *a = user;
    sp_load load;
    sp_response r = sp_response_none();
    w->status = find_load(a, file, &load, w->err);
    CLI_THEN(w->status, sp_response_make(&file->network, &load, &r, w->err));
    cli_comment(w, "file = %s", file->path);
    cli_comment(w, "load = %s", a->load);
    cli_motion_comments(file, a->contacts ? "forces" : "response", w);
    cli_value(w, "pressure", file->packing.pressure);
    if (is_force(a))
        cli_value(w, "compliance", 2 * r.work);
    else
        cli_value(w, "work", r.work);
    cli_comment(w, "load_error = %.3g", r.error);
    if (w->status == SP_OK)
        (a->contacts ? contact_rows : grain_rows)(a, file, &r, w);
    sp_response_free(&r);
    return w->status;
}

int cmd_respond(int argc, char **argv) {
    static const cli_files command = {CLI_OF_NETWORK, .tells_network = true, .add = add_rows};
    arguments a = {0};
    cli_parse(&cmd_respond_syntax, argc, argv, &a);
    return cli_run_files(&command, &a);
}
