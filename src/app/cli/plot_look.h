#ifndef SP_CLI_PLOT_LOOK_H
#define SP_CLI_PLOT_LOOK_H
/* Options of `plot' that change how a figure looks. */

#include <sonopack/figure/look.h>

enum { PLOT_LABELS_MAX = 64 };

typedef struct plot_look {
    sp_plot_look look;
    int labels;
    const char *label[PLOT_LABELS_MAX]; /* of the files, in their order */
} plot_look;

plot_look plot_look_default(void);
/* Limits "LO:HI", "LO:" or ":HI" of an option. */
sp_status plot_look_range(const char *option, const char *text, double limits[2], sp_error *err);
extern const char *const plot_look_axes[]; /* of --log: x, y, xy */
/* Makes these axes logarithmic: an index of plot_look_axes, or < 0 for none. */
void plot_look_log(plot_look *p, int axes);
/* Axes that --log does not name are linear. */
void plot_look_linear(plot_look *p);
sp_status plot_look_label(plot_look *p, const char *text, sp_error *err);
/* Refuses labels that are not as many as the files. */
sp_status plot_look_check(const plot_look *p, int files, sp_error *err);
/* Whether an error is that of the look. Then the reason names the option: "look.x" becomes "--x". */
bool plot_look_blamed(sp_error *err);

#endif
