#ifndef SONOPACK_FIGURE_H
#define SONOPACK_FIGURE_H
/* Figures of curves, described by plain structs: panels in rows and columns, each with axes, curves, a legend where it
 * hides nothing, and perhaps an inset. PNG, SVG or PDF by the ending of the path.
 *
 * Texts are markup: |x| is italic, _{x} and ^{x} are lowered and raised. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Dots are small and let each other shine through: clouds of up to millions of points, drawn as an image. */
typedef enum sp_mark {
    SP_MARK_NONE = 0,
    SP_MARK_CIRCLE,
    SP_MARK_SQUARE,
    SP_MARK_TRIANGLE,
    SP_MARK_DIAMOND,
    SP_MARK_DOT
} sp_mark;
typedef enum sp_dash { SP_DASH_SOLID = 0, SP_DASH_DASHED, SP_DASH_DOTTED, SP_DASH_DASH_DOT, SP_DASH_NONE } sp_dash;

typedef struct sp_curve {
    const char *label; /* in the legend; NULL: not there */
    int64_t n;
    const double *x, *y;         /* [n] not finite: a gap */
    const double *error;         /* [n] half lengths of the error bars of y; NULL: none */
    const double *lower, *upper; /* [n] both: the area between them is filled lightly; NULL: none */
    int ink;                     /* 0 black, 1 .. 6 colours that the colour-blind tell apart, -1 grey */
    sp_dash dash;                /* SP_DASH_NONE: marks only */
    sp_mark mark;
    bool open;    /* a mark filled with white */
    bool steps;   /* a histogram: y[k] holds from x[k] to x[k+1], the last value is not drawn */
    double width; /* of the line [pt]; 0: 1 */
} sp_curve;

typedef struct sp_axis {
    const char *label;
    bool log;
    double low, high; /* limits; NAN, or both 0: from the curves. Curves are clipped at limits that are given */
} sp_axis;

typedef struct sp_panel {
    const char *tag; /* as "(a)" in a corner; NULL: none */
    sp_axis x, y;
    int curves;
    const sp_curve *curve;
    bool zero_line;               /* a thin line at y = 0 */
    bool tight;                   /* y never grows for legend or inset */
    const struct sp_panel *inset; /* NULL: none; it takes the corner that hides least */
} sp_panel;

typedef struct sp_sheet {
    const char *title; /* of the document, not drawn */
    int rows, columns;
    const sp_panel *panel; /* [rows x columns], row by row */
    double width;          /* [pt]; 0: one column of a journal (8.6 cm), times the columns */
    double aspect;         /* height of a panel over its width; 0: 0.75 */
} sp_sheet;

/* A point that is not finite is a gap; one that is not positive on a logarithmic axis is SP_EREFUSED, which names the
 * panel, the curve and the point (ends of error bars and bands may be: they reach the foot of the frame). A panel
 * without points needs limits. Where legend or inset find no room among the curves, y grows upwards if its upper limit
 * is not given and the panel is not `tight'; failing that the legend goes above the frame. An inset has no inset. */
SP_API sp_status sp_plot_sheet(const sp_sheet *sheet, const char *path, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
