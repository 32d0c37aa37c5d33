/* Nested dissection of a network: pieces, the directions in which they are split, and largest flows as separators. */
#include "linalg/dissection.h"

#include "base/base.h"

#include <math.h>
#include <string.h>

enum {
    LEAF = 100,   /* grains of a piece that is not split any more */
    NONE = -1,    /* no grain */
    OUTSIDE = -2, /* in place of a grain: where the flow comes from, or goes to */
    BINS = 64,
    DIRECTIONS = 13
};
typedef enum end { MIDDLE, SOURCE, SINK } end;
typedef enum side { FIRST, SECOND, SEPARATOR, SIDES } side;

/* The smaller end has this part of a piece at least, so that pieces of pieces are not many. */
static const double LEAST_END = 0.1;

/* A flow enters a grain at its state 2k and leaves it at 2k + 1; there is room for one unit in between. */
typedef struct dissection {
    const sp_network *net;
    int64_t *at;        /* [n + 1] */
    int32_t *neighbour; /* [at[n]] grains that touch a grain */
    double *x;          /* [n][dim] centres; of axes that go round a period: over the period */
    bool wraps[3];
    int32_t *node;           /* [n] the grains, piece by piece */
    int32_t *piece;          /* [n] the piece of a grain */
    int32_t *part, parts;    /* the result */
    int32_t *before, *after; /* [n] where the unit of a grain comes from, and goes to */
    int32_t *level, *queue;  /* [2 n] of states: distance from the source; list or stack */
    int64_t *arc;            /* [n] the neighbour to be tried next */
    double *key, *sorted;    /* [n] places along a direction */
    unsigned char *end, *side, *best;
    int32_t pieces;
} dissection;

/* A piece: `n` grains of the list. */
typedef struct piece {
    int32_t *node, n, id;
} piece;

/* ---- largest flow ------------------------------------------------------------------------------------------------ */

static void reach(dissection *d, int32_t state, int32_t level, int32_t *tail) {
    if (d->level[state] >= 0)
        return;
    d->level[state] = level;
    d->queue[(*tail)++] = state;
}

/* Whether the flow can go on from one grain into another. */
static bool leads(const dissection *d, const piece *of, int32_t from, int32_t to) {
    return d->piece[to] == of->id && d->after[from] != to && d->end[to] != SOURCE;
}

/* Distances from the source along which more can flow. False if the sink cannot be reached any more; then all states
 * that the source reaches have a distance, and no others. */
static bool find_levels(dissection *d, const piece *of) {
    int32_t tail = 0, last = INT32_MAX;
    for (int32_t k = 0; k < of->n; k++)
        d->level[2 * of->node[k]] = d->level[2 * of->node[k] + 1] = NONE;
    for (int32_t k = 0; k < of->n; k++)
        if (d->end[of->node[k]] == SOURCE && d->before[of->node[k]] == NONE)
            reach(d, 2 * of->node[k], 0, &tail);
    for (int32_t head = 0; head < tail && d->level[d->queue[head]] < last; head++) {
        const int32_t state = d->queue[head], v = state / 2, level = d->level[state] + 1;
        const bool used = d->before[v] != NONE;
        if (state % 2 == 0) { /* through an empty grain; or the unit that was there comes another way */
            if (!used || d->before[v] >= 0)
                reach(d, used ? 2 * d->before[v] + 1 : state + 1, level, &tail);
            continue;
        }
        if (d->end[v] == SINK && d->after[v] != OUTSIDE) {
            last = level - 1;
            continue;
        }
        if (used)
            reach(d, state - 1, level, &tail);
        for (int64_t q = d->at[v]; q < d->at[v + 1]; q++)
            if (leads(d, of, v, d->neighbour[q]))
                reach(d, 2 * d->neighbour[q], level, &tail);
    }
    return last < INT32_MAX;
}

/* The next state after this one on a shortest way; NONE if there is no way left. */
static int32_t next_state(dissection *d, const piece *of, int32_t state) {
    const int32_t v = state / 2, level = d->level[state] + 1;
    const bool used = d->before[v] != NONE;
    if (state % 2 == 0) {
        const int32_t to = !used ? state + 1 : d->before[v] >= 0 ? 2 * d->before[v] + 1 : NONE;
        return to >= 0 && d->level[to] == level ? to : NONE;
    }
    if (used && d->level[state - 1] == level)
        return state - 1;
    for (; d->arc[v] < d->at[v + 1]; d->arc[v]++) {
        const int32_t to = d->neighbour[d->arc[v]];
        if (leads(d, of, v, to) && d->level[2 * to] == level)
            return 2 * to;
    }
    return NONE;
}

/* Sends one more unit along these states: takes back what it cancels, then notes what it adds. */
static void send(dissection *d, const int32_t *state, int32_t count) {
    for (int32_t k = 0; k + 1 < count; k++)
        if (state[k] % 2 == 1 && state[k + 1] == state[k] - 1) /* nothing flows through this grain any more */
            d->before[state[k] / 2] = d->after[state[k] / 2] = NONE;
    for (int32_t k = 0; k + 1 < count; k++)
        if (state[k] % 2 == 1 && state[k + 1] % 2 == 0 && state[k + 1] != state[k] - 1) {
            d->after[state[k] / 2] = state[k + 1] / 2;
            d->before[state[k + 1] / 2] = state[k] / 2;
        }
    d->before[state[0] / 2] = OUTSIDE;
    d->after[state[count - 1] / 2] = OUTSIDE;
}

/* Looks for a shortest way from an empty grain of the source to the sink. */
static bool augment(dissection *d, const piece *of, int32_t start) {
    int32_t *stack = d->queue, count = 0;
    stack[count++] = 2 * start;
    while (count > 0) {
        const int32_t state = stack[count - 1], v = state / 2;
        if (state % 2 == 1 && d->end[v] == SINK && d->after[v] != OUTSIDE)
            break;
        const int32_t next = next_state(d, of, state);
        if (next != NONE)
            stack[count++] = next;
        else
            d->level[stack[--count]] = NONE;
    }
    for (int32_t k = 0; k < count; k++) /* no other way of this round may use them */
        d->level[stack[k]] = NONE;
    if (count > 0)
        send(d, stack, count);
    return count > 0;
}

/* Dinic's method. Then the grains whose entry the source reaches, but not their exit, are the smallest separator. */
static void separate(dissection *d, const piece *of, int32_t count[SIDES]) {
    for (int32_t k = 0; k < of->n; k++)
        d->before[of->node[k]] = d->after[of->node[k]] = NONE;
    while (find_levels(d, of)) {
        for (int32_t k = 0; k < of->n; k++)
            d->arc[of->node[k]] = d->at[of->node[k]];
        for (int32_t k = 0; k < of->n; k++) {
            const int32_t v = of->node[k];
            if (d->end[v] == SOURCE && d->before[v] == NONE)
                augment(d, of, v);
        }
    }
    count[FIRST] = count[SECOND] = count[SEPARATOR] = 0;
    for (int32_t k = 0; k < of->n; k++) {
        const int32_t v = of->node[k];
        const bool in = d->end[v] == SOURCE || d->level[2 * v] >= 0, out = d->level[2 * v + 1] >= 0;
        d->side[v] = in && !out ? SEPARATOR : out ? FIRST : SECOND;
        count[d->side[v]]++;
    }
}

/* ---- ends -------------------------------------------------------------------------------------------------------- */

/* The number at place k of the first n of d->sorted, were they sorted (Hoare's selection). */
static double select(dissection *d, int32_t n, int32_t k) {
    int32_t low = 0, high = n - 1;
    double *x = d->sorted;
    while (low < high) {
        const double pivot = x[low + (high - low) / 2];
        int32_t i = low, j = high;
        while (i <= j) {
            while (x[i] < pivot)
                i++;
            while (x[j] > pivot)
                j--;
            if (i <= j) {
                const double swap = x[i];
                x[i++] = x[j];
                x[j--] = swap;
            }
        }
        if (k <= j)
            high = j;
        else if (k >= i)
            low = i;
        else
            break;
    }
    return x[k];
}

/* Where the piece has a gap along an axis that wraps, coordinates begin there; else it goes round. */
static bool goes_round(const dissection *d, const piece *of, int axis, double *begin) {
    const int dim = d->net->dim;
    bool there[BINS] = {false};
    for (int32_t k = 0; k < of->n; k++)
        there[(int)(d->x[of->node[k] * dim + axis] * BINS) % BINS] = true;
    int run = 0, longest = 0;
    for (int b = 0; b < 2 * BINS; b++) {
        run = there[b % BINS] ? 0 : run + 1;
        if (run > longest) {
            longest = run;
            *begin = (double)((b + 1) % BINS) / BINS;
        }
    }
    return longest <= BINS / 8;
}

static void set_keys(dissection *d, const piece *of, const int *direction, const double *begin) {
    const int dim = d->net->dim;
    for (int32_t k = 0; k < of->n; k++) {
        double sum = 0;
        for (int a = 0; a < dim; a++) {
            const double x = d->x[of->node[k] * dim + a] - begin[a];
            sum += direction[a] * (d->wraps[a] ? (x - floor(x)) * d->net->box[a] : x);
        }
        d->key[of->node[k]] = d->sorted[k] = sum;
    }
}

/* The first and last two fifths along the keys; of a piece that goes round, quarters less a tenth, opposite to each
 * other. */
static void set_ends(dissection *d, const piece *of, bool round) {
    const double line[] = {-1, 0.4, 0.6, 2}, ring[] = {0.05, 0.45, 0.55, 0.95};
    double limit[4];
    for (int k = 0; k < 4; k++) {
        const double share = round ? ring[k] : line[k];
        limit[k] = share < 0 ? -HUGE_VAL : share > 1 ? HUGE_VAL : select(d, of->n, (int32_t)(share * of->n));
    }
    for (int32_t k = 0; k < of->n; k++) {
        const double key = d->key[of->node[k]];
        d->end[of->node[k]] = key > limit[0] && key < limit[1]   ? SOURCE
                              : key > limit[2] && key < limit[3] ? SINK
                                                                 : MIDDLE;
    }
}

/* ---- pieces ------------------------------------------------------------------------------------------------------ */

/* Splits the piece along the best direction, and puts its grains into the order of the sides. False if no direction
 * splits it. */
static bool split(dissection *d, const piece *of, int32_t count[SIDES]) {
    static const int way[DIRECTIONS][3] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1}, {1, 1, 0},  {1, -1, 0},
                                           {1, 0, 1},  {1, 0, -1}, {0, 1, 1}, {0, 1, -1}, {1, 1, 1},
                                           {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}};
    double best = HUGE_VAL, begin[3] = {0};
    bool round[3] = {false};
    for (int a = 0; a < d->net->dim; a++)
        round[a] = d->wraps[a] && goes_round(d, of, a, &begin[a]);
    for (int k = 0; k < DIRECTIONS; k++) {
        int axes = 0, rings = 0, beyond = 0;
        int32_t now[SIDES];
        for (int a = 0; a < 3; a++) {
            axes += way[k][a] != 0;
            rings += way[k][a] != 0 && round[a];
            beyond += way[k][a] != 0 && a >= d->net->dim;
        }
        if (beyond > 0 || (rings > 0 && axes > 1))
            continue;
        set_keys(d, of, way[k], begin);
        set_ends(d, of, rings > 0);
        separate(d, of, now);
        const double least = fmin(now[FIRST], now[SECOND]), cost = now[SEPARATOR] / least;
        if (least < LEAST_END * of->n || !(cost < best))
            continue;
        best = cost;
        memcpy(count, now, sizeof now);
        for (int32_t q = 0; q < of->n; q++)
            d->best[of->node[q]] = d->side[of->node[q]];
    }
    if (!(best < HUGE_VAL))
        return false;
    int32_t to[SIDES] = {0, count[FIRST], count[FIRST] + count[SECOND]};
    for (int32_t q = 0; q < of->n; q++)
        d->queue[to[d->best[of->node[q]]]++] = of->node[q];
    memcpy(of->node, d->queue, (size_t)of->n * sizeof *of->node);
    return true;
}

static void end_part(dissection *d, const int32_t *node, int32_t n) {
    for (int32_t k = 0; k < n; k++)
        d->part[node[k]] = d->parts;
    d->parts += n > 0;
}

static void dissect(dissection *d, int32_t *node, int32_t n) {
    const piece of = {node, n, d->pieces++};
    int32_t count[SIDES] = {0};
    for (int32_t k = 0; k < n; k++)
        d->piece[node[k]] = of.id;
    if (n <= LEAF || !split(d, &of, count)) {
        end_part(d, node, n);
        return;
    }
    dissect(d, node, count[FIRST]);
    dissect(d, node + count[FIRST], count[SECOND]);
    end_part(d, node + count[FIRST] + count[SECOND], count[SEPARATOR]);
}

static void list_neighbours(dissection *d) {
    const sp_network *net = d->net;
    for (int32_t k = 0; k < net->n_bulk; k++) {
        d->at[net->springs[k].i + 1]++;
        d->at[net->springs[k].j + 1]++;
    }
    for (int32_t k = 0; k < net->n; k++) {
        d->at[k + 1] += d->at[k];
        d->arc[k] = d->at[k];
    }
    for (int32_t k = 0; k < net->n_bulk; k++) {
        const int32_t i = net->springs[k].i, j = net->springs[k].j;
        d->neighbour[d->arc[i]++] = j;
        d->neighbour[d->arc[j]++] = i;
    }
}

/* Along axes that wrap, in the cell's own coordinates, from 0 to 1; else as they are. */
static void find_places(dissection *d) {
    const sp_network *net = d->net;
    const double *tilt = net->tilt; /* xy, xz, yz */
    for (int a = 0; a < net->dim; a++)
        d->wraps[a] = net->cell == SP_CELL_PERIODIC || (net->cell == SP_CELL_PISTON && a < net->dim - 1);
    for (int32_t k = 0; k < net->n; k++) {
        double x[3] = {net->x[3 * k], net->x[3 * k + 1], net->x[3 * k + 2]};
        if (net->cell == SP_CELL_PERIODIC) {
            const double up = net->dim > 2 ? x[2] / net->box[2] : 0;
            x[1] -= tilt[2] * up;
            x[0] -= tilt[0] * (net->dim > 1 ? x[1] / net->box[1] : 0) + tilt[1] * up;
        }
        for (int a = 0; a < net->dim; a++) {
            const double over = x[a] / net->box[a], within = over - floor(over);
            d->x[k * net->dim + a] = !d->wraps[a] ? x[a] : within < 1 ? within : 0;
        }
        d->node[k] = k;
        d->piece[k] = NONE;
    }
}

static sp_status allocate(dissection *d, sp_error *err) {
    const size_t n = (size_t)d->net->n;
    d->at = sp_alloc(2 * n + 1, sizeof *d->at);
    d->x = sp_alloc(((size_t)d->net->dim + 2) * n, sizeof *d->x);
    d->neighbour = sp_alloc(2 * (size_t)d->net->n_bulk + 8 * n, sizeof *d->neighbour);
    d->end = sp_alloc(3 * n, 1);
    if (!d->at || !d->x || !d->neighbour || !d->end)
        return sp_fail_memory(err, 90 * n);
    d->arc = d->at + n + 1;
    d->key = d->x + (size_t)d->net->dim * n;
    d->sorted = d->key + n;
    d->node = d->neighbour + 2 * d->net->n_bulk;
    d->piece = d->node + n;
    d->before = d->piece + n;
    d->after = d->before + n;
    d->level = d->after + n;
    d->queue = d->level + 2 * n;
    d->side = d->end + n;
    d->best = d->side + n;
    return SP_OK;
}

sp_status sp_dissect(const sp_network *net, int32_t *part, sp_error *err) {
    dissection d = {.net = net, .part = part};
    const sp_status status = allocate(&d, err);
    if (status == SP_OK) {
        list_neighbours(&d);
        find_places(&d);
        dissect(&d, d.node, net->n);
    }
    sp_free(d.at);
    sp_free(d.x);
    sp_free(d.neighbour);
    sp_free(d.end);
    return status;
}
