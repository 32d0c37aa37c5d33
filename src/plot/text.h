#ifndef SP_PLOT_TEXT_H
#define SP_PLOT_TEXT_H
/* Lettering. Markup: |c| italic, _{tof} subscript, ^{-4} superscript, a backslash in front of any sign takes it as it
 * is. No letter is smaller than 7 pt. */

#include "plot/canvas.h"

/* Sizes in points: tick and axis labels, legends, and what is raised or lowered. */
#define TEXT_LABEL  9.0
#define TEXT_LEGEND 8.0
#define TEXT_SCRIPT 7.0

/* The minus sign of print, in UTF-8. */
#define MINUS "\xe2\x88\x92"

typedef struct text_style {
    double size;   /* pt */
    double across; /* 0: x is the left end, 0.5: the middle, 1: the right end */
    double up;     /* 0: y is the baseline, 0.5: the middle of a capital, 1: its top */
    double angle;  /* anticlockwise, radians */
} text_style;

double text_width(canvas *c, const char *markup, double size);
void text_draw(canvas *c, const char *markup, double x, double y, text_style style);

/* A user's text (a file name, say) as markup: signs escaped, what is not valid UTF-8 replaced by "?", control
 * characters by spaces, and more than `most` characters shortened in the middle. */
void text_escape(char *out, size_t size, const char *raw, int most);
/* value as markup, a x 10^b where that is shorter to read. */
void text_number(char *out, size_t size, double value, int digits);
/* value(error in its last digits), 0.166(4); without the error where it is not a positive number. */
void text_measured(char *out, size_t size, double value, double error);

#endif
