/* Reads the options of `plot' that change how a figure looks. */
#include "cli/plot_look.h"

#include "base/base.h"
#include "cli/cli.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

plot_look plot_look_default(void) { return (plot_look){.look = sp_plot_look_default()}; }

sp_status plot_look_range(const char *option, const char *text, double limits[2], sp_error *err) {
    const char *colon = strchr(text, ':');
    char low[64];
    if (!colon || strlen(text) < 2 || colon - text >= (ptrdiff_t)sizeof low)
        return sp_fail(err, SP_EINVAL, "%s %.60s: must be LO:HI, LO: or :HI", option, text);
    snprintf(low, sizeof low, "%.*s", (int)(colon - text), text);
    limits[0] = limits[1] = NAN;
    sp_status status = *low ? cli_number(option, low, -DBL_MAX, DBL_MAX, &limits[0], err) : SP_OK;
    if (status == SP_OK && colon[1])
        status = cli_number(option, colon + 1, -DBL_MAX, DBL_MAX, &limits[1], err);
    if (status == SP_OK && limits[0] >= limits[1])
        return sp_fail(err, SP_EINVAL, "%s %.60s: is an empty range, the first limit must be below the second", option,
                       text);
    return status;
}

const char *const plot_look_axes[] = {"x", "y", "xy", NULL};

void plot_look_log(plot_look *p, int axes) {
    if (axes == 0 || axes == 2)
        p->look.x_scale = SP_PLOT_SCALE_LOG;
    if (axes == 1 || axes == 2)
        p->look.y_scale = SP_PLOT_SCALE_LOG;
}

void plot_look_linear(plot_look *p) {
    if (p->look.x_scale == SP_PLOT_SCALE_OWN)
        p->look.x_scale = SP_PLOT_SCALE_LINEAR;
    if (p->look.y_scale == SP_PLOT_SCALE_OWN)
        p->look.y_scale = SP_PLOT_SCALE_LINEAR;
}

sp_status plot_look_label(plot_look *p, const char *text, sp_error *err) {
    if (p->labels == PLOT_LABELS_MAX)
        return sp_fail(err, SP_EINVAL, "--label %.60s: at most %d labels", text, PLOT_LABELS_MAX);
    p->label[p->labels++] = text;
    return SP_OK;
}

sp_status plot_look_check(const plot_look *p, int files, sp_error *err) {
    if (p->labels > 0 && p->labels != files)
        return sp_fail(err, SP_EINVAL, "--label %.60s: %d label%s for %d file%s, must be one for each",
                       p->label[p->labels - 1], p->labels, p->labels == 1 ? "" : "s", files, files == 1 ? "" : "s");
    return SP_OK;
}

bool plot_look_blamed(sp_error *err) {
    static const char mark[] = "look.";
    char reason[sizeof err->text];
    if (strncmp(err->text, mark, strlen(mark)) != 0)
        return false;
    snprintf(reason, sizeof reason, "--%s", err->text + strlen(mark));
    snprintf(err->text, sizeof err->text, "%s", reason);
    return true;
}
