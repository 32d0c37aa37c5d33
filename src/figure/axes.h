#ifndef SP_AXES_H
#define SP_AXES_H
/* Two axes with ticks, and the map from values to the canvas. */

#include "figure/text.h"

#include <stdbool.h>

enum { TICKS_MAX = 256 };

typedef struct tick {
    double at; /* axis units */
    bool major;
    char label[48]; /* markup; "": no label */
} tick;

/* Positions along an axis are in axis units: log10(value) on a logarithmic axis, value/10^power on a linear one.
 * Neither huge nor tiny values overflow. */
typedef struct axis {
    bool log;
    int power;        /* linear: power of ten taken out of the values */
    double low, high; /* axis units, low < high */
    char label[192];  /* markup */
    double from, to;  /* canvas positions of low and high [pt] */
    double size;      /* size of its letters [pt]; 0: TEXT_LABEL */
    int ticks;
    tick tick[TICKS_MAX];
} axis;

typedef struct axes {
    axis x, y;
    double left, top, width, height; /* part of the canvas [pt]; width 0: all of it */
    double head;                     /* height kept free above the frame [pt] */
    double margin[2];                /* least space left and right of the frame [pt] */
} axes;

/* sp_axis_linear makes an axis over the finite values low to high. It takes out a power of ten if the numbers would be
 * long, and widens an empty range. sp_axis_log makes one from log10 values, at least `least` decades wide. */
void sp_axis_linear(axis *a, double low, double high);
void sp_axis_log(axis *a, double low, double high, double least);
/* A value in axis units; axis units as a position on the canvas [pt]. */
double sp_axis_unit(const axis *a, double value);
double sp_axis_place(const axis *a, double unit);
/* Sets the label "name  [10^power unit]". Parts that do not apply are left out. unit: markup. */
void sp_axis_name(axis *a, const char *name, const char *unit);

/* Chooses ticks, and margins that hold their labels. */
void sp_axes_layout(axes *a, canvas *c);
/* Draws the frame, ticks on all four sides, and labels. */
void sp_axes_draw(const axes *a, canvas *c);

#endif
