#ifndef SP_STORE_EXCHANGE_H
#define SP_STORE_EXCHANGE_H
/* What both text forms of a packing share: rows of contacts, tangential forces as scalars, and checked numbers. */

#include "base/text.h"

#include <sonopack/packing.h>

/* One contact as the text forms list it. */
typedef struct sp_contact_row {
    int32_t i, j; /* in any order; one of them may be a wall */
    double n[3];  /* from i to j */
    double overlap, fn;
    double kn, kt;      /* 0: Hertz's and Mindlin's */
    double ft;          /* 2D: force on i along t = (-ny, nx) */
    double ft3[3];      /* force on i as a vector, if `vector` */
    bool vector;        /* ft3 counts, not ft */
    double unit_within; /* normals whose length differs from 1 by more are refused; those off by more than 1e-9 are
                           normalised */
} sp_contact_row;

/* Turns a row into a contact with i < j, or with a wall as j. If i and j are swapped, n and the force on i change their
 * signs; the scalar in 2D does not, because t turns with n. SP_EFORMAT for indices out of range, for numbers that are
 * not finite, and for normals that are not of unit length. */
sp_status sp_contact_from_row(const sp_packing *p, const sp_contact_row *row, sp_contact *out, sp_error *err);

/* Convert between the scalar Ft of the text files and the vector ft = Ft (-ny, nx). With rounding this map is neither
 * one to one nor onto. Scalar -> vector -> scalar is exact; vector -> scalar -> vector is exact for vectors that are
 * the rounded product. */
double sp_tangent_scalar(const double n[3], const double ft[3]);
void sp_tangent_vector(const double n[3], double scalar, double ft[3]);

/* Moves a coordinate along a periodic axis into [0, period). A coordinate inside remains the same, bit for bit. */
double sp_wrap(double x, double period);

/* Moves a grain that lies outside into the cell along the periodic axes. One inside remains the same, bit for bit. */
void sp_wrap_grain(const sp_packing *p, double x[3]);

/* The cell, or the wall, of this name. False for any other word. */
bool sp_cell_read(const char *word, sp_cell *out);
bool sp_side_read(const char *word, int32_t *wall);

/* Converts words to finite numbers. SP_EFORMAT with the file, the line and the word. name[k] is what word k means. */
sp_status sp_finite_numbers(const sp_lines *at, int count, char *const *word, const char *const *name, double *out,
                            sp_error *err);

#endif
