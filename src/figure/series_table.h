#ifndef SP_SERIES_TABLE_H
#define SP_SERIES_TABLE_H
/* Tables of fronts against distance, of `sonopack table scaling' and `planes', `chain front' and `front': cut into the
 * groups of rows that belong together. */

#include "figure/markup.h"

#include <sonopack/figure/figure.h>
#include <sonopack/figure/plot.h>

typedef enum quantity {
    Q_DISTANCE = 0,
    Q_T10,
    Q_T_PEAK,
    Q_T_ZERO,
    Q_AMPLITUDE,
    Q_WIDTH,
    Q_GAMMA,
    Q_ALPHA,
    Q_ALPHA_PEAK,
    Q_BETWEEN, /* where the exponents belong: the geometric mean of the ends of their interval */
    QUANTITIES
} quantity;

/* Pressure, width of the box, friction; and the number of grains, which does not cut groups. */
typedef enum group_key { G_PRESSURE = 0, G_WIDTH, G_FRICTION, G_GRAINS, GROUP_KEYS } group_key;

typedef struct front_group {
    int64_t n;
    double key[GROUP_KEYS];          /* what all its rows have; NAN: not in the table, or of several values */
    const double *value[QUANTITIES]; /* [n] NAN: none */
    const double *error[QUANTITIES]; /* [n] NAN: none */
    char label[160];                 /* markup; "" where there is nothing to tell apart */
    bool chain;                      /* distances are in diameters of a chain's balls */
} front_group;

enum { UNIT_ROOM = 64 };

typedef struct front_groups {
    int n;
    front_group *group;
    double *memory;
    char distance_unit[UNIT_ROOM], time_unit[UNIT_ROOM]; /* of all tables; "" where they differ or say none */
} front_groups;

enum { GROUPS_MOST = 24 };

/* SP_EINVAL for tables that are none of these, SP_EREFUSED for values that have no place in a figure. Free in any
 * case. */
sp_status sp_front_groups_read(int tables, const sp_plot_table *table, front_groups *out, sp_error *err);
void sp_front_groups_free(front_groups *g);

/* Colours, marks and dashes that tell groups apart, in grey too. */
int sp_group_ink(const front_groups *g, int k);
sp_mark sp_group_mark(int k);
sp_dash sp_group_dash(int k);

#endif
