#ifndef SP_PAPER_REFERENCE_H
#define SP_PAPER_REFERENCE_H
/* Numbers of the paper's tables, and the function that gives our value for each. */

#include "paper/verdict.h"

#include <sonopack/study/study.h>

enum { PAPER_TABLE_1 = 0, PAPER_TABLE_2, PAPER_TABLE_3, PAPER_TABLE_4, PAPER_TABLE_5, PAPER_FIG_1 };
/* The item of figure k = 1 .. 12. */
#define PAPER_FIG(k) (PAPER_FIG_1 + (k)-1)
enum { PAPER_CLAIMS = PAPER_FIG(12) + 1 };

enum { PAPER_PRESSURES = 4 };
extern const double sp_paper_pressure[PAPER_PRESSURES]; /* ascending, as in the scenes */

typedef struct paper_quantity {
    int item;
    const char *name;
    unsigned part; /* SP_WANT_ flags that `ours` requires */
    double (*ours)(const sp_sample *s);
    double mean[PAPER_PRESSURES], sd[PAPER_PRESSURES]; /* sd 0: not given */
    double digit[PAPER_PRESSURES];                     /* unit of the last printed digit of the mean */
} paper_quantity;
extern const paper_quantity sp_paper_quantities[];
extern const int sp_paper_quantity_count;

#endif
