/* Rigid clusters: what each contact holds, which grains move as one, and how far that reaches. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/rigid.h"
#include "network/network_cell.h"
#include "network/spins.h"
#include "packing/contact.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

sp_clusters_options sp_clusters_options_default(void) {
    return (sp_clusters_options){.method = SP_CLUSTERS_GAME, .sliding_at = 0.99, .walls = true};
}

sp_clusters sp_clusters_none(void) { return (sp_clusters){0}; }

void sp_clusters_free(sp_clusters *c) {
    sp_free(c->bars);   /* a block with the arrays of contacts */
    sp_free(c->grains); /* and one with those of clusters */
    *c = sp_clusters_none();
}

static sp_status check(const sp_network *net, const sp_clusters_options *opt, sp_error *err) {
    if (opt->method != SP_CLUSTERS_GAME && opt->method != SP_CLUSTERS_MOTIONS)
        return sp_fail(err, SP_EINVAL, "method %d, must be the game or motions", (int)opt->method);
    if (!(opt->sliding_at >= 0 && isfinite(opt->sliding_at)))
        return sp_fail(err, SP_EINVAL, "sliding at %g mu F_n, must be 0 or more", opt->sliding_at);
    if (net->dim == 1)
        return sp_fail(err, SP_EREFUSED, "is a chain: must have two or three dimensions");
    if (net->dim == 3 && opt->method == SP_CLUSTERS_GAME)
        return sp_fail(err, SP_EREFUSED, "the pebble game is exact in two dimensions alone; in three take motions");
    return SP_OK;
}

/* ---- bars -------------------------------------------------------------------------------------------------------- */

static int bars_of(const sp_packing *p, const sp_network *net, const sp_clusters_options *opt, const sp_spring *s) {
    const sp_contact *c = &p->contacts[s->contact];
    if (s->j < 0 && !opt->walls)
        return 0;
    const bool sticks = !contact_smooth(c) && length3(c->ft) < opt->sliding_at * contact_mu(p, c) * c->fn;
    return net->dof > net->dim && sticks ? net->dim : 1;
}

/* A grain can spin in place if all its contacts slide, or, in 3D, about the line through the only two. */
static sp_status count_spins(const sp_network *net, sp_clusters *c, sp_error *err) {
    sp_spin *spin = NULL;
    double axis[3];
    uint8_t *held = sp_alloc((size_t)net->n, 1);
    if (!held)
        return sp_fail_memory(err, (size_t)net->n);
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        held[s->i] = held[s->i] || c->bars[k] > 1;
        if (s->j >= 0)
            held[s->j] = held[s->j] || c->bars[k] > 1;
    }
    const sp_status status = sp_spins_make(net, &spin, err);
    for (int32_t i = 0; i < net->n && status == SP_OK && net->dof > net->dim; i++)
        c->free_spins += !held[i] || (spin && sp_spin_axis(&spin[i], axis));
    sp_free(spin);
    sp_free(held);
    return status;
}

/* ---- one cluster ------------------------------------------------------------------------------------------------- */

/* Grains of a cluster, joined by its contacts, each with the periods that lead to it from the one above it. */
typedef struct walker {
    const sp_network *net;
    sp_rigid *r;
    sp_clusters *c;
    int32_t *by_cluster; /* [springs + more] contacts, sorted by clusters */
    int32_t *up;         /* [n] union-find */
    int32_t (*shift)[3]; /* [n] these periods */
    int32_t *owner;      /* [n] the last cluster that came here */
    int32_t *touches;    /* [n] bit -1-wall: it touches this wall */
    int32_t number;      /* of the cluster */
} walker;

static int32_t find(walker *w, int32_t i) {
    while (w->up[i] != w->up[w->up[i]]) {
        const int32_t above = w->up[i];
        for (int a = 0; a < 3; a++)
            w->shift[i][a] += w->shift[above][a];
        w->up[i] = w->up[above];
    }
    return w->up[i];
}

static void enter(walker *w, int32_t i, int32_t *walls) {
    sp_clusters *c = w->c;
    if (w->owner[i] == w->number)
        return;
    w->owner[i] = w->number;
    w->up[i] = i;
    memset(w->shift[i], 0, sizeof w->shift[i]);
    c->grains[w->number]++;
    *walls |= w->touches[i];
}

/* Joins the grains of a contact. A contact of two that are joined already closes a way around the cell, if its periods
 * are not theirs. */
static void join(walker *w, int32_t k) {
    const sp_spring *s = &w->net->springs[k];
    int32_t step[3], apart[3];
    sp_network_image(w->net, k, step);
    const int32_t i = find(w, s->i), j = find(w, s->j);
    for (int a = 0; a < 3; a++)
        apart[a] = w->shift[s->i][a] + step[a] - w->shift[s->j][a];
    for (int a = 0; a < 3 && i == j; a++)
        if (apart[a] != 0)
            w->c->wraps[w->number] |= 1 << a;
    if (i == j)
        return;
    w->up[j] = i;
    memcpy(w->shift[j], apart, sizeof apart);
}

static void walk(walker *w, int32_t from, int32_t to) {
    int32_t walls = 0;
    for (int32_t q = from; q < to; q++) {
        const sp_spring *s = &w->net->springs[w->by_cluster[q]];
        enter(w, s->i, &walls);
        if (s->j >= 0) {
            enter(w, s->j, &walls);
            join(w, w->by_cluster[q]);
        }
    }
    static const int pair_of[] = {-1, 0, 1}; /* pairs of walls: across the up axis, x and y */
    for (int pair = 0; pair < 3; pair++)
        if ((walls >> 2 * pair & 3) == 3)
            w->c->spans[w->number] |= 1 << (pair_of[pair] < 0 ? w->net->dim - 1 : pair_of[pair]);
    w->c->contacts[w->number] = to - from;
}

/* ---- all clusters ------------------------------------------------------------------------------------------------ */

/* All labels, in turn: those of contacts, then those of contacts in one more cluster. */
static int32_t *label_at(const sp_rigid *r, int32_t q) {
    return q < r->net->n_springs ? &r->label[q] : &r->more[q - r->net->n_springs].label;
}

/* Numbers for labels, by the first contact of each. Returns how many there are, or -1 without memory. */
static int32_t number(const sp_rigid *r) {
    int32_t *name = sp_alloc((size_t)r->labels, sizeof *name), count = 0;
    for (int32_t q = 0; q < r->net->n_springs + r->n_more && name; q++) {
        int32_t *label = label_at(r, q);
        if (*label >= 0) {
            if (name[*label] == 0)
                name[*label] = ++count;
            *label = name[*label] - 1;
        }
    }
    sp_free(name);
    return name ? count : -1;
}

static void sort_contacts(const walker *w, int32_t *start) {
    const int32_t springs = w->c->springs, all = springs + w->r->n_more;
    memset(start, 0, ((size_t)w->c->count + 2) * sizeof *start);
    for (int32_t q = 0; q < all; q++)
        if (*label_at(w->r, q) >= 0)
            start[*label_at(w->r, q) + 2]++;
    for (int32_t q = 2; q < w->c->count + 2; q++)
        start[q] += start[q - 1];
    for (int32_t q = 0; q < all; q++)
        if (*label_at(w->r, q) >= 0)
            w->by_cluster[start[*label_at(w->r, q) + 1]++] = q < springs ? q : w->r->more[q - springs].contact;
}

typedef struct order {
    int32_t grains, contacts, number;
} order;

static int by_size(const void *one, const void *two) {
    const order *a = one, *b = two;
    const int grains = (a->grains < b->grains) - (a->grains > b->grains);
    const int contacts = (a->contacts < b->contacts) - (a->contacts > b->contacts);
    return grains ? grains : contacts ? contacts : (a->number > b->number) - (a->number < b->number);
}

/* Gives each contact the rank of its cluster, of several the first. */
static sp_status rank(const sp_rigid *r, const sp_clusters *c, sp_error *err) {
    order *all = sp_alloc((size_t)c->count, sizeof *all);
    int32_t *place = sp_alloc((size_t)c->count, sizeof *place);
    for (int32_t q = 0; q < c->count && all && place; q++)
        all[q] = (order){c->grains[q], c->contacts[q], q};
    if (all && place)
        qsort(all, (size_t)c->count, sizeof *all, by_size);
    for (int32_t q = 0; q < c->count && all && place; q++)
        place[all[q].number] = q;
    for (int32_t q = 0; q < c->springs + r->n_more && all && place; q++) {
        int32_t *label = label_at(r, q), *first = q < c->springs ? label : &r->label[r->more[q - c->springs].contact];
        const int32_t own = *label < 0 ? -1 : place[*label];
        *label = own > *first || label == first ? own : *first;
        *first = own < *first || label == first ? own : *first;
    }
    sp_free(place);
    sp_free(all);
    return all && place ? SP_OK : sp_fail_memory(err, (size_t)c->count * sizeof(order));
}

static void walk_all(walker *w, int32_t *start) {
    sp_clusters *c = w->c;
    const size_t sizes = 4 * (size_t)c->count * sizeof *c->grains;
    memset(c->grains, 0, sizes); /* and contacts, spans, wraps */
    for (int32_t i = 0; i < c->n; i++)
        w->owner[i] = -1;
    sort_contacts(w, start);
    for (w->number = 0; w->number < c->count; w->number++)
        walk(w, start[w->number], start[w->number + 1]);
}

static sp_status describe(sp_rigid *r, sp_clusters *c, sp_error *err) {
    const sp_network *net = r->net;
    const size_t n = (size_t)net->n, springs = (size_t)net->n_springs, all = springs + (size_t)r->n_more;
    const size_t size = 6 * n + all + (size_t)c->count + 2;
    int32_t *room = sp_alloc(size, sizeof *room);
    if (!room)
        return sp_fail_memory(err, size * sizeof *room);
    walker w = {.net = net, .r = r, .c = c, .up = room, .owner = room + n, .touches = room + 2 * n};
    w.shift = (int32_t(*)[3])(room + 3 * n);
    w.by_cluster = room + 6 * n;
    for (size_t k = 0; k < springs; k++)
        if (net->springs[k].j < 0)
            w.touches[net->springs[k].i] |= 1 << (-1 - net->springs[k].j);
    int32_t *start = w.by_cluster + all;
    walk_all(&w, start);
    const sp_status status = rank(r, c, err);
    if (status == SP_OK)
        walk_all(&w, start);
    for (size_t i = 0; i < n; i++)
        c->of_grain[i] = -1;
    for (size_t k = 0; k < springs; k++)
        for (int end = 0; end < 2 && c->cluster[k] >= 0; end++) {
            const int32_t i = end ? net->springs[k].j : net->springs[k].i, own = c->cluster[k];
            if (i >= 0 && (c->of_grain[i] < 0 || own < c->of_grain[i]))
                c->of_grain[i] = own;
        }
    sp_free(room);
    return status;
}

static sp_status make_arrays(const sp_network *net, sp_clusters *c, sp_error *err) {
    const size_t n = (size_t)net->n, springs = (size_t)net->n_springs, size = n + 3 * springs;
    *c = (sp_clusters){.n = net->n, .springs = net->n_springs};
    c->bars = sp_alloc(size, sizeof *c->bars);
    if (!c->bars)
        return sp_fail_memory(err, size * sizeof *c->bars);
    c->cluster = c->bars + springs;
    c->redundant = c->cluster + springs;
    c->of_grain = c->redundant + springs;
    return SP_OK;
}

static sp_status find_clusters(sp_rigid *r, const sp_clusters_options *opt, sp_clusters *c, sp_error *err) {
    const sp_network *net = r->net;
    for (int32_t k = 0; k < net->n_springs; k++) {
        c->cluster[k] = -1;
        c->bars_all += c->bars[k];
        if (net->springs[k].j < 0 && c->bars[k] > 0)
            r->used |= 1 << (-1 - net->springs[k].j);
    }
    const sp_status status = (opt->method == SP_CLUSTERS_GAME ? sp_rigid_game : sp_rigid_motions)(r, err);
    c->redundant_bars = c->bars_all - r->held;
    c->floppy = r->floppy;
    c->equal = r->equal;
    c->apart = r->apart;
    return status;
}

/* The arrays of clusters. */
static sp_status count_clusters(const sp_rigid *r, sp_clusters *c, sp_error *err) {
    c->count = number(r);
    c->grains = c->count < 0 ? NULL : sp_alloc(4 * (size_t)c->count, sizeof *c->grains);
    if (!c->grains)
        return sp_fail_memory(err, 4 * (size_t)r->labels * sizeof *c->grains);
    c->contacts = c->grains + c->count;
    c->spans = c->contacts + c->count;
    c->wraps = c->spans + c->count;
    return SP_OK;
}

sp_status sp_clusters_make(const sp_packing *p, const sp_network *net, const sp_clusters_options *opt, sp_clusters *out,
                           sp_error *err) {
    sp_clusters c = sp_clusters_none();
    sp_status status = check(net, opt, err);
    if (status == SP_OK)
        status = make_arrays(net, &c, err);
    if (status == SP_OK) {
        for (int32_t k = 0; k < net->n_springs; k++)
            c.bars[k] = bars_of(p, net, opt, &net->springs[k]);
        status = count_spins(net, &c, err);
    }
    sp_rigid r = {.net = net, .bars = c.bars, .label = c.cluster, .redundant = c.redundant, .equal = NAN, .apart = NAN};
    r.labels = net->n + SP_RIGID_WALLS + net->n_springs;
    if (status == SP_OK)
        status = find_clusters(&r, opt, &c, err);
    if (status == SP_OK)
        status = count_clusters(&r, &c, err);
    if (status == SP_OK)
        status = describe(&r, &c, err);
    sp_free(r.more);
    if (status == SP_OK)
        *out = c;
    else
        sp_clusters_free(&c);
    return status;
}
