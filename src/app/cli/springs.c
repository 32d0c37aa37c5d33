#include "cli/springs.h"

#include "base/base.h"

#include <string.h>

enum { KEY_THRESHOLD = 0x3000, KEY_PRESTRESS };

static const struct argp_option options[] = {
    {"threshold", KEY_THRESHOLD, "F", 0, "Contacts with a normal force above F p d^2 carry (1e-4)", 50},
    {"prestress", KEY_PRESTRESS, NULL, 0, "Add what the forces at rest do as contacts turn", 50},
    {0}};

static error_t parse(int key, char *arg, struct argp_state *state) {
    cli_springs *s = state->input;
    sp_error err;
    switch (key) {
    case ARGP_KEY_INIT: s->threshold = -1; return 0;
    case KEY_PRESTRESS: s->prestress = true; return 0;
    case KEY_THRESHOLD:
        if (cli_number("--threshold", arg, 0, 1, &s->threshold, &err) != SP_OK)
            argp_error(state, "%s", err.text);
        return 0;
    default: return ARGP_ERR_UNKNOWN;
    }
}

const struct argp cli_springs_argp = {options, parse, NULL, NULL, NULL, NULL, NULL};

sp_status cli_springs_scene(const cli_common *common, const cli_springs *springs, const char *groups, sp_scene *out,
                            sp_error *err) {
    sp_status status = cli_scene_of_sets(common, groups, out, err);
    if (status != SP_OK)
        return status;
    if (springs->threshold >= 0)
        out->network.threshold = springs->threshold;
    if (springs->prestress)
        out->network.prestress = true;
    return SP_OK;
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

static const char *const sources[] = {
    [SP_SOURCE_IMPULSE] = "impulse", [SP_SOURCE_VELOCITY] = "velocity", [SP_SOURCE_DISPLACEMENT] = "displacement"};
enum { SOURCES = sizeof sources / sizeof *sources };

const char *cli_source_name(sp_source source) { return sources[source]; }

bool cli_source_of(const char *word, sp_source *out) {
    for (int k = 0; k < SOURCES; k++)
        if (strcmp(word, sources[k]) == 0) {
            *out = (sp_source)k;
            return true;
        }
    return false;
}
