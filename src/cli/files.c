/* Runs commands that read packings, one after another, and print one table. */
#include "cli/files.h"
#include "base/base.h"

#include <math.h>
#include <sonopack/cost.h>
#include <string.h>

static const double lowest = 6, usual = 12; /* heights [d] */

void cli_warn_low_box(const cli_common *common, const sp_pack_spec *spec) {
    const sp_machine machine = sp_machine_reference();
    const double height = sp_packing_expect(spec, 1, &machine).height;
    if (spec->kind != SP_PACK_PISTON || spec->cell == SP_CELL_PERIODIC || spec->dim < 2 || height >= lowest)
        return;
    const double depth = spec->depth > 0 ? spec->depth : spec->width, area = spec->width * (spec->dim == 3 ? depth : 1);
    const double narrow = spec->dim == 3 ? sqrt(area * height / usual) : area * height / usual;
    const double grains = ceil(spec->grains * usual / height / 100) * 100;
    if (narrow >= 4 * fmax(1, spec->diameter_max))
        cli_note(common,
                 "warning: the box will be about %.1f d high, less than %g: sound has no room between the walls; %g d "
                 "need packing.grains = %.0f, or packing.width = %.2g",
                 height, lowest, usual, grains, narrow);
    else
        cli_note(common,
                 "warning: the box will be about %.1f d high, less than %g: sound has no room between the walls; %g d "
                 "need packing.grains = %.0f",
                 height, lowest, usual, grains);
}

static double mean_diameter(const sp_packing *p) {
    double sum = 0;
    for (int32_t i = 0; i < p->n; i++)
        sum += 2 * p->r[i];
    return sum / p->n;
}

void cli_warn_packing(const cli_common *common, const char *path, const sp_packing *p, const sp_network *net) {
    const double height = sp_packing_height(p) / mean_diameter(p);
    if (p->dim < 2)
        return;
    if (2 * net->n < net->n_all)
        cli_note(common, "%s: warning: %d of %d grains are rattlers, which carry nothing: results are those of a few",
                 path, net->rattlers, net->n_all);
    else if (height < lowest && p->cell != SP_CELL_PERIODIC) /* which has no walls that could decide */
        cli_note(common, "%s: warning: the box is %.3g diameters high, less than %g: results are those of the walls",
                 path, height, lowest);
}

sp_status cli_need_walls(const sp_packing *p, const char *what, sp_error *err) {
    if (p->cell != SP_CELL_PERIODIC)
        return SP_OK;
    return sp_fail(
        err, SP_EREFUSED,
        "the cell is periodic and has no walls, between which %s passes: `sonopack signal' sends pulses from "
        "plane to plane (--from plane:Y --detector plane:Z)",
        what);
}

sp_status cli_read_network(const char *path, const sp_network_options *opt, sp_packing *p, sp_network *net,
                           sp_error *err) {
    *p = sp_packing_none();
    *net = sp_network_none();
    sp_status status = sp_packing_read(path, p, err);
    if (status != SP_OK)
        return status;
    status = sp_network_make(p, opt, net, err);
    if (status != SP_OK)
        sp_fail_prefix(err, "%s", path);
    return status;
}

void cli_keep_series(const sp_packing *p, cli_file *file) {
    file->packing.frame = p->frame;
    memcpy(file->packing.strain, p->strain, sizeof p->strain);
}

/* Adds the rows of one file, or to a plan what it would take. */
static sp_status do_file(const cli_files *command, void *arguments, cli_file *f, cli_plan *plan, cli_writer *w) {
    sp_error *err = w->err;
    sp_status status = SP_OK;
    f->packing = sp_packing_none();
    f->network = sp_network_none();
    if (command->contents == CLI_NETWORK)
        status = cli_read_network(f->path, &f->scene->network, &f->packing, &f->network, err);
    else if (command->contents == CLI_PACKING)
        status = sp_packing_read(f->path, &f->packing, err);
    if (command->contents != CLI_PATH)
        CLI_THEN(status, cli_take_material(arguments, &f->packing.material, f->path, err));
    if (status == SP_OK && command->contents == CLI_NETWORK)
        cli_warn_packing(arguments, f->path, &f->packing, &f->network);
    if (status == SP_OK) {
        status = plan ? command->plan(arguments, f, plan, err) : command->add(arguments, f, w);
        /* of a single file SP_EINVAL is about an option, and needs no file name */
        if (status != SP_OK && command->contents != CLI_PATH && !(command->stop && status == SP_EINVAL))
            sp_fail_prefix(err, "%s", f->path);
    }
    f->cut = cli_lacks_series(w->table, &f->packing);
    sp_network_free(&f->network);
    sp_packing_free(&f->packing);
    return status;
}

/* Says which file comes next, unless all goes fast. */
static void tell(const cli_common *common, int next, double begun) {
    const double spent = sp_clock_wall() - begun, share = (double)next / common->files;
    if (next > 0 && spent > 1)
        cli_progress(common, common->file[next], share, spent * (1 - share) / share);
}

static sp_status do_files(const cli_files *command, void *arguments, const sp_scene *scene, cli_plan *plan,
                          cli_writer *w, bool *failed) {
    const cli_common *common = arguments;
    const double begun = sp_clock_wall();
    sp_status status = SP_OK;
    for (int k = 0; k < common->files && !(status != SP_OK && command->stop); k++) {
        tell(common, k, begun);
        cli_file f = {.path = common->file[k], .scene = scene};
        sp_error reason = {0};
        const int64_t rows = w->table->rows;
        status =
            do_file(command, arguments, &f, plan, &(cli_writer){.table = w->table, .err = &reason, .of = &f.packing});
        if (rows > 0 && f.cut)
            cli_note(common, "%s: its frame or strain is left out: the first packing has none; put it in front",
                     f.path);
        if (status != SP_OK && command->stop)
            *w->err = reason;
        else if (status != SP_OK)
            cli_fail(&reason);
        *failed = *failed || f.failed || status != SP_OK;
    }
    cli_progress_end();
    return command->stop ? status : SP_OK;
}

/* What of the network is not as usual. */
static void tell_network(const cli_files *command, const sp_network_options *made, cli_writer *w) {
    const sp_network_options common = sp_network_options_default();
    if (command->contents != CLI_NETWORK || command->tells_network)
        return;
    if (made->prestress)
        cli_comment(w, "prestress = 1");
    if (made->threshold != common.threshold)
        cli_value(w, "threshold", made->threshold);
}

int cli_run_files(const cli_files *command, void *arguments) {
    cli_common *common = arguments;
    sp_scene scene = sp_scene_default();
    sp_table t = sp_table_none();
    sp_error err = {0};
    cli_writer w = {.table = &t, .err = &err};
    cli_plan plan = {.table = sp_table_none()};
    bool failed = false;
    w.status = cli_may_write_table(common, &err);
    CLI_THEN(w.status, cli_scene_of_sets(common, command->groups, &scene, &err));
    if (scene.material.young > 0)
        CLI_THEN(w.status, cli_take_material(arguments, &scene.material, "--set", &err));
    if (common->dry_run)
        CLI_THEN(w.status, cli_plan_begin(common, command->kernels, &plan, &err));
    else if (command->begin)
        CLI_THEN(w.status, command->begin(arguments, &w));
    CLI_THEN(w.status, do_files(command, arguments, &scene, common->dry_run ? &plan : NULL, &w, &failed));
    if (w.status == SP_OK && !common->dry_run)
        tell_network(command, &scene.network, &w);
    if (common->dry_run)
        CLI_THEN(w.status, cli_plan_end(&plan));
    else if (command->end)
        CLI_THEN(w.status, command->end(arguments, &w));
    if (!common->dry_run && (t.rows > 0 || command->stop))
        CLI_THEN(w.status, cli_write_table(common, &t, &err));
    cli_plan_free(&plan);
    sp_table_free(&t);
    sp_scene_free(&scene);
    return w.status != SP_OK ? cli_fail(&err) : failed ? CLI_FAILED : CLI_OK;
}

int cli_run_table(void *arguments, sp_status (*work)(void *arguments, cli_writer *w)) {
    const cli_common *common = arguments;
    sp_table t = sp_table_none();
    sp_error err = {0};
    cli_writer w = {.table = &t, .err = &err, .status = cli_may_write_table(common, &err)};
    CLI_THEN(w.status, work(arguments, &w));
    CLI_THEN(w.status, cli_write_table(common, &t, &err));
    sp_table_free(&t);
    return w.status == SP_OK ? CLI_OK : cli_fail(&err);
}
