/* sonopack view: writes one HTML file that shows packings, their modes and the wave in a browser. */
#include "base/base.h"
#include "base/file.h"
#include "cli/cli.h"
#include "cli/output.h"
#include "view/view.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

enum { FILES_MAX = 8 };

typedef struct arguments {
    cli_common common;
    int64_t lowest, frames; /* 0: not given */
    double until;           /* < 0: not given */
    int source;             /* sp_source; -1: not given */
    int64_t first, last;    /* of --modes; last < 0: not given */
    bool no_modes, no_wave;
} arguments;

/* A:B, or a single number. */
static sp_status set_modes(void *user, const char *word, sp_error *err) {
    enum { HIGHEST = 1000000 };
    arguments *a = user;
    char first[32];
    const size_t length = strcspn(word, ":");
    if (length >= sizeof first)
        return sp_fail(err, SP_EINVAL, "--modes %.60s: must be A:B or a number", word);
    memcpy(first, word, length);
    first[length] = '\0';
    sp_status status = cli_integer("--modes", first, 0, HIGHEST, &a->first, err);
    a->last = a->first;
    if (status == SP_OK && word[length])
        status = cli_integer("--modes", word + length + 1, 0, HIGHEST, &a->last, err);
    if (status == SP_OK && a->last < a->first)
        status = sp_fail(err, SP_EINVAL, "--modes %.60s: must not end below its beginning", word);
    return status;
}

static sp_status check(void *user, sp_error *err) {
    const arguments *a = user;
    const bool modes = a->lowest > 0 || a->last >= 0, wave = a->frames > 0 || a->until >= 0 || a->source >= 0;
    const char *path = a->common.output;
    if (a->lowest > 0 && a->last >= 0)
        return sp_fail(err, SP_EINVAL, "--lowest and --modes: must not both be given");
    if (a->no_modes && modes)
        return sp_fail(err, SP_EINVAL, "--no-modes: must not be given with --%s", a->lowest > 0 ? "lowest" : "modes");
    if (a->no_wave && wave)
        return sp_fail(err, SP_EINVAL, "--no-wave: must not be given with --%s",
                       a->frames > 0   ? "frames"
                       : a->until >= 0 ? "until"
                                       : "source");
    if (!path)
        return sp_fail(err, SP_EINVAL, "no -o FILE: must end in .html");
    if (!cli_has_ending(path, ".html") && !cli_has_ending(path, ".htm"))
        return sp_fail(err, SP_EINVAL, "-o %.200s: the ending of a page must be .html", path);
    if (a->common.format_given)
        return sp_fail(err, SP_EINVAL, "--format: applies only to tables");
    return SP_OK;
}

static const cli_option options[] = {
    {"lowest", "K", "Show the K softest modes that are no zero modes (10)", CLI_INTEGER,
     .field = offsetof(arguments, lowest), .low = 1, .high = 1000000},
    {"modes", "A:B", "Show modes A to B, both included; 0 is the softest that is no zero mode", .parse = set_modes},
    {"no-modes", NULL, "Leave the modes out", CLI_FLAG, .field = offsetof(arguments, no_modes)},
    {"frames", "N", "Number of frames of the wave (200, or fewer so that they take less than 12 MB of the page)",
     CLI_INTEGER, .field = offsetof(arguments, frames), .low = 2, .high = VIEW_FRAMES_MAX},
    {"until", "T", "Last time of the wave [d/sqrt(E* / rho)] ((8 H + 40) (p/1e-4)^(-1/6), after the first front)",
     CLI_NUMBER, .field = offsetof(arguments, until), .low = 1e-9, .high = 1e9, .unit = "d/sqrt(E* / rho)"},
    {"source", "KIND", "What the pulse imposes at the bottom wall: impulse, velocity or displacement (impulse)",
     CLI_CHOICE, .field = offsetof(arguments, source), .words = cli_source_names},
    {"no-wave", NULL, "Leave the wave out", CLI_FLAG, .field = offsetof(arguments, no_wave)},
    {0}};

static const cli_syntax syntax = {
    .usage = "FILE... -o PAGE.html",
    .help =
        "Writes one page that any browser with WebGL 2 opens, without a network: packings in two or three dimensions "
        "to turn and to zoom, with force chains, modes that swing, and the wave after a pulse at the bottom wall with "
        "the force on the top wall beside it.\v"
        "In the page the grains are coloured by pressure, contacts, radius, displacement or rotation, and contacts by "
        "force. Keys are listed under \"Keys\" in it; its address leads to what is shown, such as "
        "PAGE.html#mode=3&t=0.5 or PAGE.html#wave&t=80. Several packings are chosen from a list.\n"
        "\n"
        "The wave has N frames, equally spaced, between which the page interpolates. Positions, forces and modes are "
        "rounded to 24 bits and frames to 16 bits of the largest displacement in each, which is enough to look at: "
        "for numbers use `sonopack modes' and `sonopack signal'. If there are no modes or is no wave, the page says "
        "why; it is an error where an option asks for them. With a material the page has a switch for SI units, and "
        "opens in them with --units si. --set takes keys of the groups network and signal.",
    .options = options,
    .file_name = "packing",
    .files_min = 1,
    .files_max = FILES_MAX,
    .springs = true,
    .finds_material = true,
    .check = check};

static sp_status set_options(const arguments *a, const sp_scene *scene, view_options *out, sp_error *err) {
    const bool some = a->last >= 0, lowest = a->lowest > 0;
    if (scene->signal.damping != 0)
        return sp_fail_key(err, SP_EINVAL, "signal.damping", " = %g: must be 0, the frames are without damping",
                           scene->signal.damping);
    *out = (view_options){.network = scene->network,
                          .signal = scene->signal,
                          .modes = !a->no_modes,
                          .wave = !a->no_wave,
                          .need_modes = some || lowest,
                          .need_wave = a->frames > 0 || a->until >= 0 || a->source >= 0,
                          .first = some ? a->first : 0,
                          .last = some ? a->last : (lowest ? a->lowest : VIEW_MODES) - 1,
                          .frames = (int32_t)a->frames};
    out->signal.threads = a->common.threads;
    out->signal.front = false; /* the frames go on after it */
    if (a->until >= 0)
        out->signal.until = a->until;
    if (a->source >= 0)
        out->signal.source = (sp_source)a->source;
    return SP_OK;
}

/* ---- one file after another ------------------------------------------------------------------------------------- */

typedef struct telling {
    const cli_common *common;
    const char *path;
} telling;

static void say_stage(void *user, const char *what) {
    const telling *t = user;
    char text[200];
    snprintf(text, sizeof text, "%.150s: %s", t->path, what);
    cli_progress(t->common, text, -1, NAN);
}

static void say_missing(void *user, const char *reason) {
    const telling *t = user;
    cli_progress_end();
    cli_note(t->common, "%s: left out of the page: %s", t->path, reason);
}

/* The name without its folder. */
static const char *name_of(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

/* The packing, and the options once its material is known: --until may have been given in SI units. */
static sp_status read_file(arguments *a, const sp_scene *scene, const char *path, sp_packing *p, view_options *o,
                           sp_error *err) {
    sp_status status = sp_packing_read(path, p, err); /* names the file */
    if (status == SP_OK)
        status = cli_take_material(a, &p->material, path, err);
    if (status == SP_OK && a->common.material.young > 0)
        p->material = a->common.material;
    return status == SP_OK ? set_options(a, scene, o, err) : status;
}

static sp_status add_file(arguments *a, const sp_scene *scene, const char *path, view_page *page, sp_error *err) {
    telling t = {.common = &a->common, .path = path};
    const view_report report = {.stage = say_stage, .missing = say_missing, .user = &t};
    sp_packing p = sp_packing_none();
    view_options chosen = {0};
    sp_status status = read_file(a, scene, path, &p, &chosen, err);
    if (status == SP_OK) {
        status = view_add(page, name_of(path), &p, &chosen, &report, err);
        cli_progress_end();
        if (status != SP_OK)
            sp_fail_prefix(err, "%s", path);
    }
    sp_packing_free(&p);
    return status;
}

static sp_status write_page(const arguments *a, const view_page *page, sp_error *err) {
    sp_text out = {0};
    char title[300];
    const int more = a->common.files - 1;
    const char *name = name_of(a->common.file[0]);
    if (more > 0)
        snprintf(title, sizeof title, "%.200s and %d more – sonopack", name, more);
    else
        snprintf(title, sizeof title, "%.200s – sonopack", name);
    sp_status status = view_finish(page, title, &out, err);
    if (status == SP_OK)
        status = sp_file_write(a->common.output, out.data, out.size, err);
    if (status == SP_OK)
        cli_debug(&a->common, "%s: %.1f MB", a->common.output, 1e-6 * (double)out.size);
    sp_text_free(&out);
    return status;
}

int cmd_view(int argc, char **argv) {
    arguments a = {.until = -1, .source = -1, .last = -1};
    cli_parse(&syntax, argc, argv, &a);
    sp_error err = {0};
    sp_scene scene = sp_scene_default();
    view_page page = {.si = a.common.units == CLI_UNITS_SI};
    sp_status status = cli_may_write(&a.common, a.common.output, &err);
    if (status == SP_OK)
        status = cli_scene_of_sets(&a.common, "network signal", &scene, &err);
    for (int k = 0; k < a.common.files && status == SP_OK; k++)
        status = add_file(&a, &scene, a.common.file[k], &page, &err);
    if (status == SP_OK)
        status = write_page(&a, &page, &err);
    view_free(&page);
    sp_scene_free(&scene);
    return status == SP_OK ? CLI_OK : cli_fail(&err);
}
