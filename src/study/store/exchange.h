#ifndef SP_STORE_EXCHANGE_H
#define SP_STORE_EXCHANGE_H
/* What the text forms of a packing share: how grains and contacts of a file become those of a packing. */

#include "base/text.h"

#include <sonopack/packing.h>

/* Numbers of one contact as the text forms list them. */
typedef struct sp_contact_row {
    int32_t i, j; /* in either order; one of them may be a wall */
    double n[3];  /* from i to j */
    double overlap, fn;
    double ft;          /* 2D: along t = (-ny, nx), on i */
    double ft3[3];      /* the vector on i, if `vector` */
    bool vector;        /* ft3 is meant (3D) */
    double unit_within; /* normals off unit length by more are refused; if above 1e-9, they are made unit */
} sp_contact_row;

/* Turns the row into a contact with i < j or j a wall: i and j change places, and n and the force on i their signs. In
 * 2D the scalar is the same on either side, since t turns with n. SP_EFORMAT for indices out of range, for numbers that
 * are not finite, and for normals off unit length. */
sp_status sp_contact_from_row(const sp_packing *p, const sp_contact_row *row, sp_contact *out, sp_error *err);

/* Ft of the text files from the vector and back, ft = Ft (-ny, nx). Rounding makes this map neither one to one nor
 * onto; these two are chosen so that scalar -> vector -> scalar is exact, and vector -> scalar -> vector is exact for
 * vectors that are the rounded product. */
double sp_tangent_scalar(const double n[3], const double ft[3]);
void sp_tangent_vector(const double n[3], double scalar, double ft[3]);

/* A coordinate along a periodic axis into [0, period); one that is inside stays as it is, bit for bit. */
double sp_wrap(double x, double period);

/* words -> finite numbers; SP_EFORMAT names the file, line and word. names: what the words are, for the message. */
sp_status sp_finite_numbers(const sp_lines *at, int count, char *const *word, const char *const *name, double *out,
                            sp_error *err);

#endif
