#ifndef SP_PAPER_CLAIMS_H
#define SP_PAPER_CLAIMS_H
/* Claims that the paper makes in words, beside numbers of ours. */

#include "paper/paper.h"

typedef struct paper_claim {
    const char *where;       /* in the paper */
    paper_relation relation; /* what it says of ours */
    double limit, within;    /* within: of PAPER_EQUAL, how near the words mean */
    double p;                /* NAN: of no single pressure */
    int64_t samples;
    const char *note; /* the words, and what was computed */
} paper_claim;

/* ours and its standard error, 0 where it is exact. */
sp_status sp_paper_add_claim(paper *p, const paper_claim *claim, double ours, double ours_err, sp_error *err,
                             const char *quantity, ...) __attribute__((format(printf, 6, 7)));

/* Means of values with their standard errors, one after the other. */
typedef struct paper_sum {
    int64_t n;
    double sum, squares;
} paper_sum;
void sp_paper_sum_add(paper_sum *s, double x);
double sp_paper_sum_mean(const paper_sum *s);
double sp_paper_sum_err(const paper_sum *s); /* NAN for fewer than two */

sp_status sp_paper_claim_speeds(paper *p, sp_error *err);     /* of fronts, Secs. IV C and D */
sp_status sp_paper_claim_margins(paper *p, sp_error *err);    /* layers that are left out, Sec. IV A */
sp_status sp_paper_claim_forces(paper *p, sp_error *err);     /* participation number, Sec. IV A */
sp_status sp_paper_claim_energy(paper *p, sp_error *err);     /* of the first pulse, Eq. (17) */
sp_status sp_paper_claim_lattices(paper *p, sp_error *err);   /* Fig. 8 */
sp_status sp_paper_claim_unequal(paper *p, sp_error *err);    /* lattices of unequal balls, Secs. IV D and VI */
sp_status sp_paper_claim_soft_modes(paper *p, sp_error *err); /* Sec. IV E */
sp_status sp_paper_claim_damping(paper *p, sp_error *err);    /* Fig. 11 */

#endif
