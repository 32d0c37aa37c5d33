#ifndef SP_AXES_H
#define SP_AXES_H
/* Two axes with ticks, and the map from values to the canvas. */

#include "figure/text.h"

#include <stdbool.h>

enum { TICKS_MAX = 256 };

typedef struct tick {
    double at; /* axis units */
    bool major;
    char label[48]; /* markup, "" if none */
} tick;

/* Positions along an axis are in axis units: log10(value), or value/10^power on a linear axis, so that neither huge nor
 * tiny values overflow. */
typedef struct axis {
    bool log;
    int power;        /* linear: the power of ten taken out of the values */
    double low, high; /* axis units, low < high */
    char label[192];  /* markup */
    double from, to;  /* where low and high are on the canvas [pt] */
    double size;      /* of its letters [pt]; 0: TEXT_LABEL */
    int ticks;
    tick tick[TICKS_MAX];
} axis;

typedef struct axes {
    axis x, y;
    double left, top, width, height; /* the part of the canvas [pt]; width 0: all of it */
    double head;                     /* kept free above the frame [pt] */
    double margin[2];                /* least room left and right of the frame [pt] */
} axes;

/* A linear axis over the finite values of low and high: takes out a power of ten where numbers would be long, and
 * widens an empty range. A logarithmic one over decades: log10 values, at least `least` wide. */
void sp_axis_linear(axis *a, double low, double high);
void sp_axis_log(axis *a, double low, double high, double least);
/* A value in axis units, and axis units on the canvas. */
double sp_axis_unit(const axis *a, double value);
double sp_axis_place(const axis *a, double unit);
/* "name  [10^power unit]", as much of it as there is; unit: markup. */
void sp_axis_name(axis *a, const char *name, const char *unit);

/* Chooses ticks, and margins that hold their labels. */
void sp_axes_layout(axes *a, canvas *c);
/* Frame, ticks on all four sides, labels. */
void sp_axes_draw(const axes *a, canvas *c);

#endif
