/* Mindlin and Deresiewicz's law for one contact. */
#include "packing/mindlin.h"

#include <math.h>
#include <stdbool.h>

/* What a contact remembers, while it is worked on. */
typedef struct memory {
    double sense; /* of the slip, +-1; 0: none yet */
    int turns;
    double at[MINDLIN_TURNS];
} memory;

static memory read_memory(const double *past, int64_t stride) {
    memory m = {.sense = past[0] > 0 ? 1 : past[0] < 0 ? -1 : 0};
    const int turns = past[0] == 0 ? 0 : (int)fabs(past[0]) - 1;
    m.turns = turns < MINDLIN_TURNS ? turns : MINDLIN_TURNS;
    for (int k = 0; k < m.turns; k++)
        m.at[k] = past[(1 + k) * stride];
    return m;
}

static void write_memory(const memory *m, double *past, int64_t stride) {
    past[0] = m->sense * (1 + m->turns);
    for (int k = 0; k < MINDLIN_TURNS; k++)
        past[(1 + k) * stride] = k < m->turns ? m->at[k] : 0;
}

void sp_mindlin_clear(double *past, int64_t stride) {
    for (int k = 0; k < MINDLIN_NUMBERS; k++)
        past[k * stride] = 0;
}

/* A new loop begins at q. */
static void turn(memory *m, double q) {
    if (m->turns == MINDLIN_TURNS)
        m->turns -= 2;
    m->at[m->turns++] = q;
}

/* Where the branch ends, and the one before it goes on. */
static double end_of(const memory *m) { return m->turns > 1 ? m->at[m->turns - 2] : -m->at[0]; }

static void close_loop(memory *m) { m->turns -= m->turns > 1 ? 2 : 1; }

/* Takes into account that q has changed without slip: loops may be closed, and the last reversal may lie ahead. */
static void settle(memory *m, double q) {
    while (m->turns > 0 && m->sense * (q - end_of(m)) >= 0)
        close_loop(m);
    if (m->turns > 0 && m->sense * (q - m->at[m->turns - 1]) < 0)
        m->at[m->turns - 1] = q;
}

/* (dF_t/ds / k)^3 */
static double cubed_factor(const memory *m, double q) {
    const double f = m->turns > 0 ? 1 - 0.5 * fabs(q - m->at[m->turns - 1]) : 1 - m->sense * q;
    return f < 0 ? 0 : f > 1 ? 1 : f;
}

static double two_thirds(double f) {
    const double root = cbrt(f);
    return root * root;
}

/* Along one branch f = cubed_factor falls by df = -w dq, w = 1 or 1/2, and dq = f^(1/3) dx with the slip x = k s/limit.
 * So f^(2/3) falls by 2/3 w dx. */
static double slide(memory *m, double q, double left) {
    for (;;) {
        settle(m, q);
        const bool first = m->turns == 0;
        const double w = first ? 1 : 0.5, f = cubed_factor(m, q), height = two_thirds(f);
        if (!first) {
            const double end = end_of(m), lower = f - w * fabs(end - q);
            const double need = (height - two_thirds(lower > 0 ? lower : 0)) * 1.5 / w;
            if (left >= need) {
                left -= need;
                q = end;
                close_loop(m);
                continue;
            }
        }
        const double rest = height - left * w / 1.5, after = rest > 0 ? rest * sqrt(rest) : 0;
        return q + m->sense * (f - after) / w;
    }
}

double sp_mindlin_slip(double *past, int64_t stride, double force, double limit, double stiffness, double slip) {
    if (!(limit > 0)) {
        sp_mindlin_clear(past, stride);
        return 0;
    }
    double q = force / limit;
    q = q > 1 ? 1 : q < -1 ? -1 : q;
    if (slip == 0)
        return q * limit;
    memory m = read_memory(past, stride);
    const double sense = slip > 0 ? 1 : -1;
    if (m.sense == 0) /* a force that comes without history is taken as that of first loading */
        m.sense = q == 0 ? sense : q > 0 ? 1 : -1;
    if (m.sense != sense)
        turn(&m, q);
    m.sense = sense;
    q = slide(&m, q, fabs(slip) * stiffness / limit);
    write_memory(&m, past, stride);
    return (q > 1 ? 1 : q < -1 ? -1 : q) * limit;
}
