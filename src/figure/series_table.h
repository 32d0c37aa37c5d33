#ifndef SP_SERIES_TABLE_H
#define SP_SERIES_TABLE_H
/* Tables of fronts against distance, from `sonopack table scaling' and `planes', `chain front' and `front', divided
 * into groups of rows. */

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
    Q_BETWEEN, /* distance of the exponents: geometric mean of the ends of their interval */
    QUANTITIES
} quantity;

/* What a group has in common. Rows that differ only in the number of grains belong to the same group. */
typedef enum group_key { G_PRESSURE = 0, G_WIDTH, G_FRICTION, G_GRAINS, GROUP_KEYS } group_key;

typedef struct front_group {
    int64_t n;
    double key[GROUP_KEYS];          /* common value of the rows; NAN: not in the table, or several values */
    const double *value[QUANTITIES]; /* [n] NAN: none */
    const double *error[QUANTITIES]; /* [n] NAN: none */
    char label[160];                 /* markup; "" for a single group */
    char file[96];                   /* the file of its rows, as markup; "" if the table does not name it */
    bool chain;                      /* distances are numbers of grains of a chain */
} front_group;

typedef struct front_groups {
    int n;
    front_group *group;
    double *memory;
    /* common units of all tables; "" if they have none */
    const char *distance_unit, *time_unit, *amplitude_unit, *width_unit, *pressure_unit;
    bool chain, mixed; /* all tables are of chains, whose distances are numbers of grains; only some of them are */
} front_groups;

enum { GROUPS_MOST = 24 };

/* Reads the groups. SP_EINVAL for tables of other kinds, SP_EREFUSED for values that a figure cannot show. Call
 * sp_front_groups_free after failure too. */
sp_status sp_front_groups_read(int tables, const sp_plot_table *table, front_groups *out, sp_error *err);
void sp_front_groups_free(front_groups *g);

/* Inks, marks and dashes of the groups. Groups differ in grey too. */
int sp_group_ink(const front_groups *g, int k);
sp_mark sp_group_mark(int k);
sp_dash sp_group_dash(int k);

#endif
