#ifndef SP_RIGID_H
#define SP_RIGID_H
/* What the two ways to find rigid clusters share. */

#include <sonopack/clusters.h>

/* Bodies are the grains 0 .. n-1, then the walls SP_BOTTOM .. SP_BACK. */
enum { SP_RIGID_WALLS = 6 };

/* A contact that belongs to one more cluster. */
typedef struct sp_rigid_member {
    int32_t contact, label;
} sp_rigid_member;

typedef struct sp_rigid {
    const sp_network *net;
    const int32_t *bars;   /* [springs] */
    int32_t used;          /* walls that springs lead to, bit -1-wall; 0 without walls */
    int32_t *label;        /* [springs] out: equal for contacts of one cluster, -1 for none */
    int32_t labels;        /* all labels are below this */
    sp_rigid_member *more; /* [n_more] out: other clusters of a contact; free with sp_free */
    int32_t n_more;
    int32_t *redundant;     /* [springs] out */
    int64_t bars_all, held; /* out: number of bars; of those that hold a motion of their own */
    int64_t floppy;         /* out */
    double equal, apart;    /* out */
} sp_rigid;

/* The other end of a spring as a body. */
static inline int32_t sp_rigid_end(const sp_network *net, const sp_spring *s) {
    return s->j >= 0 ? s->j : net->n - 1 - s->j;
}

static inline int32_t sp_rigid_root(int32_t *up, int32_t i) {
    while (up[i] != i)
        i = up[i] = up[up[i]];
    return i;
}

/* SP_ENOMEM. */
sp_status sp_rigid_game(sp_rigid *r, sp_error *err);
/* SP_EREFUSED where rounding does not tell rigid from soft. */
sp_status sp_rigid_motions(sp_rigid *r, sp_error *err);

#endif
