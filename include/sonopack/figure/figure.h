#ifndef SONOPACK_FIGURE_H
#define SONOPACK_FIGURE_H
/* Figures of curves, described by plain structs: panels in rows and columns, each with axes, curves, a legend placed
 * where it hides no data, and an optional inset. The ending of the path selects PNG, SVG or PDF. Texts are markup: |x|
 * is italic, _{x} subscript, ^{x} superscript. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* SP_MARK_DOT is small and translucent, for clouds of up to millions of points. Dots are drawn as an image. */
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
    const char *label; /* legend entry; NULL: none */
    int64_t n;
    const double *x, *y;         /* [n] a point that is not finite makes a gap */
    const double *error;         /* [n] standard errors of y, drawn as bars on both sides; NULL: none */
    const double *lower, *upper; /* [n] edges of a light band, both or none; NULL: none */
    int ink;                     /* 0: black, 1 to 6: colours that colour-blind readers can distinguish, -1: grey */
    sp_dash dash;                /* SP_DASH_NONE: marks without a line */
    sp_mark mark;
    bool open;                        /* marks are filled with white */
    bool steps;                       /* histogram: y[k] holds from x[k] to x[k+1]; the last y is not drawn */
    double width;                     /* line width [pt]; 0: 1 */
    const double *bar_low, *bar_high; /* [n] ends of bars, both or none, instead of `error'; NAN: no bar */
} sp_curve;

typedef struct sp_axis {
    const char *label;
    bool log;
    double low, high; /* limits; NAN, or both 0: from the curves. Given limits clip the curves */
} sp_axis;

typedef struct sp_panel {
    const char *tag; /* shown in a corner, such as "(a)"; NULL: none */
    sp_axis x, y;
    int curves;
    const sp_curve *curve;
    bool zero_line;               /* draw a thin line at y = 0 */
    bool tight;                   /* the y axis is not extended for legend or inset */
    const struct sp_panel *inset; /* NULL: none. It takes the place where it hides least */
} sp_panel;

typedef struct sp_sheet {
    const char *title; /* title of the document, not drawn */
    int rows, columns;
    const sp_panel *panel; /* [rows][columns] */
    double width;          /* width [pt]; 0: 8.6 cm (one journal column) per column of panels */
    double aspect;         /* height of a panel divided by its width; 0: 0.75 */
} sp_sheet;

/* Draws a sheet of panels to a file. If legend or inset find no free place, the y axis is extended upwards, unless its
 * upper limit is given or the panel is `tight'. If that does not help, the legend goes above the frame. SP_EINVAL for
 * invalid structs, such as an inset within an inset. SP_EREFUSED for a panel without points and limits, and for a point
 * that is not positive on a logarithmic axis; the message names panel, curve and point. Ends of error bars and bands
 * may be zero or negative: they extend to the lower edge of the frame. SP_EIO if the file cannot be written. */
SP_API sp_status sp_plot_sheet(const sp_sheet *sheet, const char *path, sp_error *err);

#ifdef __cplusplus
}
#endif
#endif
