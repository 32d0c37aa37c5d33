/* The pebble game (Jacobs and Hendrickson 1997) with disks of three degrees of freedom (Henkes et al. 2016), points of
 * two, or both, which finds generic rigidity from counts alone.
 *
 * A vertex has a pebble for each degree of freedom. A pebble that covers a bar is an arrow from its vertex to the other
 * end of the bar; three pebbles that can always be gathered at the ends of a bar are the motions of a plane body. A bar
 * is independent if a fourth pebble can be gathered. If not, all vertices that can be reached along arrows move as one
 * body. They become one vertex, so that no search goes through them again: bodies are merged; points, which may belong
 * to several bodies, keep their place, and both of their pebbles point to the body. Counts stay exact, and the game is
 * nearly linear in the number of contacts. */
#include "base/base.h"
#include "elastic/rigid.h"

enum { FREE = -1, BODY = 3, POINT = 2, FOUR = 4 };

typedef struct game {
    const sp_rigid *r;
    int32_t first_new, count; /* vertices: grains and walls, then bodies made of points */
    int32_t *up;              /* union-find of merged bodies */
    int8_t *size;             /* pebbles of a vertex */
    int32_t (*arrow)[BODY];   /* the far end of each pebble, or FREE */
    int32_t *seen;            /* number of the last search that came here */
    int32_t *from;            /* where that search came from */
    int32_t *queue;           /* what that search has found */
    int32_t found, searches;
    int32_t *start, *touch; /* contacts of each vertex */
} game;

static int32_t root(game *g, int32_t v) { return sp_rigid_root(g->up, v); }

static int spare(const game *g, int32_t v) {
    int count = 0;
    for (int k = 0; k < g->size[v]; k++)
        count += g->arrow[v][k] == FREE;
    return count;
}

/* Replaces one arrow of v, to `old`, by another. */
static void turn(game *g, int32_t v, int32_t old, int32_t new) {
    for (int k = 0; k < g->size[v]; k++)
        if (g->arrow[v][k] == old || (g->arrow[v][k] != FREE && root(g, g->arrow[v][k]) == old)) {
            g->arrow[v][k] = new;
            return;
        }
}

static void visit(game *g, int32_t v, int32_t from) {
    if (g->seen[v] == g->searches)
        return;
    g->seen[v] = g->searches;
    g->from[v] = from;
    g->queue[g->found++] = v;
}

static void begin_search(game *g) {
    g->searches++;
    g->found = 0;
}

static void follow(game *g, int32_t v) {
    for (int k = 0; k < g->size[v]; k++)
        if (g->arrow[v][k] != FREE)
            visit(g, root(g, g->arrow[v][k]), v);
}

/* Brings a free pebble of any vertex but i and j to i. */
static bool fetch(game *g, int32_t i, int32_t j) {
    begin_search(g);
    visit(g, i, FREE);
    for (int32_t k = 0; k < g->found; k++) {
        int32_t v = g->queue[k];
        if (v != i && v != j && spare(g, v) > 0) {
            for (int32_t old = FREE; v != i; v = g->from[v]) {
                turn(g, v, old, g->from[v]);
                old = v;
                if (g->from[v] == i)
                    turn(g, i, v, FREE);
            }
            return true;
        }
        follow(g, v);
    }
    return false;
}

/* Whether four pebbles can be gathered at i and j. */
static bool gather(game *g, int32_t i, int32_t j) {
    while (spare(g, i) + spare(g, j) < FOUR)
        if (!(spare(g, i) < g->size[i] && fetch(g, i, j)) && !(spare(g, j) < g->size[j] && fetch(g, j, i)))
            return false;
    return true;
}

/* Makes one body of all that can be reached from i and j, which have the only three pebbles there. Returns it. */
static int32_t merge(game *g, int32_t i, int32_t j) {
    int32_t body = FREE;
    begin_search(g);
    visit(g, i, FREE);
    visit(g, j, FREE);
    for (int32_t k = 0; k < g->found; k++)
        follow(g, g->queue[k]);
    for (int32_t k = 0; k < g->found && body == FREE; k++)
        if (g->size[g->queue[k]] == BODY)
            body = g->queue[k];
    if (body == FREE) {
        body = g->count++;
        g->up[body] = body;
        g->size[body] = BODY;
    }
    for (int32_t k = 0; k < g->found; k++) {
        const int32_t v = g->queue[k];
        if (g->size[v] == BODY)
            g->up[v] = body;
        for (int q = 0; q < POINT && g->size[v] == POINT; q++)
            g->arrow[v][q] = body;
    }
    for (int q = 0; q < BODY; q++)
        g->arrow[body][q] = FREE;
    return body;
}

/* The contacts of points within what was merged last. */
static void mark_redundant(game *g) {
    const sp_network *net = g->r->net;
    for (int32_t k = 0; k < g->found; k++) {
        const int32_t v = g->queue[k];
        if (g->size[v] == BODY)
            continue;
        for (int32_t q = g->start[v]; q < g->start[v + 1]; q++) {
            const sp_spring *s = &net->springs[g->touch[q]];
            const int32_t end = sp_rigid_end(net, s), other = s->i == v ? end : s->i;
            if (g->seen[g->size[other] == BODY ? root(g, other) : other] == g->searches)
                g->r->redundant[g->touch[q]] = 1;
        }
    }
}

static int64_t place_bars(game *g, int32_t contact) {
    const sp_spring *s = &g->r->net->springs[contact];
    int64_t held = 0;
    for (int32_t bar = 0; bar < g->r->bars[contact]; bar++) {
        const int32_t i = root(g, s->i), j = root(g, sp_rigid_end(g->r->net, s));
        if (i != j && gather(g, i, j)) {
            const bool at_i = spare(g, i) > 0;
            turn(g, at_i ? i : j, FREE, at_i ? j : i);
            held++;
        } else {
            g->r->redundant[contact] = 1;
            if (i != j) {
                g->seen[merge(g, i, j)] = g->searches;
                mark_redundant(g);
            }
        }
    }
    return held;
}

static bool of_bodies(const game *g, const sp_spring *s) {
    return g->size[s->i] == BODY && g->size[sp_rigid_end(g->r->net, s)] == BODY;
}

/* The bodies of contacts that meet at a point are one if a bar between them would be redundant. */
static void merge_at_points(game *g) {
    const int32_t *label = g->r->label;
    for (int32_t v = 0; v < g->first_new; v++)
        for (int32_t a = g->start[v]; g->size[v] == POINT && a < g->start[v + 1]; a++)
            for (int32_t b = a + 1; b < g->start[v + 1] && label[g->touch[a]] >= 0; b++) {
                const int32_t one = root(g, label[g->touch[a]]);
                const int32_t two = label[g->touch[b]] >= 0 ? root(g, label[g->touch[b]]) : one;
                if (one != two && !gather(g, one, two))
                    merge(g, one, two);
            }
}

/* A contact is in a cluster if a further bar between its ends would be redundant. */
static void find_clusters(game *g) {
    const sp_network *net = g->r->net;
    int32_t *label = g->r->label;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const int32_t i = root(g, net->springs[k].i), j = root(g, sp_rigid_end(net, &net->springs[k]));
        if (g->r->bars[k] > 0 && i == j && g->size[i] == BODY)
            label[k] = i;
        else if (g->r->bars[k] > 0 && i != j && !gather(g, i, j))
            label[k] = merge(g, i, j);
    }
    merge_at_points(g);
    for (int32_t k = 0; k < net->n_springs; k++)
        if (label[k] >= 0)
            label[k] = root(g, label[k]);
}

/* What is redundant between bodies: all within those that redundant bars made. */
static void finish_redundant(game *g) {
    const sp_network *net = g->r->net;
    for (int32_t k = 0; k < net->n_springs; k++)
        if (g->r->bars[k] > 0 && of_bodies(g, &net->springs[k]))
            g->r->redundant[k] = root(g, net->springs[k].i) == root(g, sp_rigid_end(net, &net->springs[k]));
}

static void list_contacts(game *g) {
    const sp_network *net = g->r->net;
    for (int32_t k = 0; k < net->n_springs; k++) {
        g->start[net->springs[k].i + 2]++;
        g->start[sp_rigid_end(net, &net->springs[k]) + 2]++;
    }
    for (int32_t v = 2; v < g->first_new + 2; v++)
        g->start[v] += g->start[v - 1];
    for (int32_t k = 0; k < net->n_springs; k++) { /* start[v + 1] moves to the end of v */
        g->touch[g->start[net->springs[k].i + 1]++] = k;
        g->touch[g->start[sp_rigid_end(net, &net->springs[k]) + 1]++] = k;
    }
}

static sp_status make_game(const sp_rigid *r, game *g, sp_error *err) {
    const sp_network *net = r->net;
    const size_t vertices = (size_t)net->n + SP_RIGID_WALLS, most = vertices + (size_t)net->n_springs;
    *g = (game){.r = r, .first_new = (int32_t)vertices, .count = (int32_t)vertices};
    g->up = sp_alloc(most, sizeof *g->up);
    g->size = sp_alloc(most, sizeof *g->size);
    g->arrow = sp_alloc(most, sizeof *g->arrow);
    g->seen = sp_alloc(most, sizeof *g->seen);
    g->from = sp_alloc(most, sizeof *g->from);
    g->queue = sp_alloc(most, sizeof *g->queue);
    g->start = sp_alloc(vertices + 2, sizeof *g->start);
    g->touch = sp_alloc(2 * (size_t)net->n_springs, sizeof *g->touch);
    if (!g->up || !g->size || !g->arrow || !g->seen || !g->from || !g->queue || !g->start || !g->touch)
        return sp_fail_memory(err, most * 36);
    for (int32_t v = 0; v < g->first_new; v++) {
        g->up[v] = v;
        g->size[v] = v >= net->n || net->dof > net->dim ? BODY : POINT;
        for (int k = 0; k < BODY; k++)
            g->arrow[v][k] = FREE;
    }
    list_contacts(g);
    return SP_OK;
}

static void game_free(game *g) {
    sp_free(g->up);
    sp_free(g->size);
    sp_free(g->arrow);
    sp_free(g->seen);
    sp_free(g->from);
    sp_free(g->queue);
    sp_free(g->start);
    sp_free(g->touch);
}

sp_status sp_rigid_game(sp_rigid *r, sp_error *err) {
    const sp_network *net = r->net;
    game g;
    sp_status status = make_game(r, &g, err);
    if (status == SP_OK) {
        for (int32_t k = 0; k < net->n_springs; k++)
            r->held += place_bars(&g, k);
        finish_redundant(&g);
        find_clusters(&g);
        r->floppy = (int64_t)net->n * (net->dof > net->dim ? BODY : POINT) - r->held - BODY;
        for (int k = 0; k < SP_RIGID_WALLS; k++)
            r->floppy += r->used >> k & 1 ? BODY : 0;
    }
    game_free(&g);
    return status;
}
