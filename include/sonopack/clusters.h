#ifndef SONOPACK_CLUSTERS_H
#define SONOPACK_CLUSTERS_H
/* Rigid clusters of a network: grains and contacts that no motion deforms which keeps all contacts. */

#include <sonopack/network.h>

#ifdef __cplusplus
extern "C" {
#endif

/* What a contact holds counts, and not how stiff it is. A contact that sticks holds all components of the motion at the
 * contact (2 bars in 2D, 3 in 3D), one that slides holds the distance alone (1 bar). Each wall is a body. */
typedef enum sp_clusters_method {
    SP_CLUSTERS_GAME = 0, /* the pebble game, which counts bars as if their places were generic: (3,3) with friction
                             (Henkes et al. 2016), (2,3) without (Jacobs and Thorpe 1995). Two dimensions */
    SP_CLUSTERS_MOTIONS   /* the motions of the packing as it is. Walls move but do not turn */
} sp_clusters_method;

typedef struct sp_clusters_options {
    sp_clusters_method method; /* GAME */
    double sliding_at;         /* contacts with |F_t| >= sliding_at x mu F_n slide; 0.99 */
    bool walls;                /* count the contacts with walls, each wall as a body; true */
} sp_clusters_options;
SP_API sp_clusters_options sp_clusters_options_default(void);

/* Clusters have the numbers 0 .. count-1 by falling numbers of grains. */
typedef struct sp_clusters {
    int32_t n, springs; /* grains and contacts of the network */
    int32_t count;      /* clusters */
    int32_t *bars;      /* [springs] of each contact; 0 for walls that are left out */
    int32_t *cluster;   /* [springs] of each contact, or -1. A contact of smooth spheres in space may be the hinge of
                           several: the largest */
    int32_t *redundant; /* [springs] 1: a bar of this contact may be removed and nothing more can move (it is part of
                           an overconstrained region); 0: each of its bars holds a motion that no other holds */
    int32_t *of_grain;  /* [n] the cluster of a grain, or -1. Without friction a grain may belong to several: the
                           largest */
    int32_t *grains;    /* [count] grains of each cluster */
    int32_t *contacts;  /* [count] contacts of each cluster, hinges included */
    int32_t *spans;     /* [count] bit a: it touches both walls across axis a */
    int32_t *wraps;     /* [count] bit a: its contacts lead around the period of axis a */
    int64_t bars_all;   /* number of bars */
    int64_t redundant_bars; /* bars that may be removed together and nothing more can move */
    int64_t floppy;         /* motions that keep all bars, but for those of all as one body: independent ones */
    int32_t free_spins; /* grains that can spin in place: all contacts slide, or, in 3D, two hold it. The game does not
                           see these motions; by MOTIONS such a grain is in no cluster */
    double equal;       /* MOTIONS: the largest difference that counts as none, and ... */
    double apart;       /* the smallest that counts, of random motions. GAME: NAN */
} sp_clusters;
SP_API sp_clusters sp_clusters_none(void);

/* p: the packing of the network. Rattlers are left out; prestress and stiffnesses do not matter. SP_EINVAL for an
 * invalid option. SP_EREFUSED for chains, for the game in 3D, and where rounding does not tell rigid from soft. */
SP_API sp_status sp_clusters_make(const sp_packing *p, const sp_network *net, const sp_clusters_options *opt,
                                  sp_clusters *out, sp_error *err);
SP_API void sp_clusters_free(sp_clusters *c);

#ifdef __cplusplus
}
#endif
#endif
