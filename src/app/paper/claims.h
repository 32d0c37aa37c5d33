#ifndef SP_PAPER_CLAIMS_H
#define SP_PAPER_CLAIMS_H
/* Claims that the paper makes in words, with our numbers. */

#include "paper/paper.h"

typedef struct paper_claim {
    const char *where;       /* place in the paper */
    paper_relation relation; /* what the claim states about our value */
    double limit, within;    /* within: tolerance for PAPER_EQUAL */
    double p;                /* NAN: no single pressure */
    int64_t samples;
    const char *note; /* the claim in words, and what was computed */
} paper_claim;

/* Adds a row for a claim. ours_err: standard error of ours, 0 if exact. quantity: printf-style. */
sp_status sp_paper_add_claim(paper *p, const paper_claim *claim, double ours, double ours_err, sp_error *err,
                             const char *quantity, ...) __attribute__((format(printf, 6, 7)));

/* Running sums for means and standard errors. */
typedef struct paper_sum {
    int64_t n;
    double sum, squares;
} paper_sum;
void sp_paper_sum_add(paper_sum *s, double x);
double sp_paper_sum_mean(const paper_sum *s);
double sp_paper_sum_err(const paper_sum *s); /* NAN for fewer than two values */

sp_status sp_paper_claim_speeds(paper *p, sp_error *err);     /* speeds of fronts, Secs. IV C and D */
sp_status sp_paper_claim_margins(paper *p, sp_error *err);    /* layers left out, Sec. IV A */
sp_status sp_paper_claim_forces(paper *p, sp_error *err);     /* participation number, Sec. IV A */
sp_status sp_paper_claim_energy(paper *p, sp_error *err);     /* energy of the first pulse, Eq. (17) */
sp_status sp_paper_claim_lattices(paper *p, sp_error *err);   /* Fig. 8 */
sp_status sp_paper_claim_unequal(paper *p, sp_error *err);    /* lattices of unequal balls, Secs. IV D and VI */
sp_status sp_paper_claim_soft_modes(paper *p, sp_error *err); /* Sec. IV E */
sp_status sp_paper_claim_damping(paper *p, sp_error *err);    /* Fig. 11 */

#endif
