/* Rigid clusters: the pebble game against ranks of matrices with random bars, exact in a finite field; and what is
 * known of small networks. */
#include "base/base.h"
#include "elastic/rigid.h"
#include "numeric/random.h"
#include "reference.h"

#include <sonopack/clusters.h>

enum { GRAINS = 9, ENDS = GRAINS + SP_RIGID_WALLS, CONTACTS = 40, COLUMNS = 3 * ENDS, TRIALS = 500 };
static const uint64_t PRIME = 2147483647;

/* A random network and its packing, of which only what sp_clusters_make reads is set. */
typedef struct graph {
    sp_packing p;
    sp_network net;
    sp_contact contact[CONTACTS];
    sp_spring spring[CONTACTS];
    double length[CONTACTS], x[3 * GRAINS];
    uint64_t place[ENDS][2]; /* of points */
    sp_random random;
} graph;

static uint64_t any(graph *g) { return 1 + sp_random_below(&g->random, PRIME - 1); }

static void add_contact(graph *g, int32_t i, int32_t j, bool sticks) {
    const int32_t k = g->net.n_springs++;
    g->contact[k] = (sp_contact){.i = i, .j = j, .fn = 1, .ft = {sticks ? 0.1 : 0.5}};
    g->spring[k] = (sp_spring){.i = i, .j = j, .contact = k, .n = {1}};
}

static void start(graph *g, bool friction, int32_t n, uint64_t seed) {
    *g = (graph){.random = sp_random_make(seed, 1)};
    g->p = (sp_packing){.friction = friction ? 0.5 : 0, .contacts = g->contact};
    g->net = (sp_network){.dim = 2,
                          .dof = friction ? 3 : 2,
                          .n = n,
                          .springs = g->spring,
                          .length = g->length,
                          .x = g->x,
                          .cell = SP_CELL_BOX};
    for (int v = 0; v < ENDS; v++)
        for (int a = 0; a < 2; a++)
            g->place[v][a] = any(g);
}

static void draw(graph *g, bool friction, uint64_t seed) {
    start(g, friction, 3 + (int32_t)(seed % (GRAINS - 2)), seed);
    const int32_t n = g->net.n, most = n + (int32_t)sp_random_below(&g->random, (uint64_t)(1.5 * n));
    for (int32_t k = 0; k < most; k++) { /* mostly between neighbours in a row, so that clusters are several */
        const int32_t i = (int32_t)sp_random_below(&g->random, (uint64_t)n);
        const int32_t far = i + 1 + (int32_t)sp_random_below(&g->random, k % 8 == 0 ? GRAINS : 2);
        const int32_t j = far < n ? far : -1 - (int32_t)sp_random_below(&g->random, 2);
        add_contact(g, i, j, sp_random_uniform(&g->random) < 0.6);
    }
}

/* ---- ranks ------------------------------------------------------------------------------------------------------- */

typedef struct space {
    uint64_t row[COLUMNS][COLUMNS]; /* by the column of its first entry, which is 1 */
    bool has[COLUMNS];
    int rank;
} space;

static uint64_t power(uint64_t x, uint64_t n) {
    uint64_t out = 1;
    for (; n; n >>= 1, x = x * x % PRIME)
        out = n & 1 ? out * x % PRIME : out;
    return out;
}

/* Whether a row is new to the space; adds it if `add`. */
static bool is_new(space *s, uint64_t *row, bool add) {
    for (int c = 0; c < COLUMNS; c++) {
        if (row[c] == 0)
            continue;
        if (!s->has[c]) {
            const uint64_t over = power(row[c], PRIME - 2);
            for (int k = c; k < COLUMNS && add; k++)
                s->row[c][k] = row[k] * over % PRIME;
            s->has[c] = s->has[c] || add;
            s->rank += add;
            return true;
        }
        const uint64_t times = PRIME - row[c];
        for (int k = c; k < COLUMNS; k++)
            row[k] = (row[k] + times * s->row[c][k]) % PRIME;
    }
    return false;
}

static bool is_body(const graph *g, int32_t v) { return g->net.dof == 3 || v >= g->net.n; }

/* A bar between two bodies along a random line, or from a point to a random place of a body, or between two points. */
static void bar(graph *g, int32_t i, int32_t j, uint64_t row[COLUMNS]) {
    uint64_t at[2][2], along[2];
    memset(row, 0, COLUMNS * sizeof *row);
    for (int a = 0; a < 2; a++) {
        at[0][a] = is_body(g, i) ? any(g) : g->place[i][a];
        at[1][a] = is_body(g, j) ? any(g) : g->place[j][a];
        along[a] = (at[1][a] + PRIME - at[0][a]) % PRIME;
    }
    const uint64_t arm = (at[0][0] * along[1] + (PRIME - at[0][1]) * along[0]) % PRIME;
    const int32_t end[2] = {i, j};
    for (int q = 0; q < 2; q++) {
        for (int a = 0; a < 2; a++)
            row[3 * end[q] + a] = q ? along[a] : (PRIME - along[a]) % PRIME;
        if (is_body(g, end[q]))
            row[3 * end[q] + 2] = q ? arm : (PRIME - arm) % PRIME;
    }
}

static bool moves_with(graph *g, space *s, int32_t i, int32_t j) {
    uint64_t row[COLUMNS];
    const int bars = 1 + is_body(g, i) + is_body(g, j);
    for (int q = 0; q < bars && i != j; q++) {
        bar(g, i, j, row);
        if (is_new(s, row, false))
            return false;
    }
    return true;
}

static void fill(graph *g, const int32_t *bars, int32_t without, space *s) {
    uint64_t row[COLUMNS];
    memset(s, 0, sizeof *s);
    for (int32_t k = 0; k < g->net.n_springs; k++)
        for (int q = k == without; q < bars[k]; q++) {
            bar(g, g->spring[k].i, sp_rigid_end(&g->net, &g->spring[k]), row);
            is_new(s, row, true);
        }
}

static int check_game(graph *g) {
    const sp_clusters_options o = sp_clusters_options_default();
    FREED(sp_clusters) c;
    space all, less;
    int32_t moves = g->net.n * g->net.dof, walls = 0;
    bool with[ENDS][ENDS];
    assert_ok(sp_clusters_make(&g->p, &g->net, &o, &c, &err));
    fill(g, c.bars, -1, &all);
    for (int32_t i = 0; i < ENDS; i++)
        for (int32_t j = 0; j < ENDS; j++)
            with[i][j] = moves_with(g, &all, i, j);
    for (int32_t k = 0; k < c.springs; k++)
        walls |= g->spring[k].j < 0 ? 1 << (-1 - g->spring[k].j) : 0;
    moves += 3 * ((walls & 1) + (walls >> 1 & 1));
    assert_int_equal(c.redundant_bars, c.bars_all - all.rank);
    assert_int_equal(c.floppy, moves - all.rank - 3);
    for (int32_t k = 0; k < c.springs; k++) {
        const int32_t i = g->spring[k].i, j = sp_rigid_end(&g->net, &g->spring[k]);
        fill(g, c.bars, k, &less);
        assert_int_equal(c.redundant[k], less.rank == all.rank);
        assert_int_equal(c.cluster[k] >= 0, with[i][j]);
        for (int32_t q = 0; q < k; q++) {
            const int32_t a = g->spring[q].i, b = sp_rigid_end(&g->net, &g->spring[q]);
            const bool same = with[i][j] && with[a][b] && with[i][a] && with[i][b] && with[j][a] && with[j][b];
            assert_int_equal(same, c.cluster[k] >= 0 && c.cluster[k] == c.cluster[q]);
        }
    }
    const int several = c.count > 1 && c.grains[0] > 2;
    return several;
}

TEST(test_game_is_generic_rank) {
    for (int friction = 0; friction < 2; friction++) {
        int several = 0;
        for (uint64_t seed = 0; seed < TRIALS; seed++) {
            graph g;
            draw(&g, friction, seed);
            several += check_game(&g);
        }
        assert_true(several > TRIALS / 10); /* they are not all alike */
    }
}

/* Gives a contact its normal and length. */
static void lay(graph *g, int32_t k, double x, double y) {
    g->length[k] = hypot(x, y);
    g->spring[k].n[0] = x / g->length[k];
    g->spring[k].n[1] = y / g->length[k];
    g->spring[k].ri = g->spring[k].rj = 0.5 * g->length[k];
}

/* A ring of four rollers has the motion of gears, and no more; with a chord it is rigid for the game, which counts, but
 * not as it is: the centres keep their places while the rollers turn. Two rigid triangles with a hinge of smooth grains
 * are two clusters that share a grain. */
TEST(test_small_networks) {
    graph g;
    sp_clusters c;
    const sp_clusters_options o = sp_clusters_options_default(), real = {SP_CLUSTERS_MOTIONS, 0.99, true};
    start(&g, true, 4, 1);
    for (int32_t k = 0; k < 4; k++)
        add_contact(&g, k < 3 ? k : 0, k < 3 ? k + 1 : 3, true);
    assert_ok(sp_clusters_make(&g.p, &g.net, &o, &c, &err));
    assert_int_equal(c.floppy, 1);
    assert_int_equal(c.count, 0);
    sp_clusters_free(&c);
    add_contact(&g, 0, 2, false);
    assert_ok(sp_clusters_make(&g.p, &g.net, &o, &c, &err));
    assert_int_equal(c.floppy, 0);
    assert_int_equal(c.grains[0], 4);
    sp_clusters_free(&c);
    const double corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int32_t k = 0; k < 5; k++)
        lay(&g, k, corner[g.spring[k].j][0] - corner[g.spring[k].i][0],
            corner[g.spring[k].j][1] - corner[g.spring[k].i][1]);
    assert_ok(sp_clusters_make(&g.p, &g.net, &real, &c, &err));
    assert_int_equal(c.floppy, 1);
    assert_int_equal(c.redundant_bars, 1);
    assert_int_equal(c.count, 0);
    sp_clusters_free(&c);
    start(&g, true, 3, 1); /* the same with a wall as one of the rollers, and overlaps */
    for (int32_t k = 0; k < 5; k++) {
        add_contact(&g, k % 2, k < 2 ? SP_BOTTOM : k < 4 ? 2 : 1, k < 4);
        lay(&g, k, k < 2 ? 0 : k < 4 ? 0.5 - k % 2 : 1, k < 2 ? -0.499 + 1e-3 * k : k < 4 ? sqrt(0.75) : 0);
        g.spring[k].ri = 0.5;
        g.spring[k].rj = k < 2 ? 0 : 0.5;
    }
    assert_ok(sp_clusters_make(&g.p, &g.net, &real, &c, &err));
    assert_int_equal(c.floppy, 1);
    assert_int_equal(c.redundant_bars, 1);
    sp_clusters_free(&c);
    start(&g, false, 5, 1);
    const int32_t hinge[][2] = {{0, 1}, {1, 2}, {0, 2}, {2, 3}, {3, 4}, {2, 4}};
    for (int k = 0; k < 6; k++)
        add_contact(&g, hinge[k][0], hinge[k][1], true);
    assert_ok(sp_clusters_make(&g.p, &g.net, &o, &c, &err));
    assert_int_equal(c.floppy, 1);
    assert_int_equal(c.count, 2);
    assert_int_equal(c.grains[0] + c.grains[1], 6);
    assert_int_equal(c.redundant_bars + c.spans[0] + c.wraps[0] + c.free_spins, 0);
    sp_clusters_free(&c);
}

/* Smooth spheres at these places, joined by these pairs. */
static sp_clusters clusters_in_space(graph *g, int32_t n, const double (*at)[3], int contacts,
                                     const int8_t (*pair)[2]) {
    const sp_clusters_options real = {SP_CLUSTERS_MOTIONS, 0.99, true};
    sp_clusters c;
    start(g, false, n, 1);
    g->net.dim = g->net.dof = 3;
    for (int32_t k = 0; k < contacts; k++) {
        double side[3];
        add_contact(g, pair[k][0], pair[k][1], false);
        for (int a = 0; a < 3; a++)
            side[a] = at[pair[k][1]][a] - at[pair[k][0]][a];
        g->length[k] = sqrt(side[0] * side[0] + side[1] * side[1] + side[2] * side[2]);
        for (int a = 0; a < 3; a++)
            g->spring[k].n[a] = side[a] / g->length[k];
    }
    assert_ok(sp_clusters_make(&g->p, &g->net, &real, &c, &err));
    return c;
}

/* Two tetrahedra with a common edge turn about it, and the edge belongs to both. A triangle is rigid, its fourth point
 * hangs by one contact. Two bananas with common ends: as many bars as rigidity takes by Maxwell's count, but they turn
 * about the line of their ends, which no contact joins, and each holds the ends apart. */
TEST(test_hinges_in_space) {
    graph g;
    static const double edge[][3] = {{0, 0, 0},       {1, 0, 0},        {0.4, 0.9, 0},
                                     {0.5, 0.3, 0.8}, {0.6, -0.9, 0.1}, {0.5, -0.2, -0.9}};
    static const int8_t tetrahedra[][2] = {{0, 1}, {0, 2}, {1, 2}, {0, 3}, {1, 3}, {2, 3},
                                           {0, 4}, {1, 4}, {0, 5}, {1, 5}, {4, 5}};
    sp_clusters c = clusters_in_space(&g, 6, edge, 11, tetrahedra);
    assert_int_equal(c.count, 2);
    assert_int_equal(c.floppy, 1);
    assert_int_equal(c.redundant_bars, 0);
    for (int q = 0; q < 2; q++)
        assert_true(c.grains[q] == 4 && c.contacts[q] == 6);
    assert_true(c.cluster[0] == 0 && c.of_grain[0] == 0 && c.of_grain[3] != c.of_grain[5]);
    sp_clusters_free(&c);
    static const int8_t hanging[][2] = {{0, 1}, {0, 2}, {1, 2}, {2, 3}};
    c = clusters_in_space(&g, 4, edge, 4, hanging);
    assert_true(c.count == 2 && c.grains[0] == 3 && c.grains[1] == 2 && c.floppy == 2);
    assert_true(c.cluster[3] == 1 && c.contacts[1] == 1);
    sp_clusters_free(&c);
    static const double banana[][3] = {{0, 0, 1},        {0, 0, -1},   {1, 0.6, 0.1},     {1.2, -0.5, 0},
                                       {0.7, 0.1, -0.2}, {-1, 0.5, 0}, {-1.1, -0.6, 0.2}, {-0.6, 0, 0.1}};
    int8_t ends[18][2];
    int k = 0;
    for (int8_t side = 2; side <= 5; side = (int8_t)(side + 3))
        for (int8_t v = 0; v < 3; v++) {
            const int8_t own = (int8_t)(side + v), next = (int8_t)(side + (v + 1) % 3);
            const int8_t bars[3][2] = {{own, next}, {0, own}, {1, own}};
            memcpy(ends[k], bars, sizeof bars);
            k += 3;
        }
    c = clusters_in_space(&g, 8, banana, 18, (const int8_t(*)[2])ends);
    assert_int_equal(c.floppy, 1);
    assert_int_equal(c.redundant_bars, 1);
    assert_int_equal(c.count, 2);
    for (int q = 0; q < 2; q++)
        assert_true(c.grains[q] == 5 && c.contacts[q] == 9);
    for (k = 0; k < 18; k++)
        assert_int_equal(c.redundant[k], 1);
    sp_clusters_free(&c);
    const sp_clusters_options real = {SP_CLUSTERS_MOTIONS, 0.99, true};
    EACH_ALLOCATION_FAILS(10, sp_clusters_make(&g.p, &g.net, &real, &c, &err), assert_true(!lacks || !c.bars),
                          assert_true(lacks || c.count == 2), sp_clusters_free(&c));
}

TEST(test_packings) {
    FREED(sp_packing) p = reference_packing(REFERENCE("packing_N200_p1e-4.txt"));
    FREED(sp_network) net = default_network(&p);
    sp_clusters c = sp_clusters_none();
    sp_clusters_options o = sp_clusters_options_default();
    for (int method = SP_CLUSTERS_GAME; method <= SP_CLUSTERS_MOTIONS; method++) {
        o.method = (sp_clusters_method)method;
        EACH_ALLOCATION_FAILS(10, sp_clusters_make(&p, &net, &o, &c, &err), assert_true(!lacks || !c.bars),
                              assert_true(lacks || (c.count == 1 && c.spans[0] == 2 && c.wraps[0] == 1)),
                              sp_clusters_free(&c));
    }
    o.sliding_at = NAN;
    assert_fails(sp_clusters_make(&p, &net, &o, &c, &err), SP_EINVAL, "sliding");
    o = (sp_clusters_options){.method = (sp_clusters_method)7};
    assert_fails(sp_clusters_make(&p, &net, &o, &c, &err), SP_EINVAL, "7");
}

RUN_TESTS(NULL, NULL)
