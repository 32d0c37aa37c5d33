/* Rigid clusters of smooth spheres, which are points in space. Two contacts of a point that keep their angle have one
 * spin; contacts of a point with the same spin, and those that share a contact with the same spin, are one body. A
 * contact alone can turn about its line, so that it may belong to several bodies: it is their hinge. */
#include "base/base.h"
#include "base/vector.h"
#include "elastic/mover.h"

#include <math.h>

/* The sine of the angle between two contacts below which their spin about their line is not definite. */
static const double STRAIGHT = 1e-2;

/* A contact as seen from one of its grains: 2 k, or 2 k + 1 from the second one. */
typedef int32_t end;

typedef struct angle {
    end a, b;     /* two contacts of a point, which keep their angle */
    int32_t body; /* union-find: an angle with the same spin */
} angle;

/* A contact moves with the spin of an angle. */
typedef struct member {
    int32_t contact, angle, next; /* next: of the same contact, or -1 */
} member;

typedef struct hinges {
    mover *m;
    end *next, *first; /* lists of the ends at points: [2 springs], [points] */
    int32_t *member;   /* [springs] the first of the list, or -1 */
    angle *angles;
    member *members;
    int32_t n_angles, n_members;
    size_t angle_room, member_room;
} hinges;

static int32_t point_at(const hinges *h, end e) {
    const sp_spring *s = &h->m->net.springs[e / 2];
    return e % 2 ? s->j : s->i;
}

/* From the point to the other end. */
static void arm_of(const hinges *h, end e, double arm[3]) {
    const sp_spring *s = &h->m->net.springs[e / 2];
    const double length = (e % 2 ? -1 : 1) * h->m->r->net->length[h->m->row[e / 2]];
    for (int a = 0; a < 3; a++)
        arm[a] = length * s->n[a];
}

/* How the other end moves against the point. */
static void against(const hinges *h, end e, int lane, double off[3]) {
    const double *own = sp_mover_motion(h->m, lane, point_at(h, e));
    const double *other = sp_mover_motion(h->m, lane, point_at(h, e ^ 1));
    for (int a = 0; a < 3; a++)
        off[a] = other[a] - own[a];
}

/* The spin w of arms a and b that move as w x a and w x b. With c = a x b, its components along a, b and c follow from
 * the motion of a along b and c, and of b along c. */
static void spin_of(const hinges *h, const angle *q, int lane, double spin[3]) {
    double a[3], b[3], c[3], bc[3], ca[3], off[2][3];
    arm_of(h, q->a, a);
    arm_of(h, q->b, b);
    cross3(a, b, c);
    cross3(b, c, bc);
    cross3(c, a, ca);
    against(h, q->a, lane, off[0]);
    against(h, q->b, lane, off[1]);
    const double square = dot3(c, c), x = dot3(off[0], c), y = dot3(off[1], c), ab = dot3(a, b);
    const double along_a = (dot3(a, a) * y - ab * x) / square, along_b = (ab * y - dot3(b, b) * x) / square;
    for (int k = 0; k < 3; k++)
        spin[k] = (along_a * bc[k] + along_b * ca[k] + dot3(off[0], b) * c[k]) / square;
}

static bool same_spin(const hinges *h, int32_t one, int32_t two) {
    double squares = 0;
    for (int lane = 0; lane < LANES; lane++) {
        double a[3], b[3];
        spin_of(h, &h->angles[one], lane, a);
        spin_of(h, &h->angles[two], lane, b);
        for (int k = 0; k < 3; k++)
            squares += (a[k] - b[k]) * (a[k] - b[k]);
    }
    return sp_mover_none(h->m, squares);
}

/* Whether two contacts of a point keep the distance of their other ends, and are not in one line. */
static bool keeps(const hinges *h, end one, end two) {
    double a[3], b[3], c[3], side[3], squares = 0;
    arm_of(h, one, a);
    arm_of(h, two, b);
    cross3(a, b, c);
    if (!(length3(c) > STRAIGHT * length3(a) * length3(b)))
        return false;
    for (int k = 0; k < 3; k++)
        side[k] = b[k] - a[k];
    for (int lane = 0; lane < LANES; lane++) {
        double off[2][3];
        against(h, one, lane, off[0]);
        against(h, two, lane, off[1]);
        const double longer = (dot3(off[1], side) - dot3(off[0], side)) / length3(side);
        squares += longer * longer;
    }
    return sp_mover_none(h->m, squares);
}

static int32_t body_of(const hinges *h, int32_t q) {
    while (h->angles[q].body != q)
        q = h->angles[q].body = h->angles[h->angles[q].body].body;
    return q;
}

/* A contact joins a body, and the body those that have the same spin at the other end of the contact. */
static sp_status add_member(hinges *h, end e, int32_t own, sp_error *err) {
    const int32_t contact = e / 2;
    for (int32_t q = h->member[contact]; q >= 0; q = h->members[q].next) {
        const int32_t other = h->members[q].angle;
        if (other == own)
            return SP_OK;
        if (body_of(h, own) != body_of(h, other) && same_spin(h, own, other))
            h->angles[body_of(h, own)].body = body_of(h, other);
    }
    member *more = sp_grow(h->members, (size_t)h->n_members + 1, &h->member_room, sizeof *more);
    if (!more)
        return sp_fail_memory(err, 2 * h->member_room * sizeof *more);
    h->members = more;
    h->members[h->n_members] = (member){contact, own, h->member[contact]};
    h->member[contact] = h->n_members++;
    return SP_OK;
}

/* Two contacts of a point that keep their angle join the body of this point that has their spin, or begin one.
 * from: the first angle of this point. */
static sp_status add_angle(hinges *h, end a, end b, int32_t from, sp_error *err) {
    angle *more = sp_grow(h->angles, (size_t)h->n_angles + 1, &h->angle_room, sizeof *more);
    if (!more)
        return sp_fail_memory(err, 2 * h->angle_room * sizeof *more);
    h->angles = more;
    h->angles[h->n_angles] = (angle){a, b, h->n_angles};
    int32_t q = from;
    while (q < h->n_angles && !same_spin(h, q, h->n_angles))
        q++;
    h->n_angles += q == h->n_angles;
    const sp_status status = add_member(h, a, q, err);
    return status == SP_OK ? add_member(h, b, q, err) : status;
}

static sp_status find_bodies(hinges *h, sp_error *err) {
    sp_status status = SP_OK;
    for (int32_t i = 0; i < h->m->r->net->n; i++) {
        const int32_t from = h->n_angles;
        for (end a = h->first[i]; a >= 0; a = h->next[a])
            for (end b = h->next[a]; b >= 0 && status == SP_OK; b = h->next[b])
                if (keeps(h, a, b))
                    status = add_angle(h, a, b, from, err);
    }
    return status;
}

/* The contacts between grains at each of them. */
static sp_status list_ends(hinges *h, sp_error *err) {
    const mover *m = h->m;
    const size_t springs = (size_t)m->net.n_springs, size = 3 * springs + (size_t)m->net.n;
    h->next = sp_alloc(size, sizeof *h->next);
    if (!h->next)
        return sp_fail_memory(err, size * sizeof *h->next);
    h->member = h->next + 2 * springs;
    h->first = h->member + springs;
    for (size_t k = 0; k < size; k++)
        h->next[k] = -1;
    for (end e = 0; e < 2 * m->net.n_springs; e++)
        if (m->net.springs[e / 2].j < m->r->net->n) {
            h->next[e] = h->first[point_at(h, e)];
            h->first[point_at(h, e)] = e;
        }
    return SP_OK;
}

/* Of a contact the first body is its label, the others are more of them; a contact alone is a cluster of its own. What
 * touches a smooth wall slides. */
static sp_status label(hinges *h, sp_error *err) {
    sp_rigid *r = h->m->r;
    r->labels = h->n_angles + r->net->n_springs;
    r->more = sp_alloc((size_t)h->n_members, sizeof *r->more);
    if (!r->more)
        return sp_fail_memory(err, (size_t)h->n_members * sizeof *r->more);
    for (int32_t k = 0; k < h->m->net.n_springs; k++) {
        const int32_t row = h->m->row[k], from = r->n_more;
        if (h->m->net.springs[k].j >= r->net->n)
            continue;
        r->label[row] = h->member[k] < 0 ? h->n_angles + k : body_of(h, h->members[h->member[k]].angle);
        for (int32_t q = h->member[k]; q >= 0; q = h->members[q].next) {
            const sp_rigid_member own = {row, body_of(h, h->members[q].angle)};
            bool known = own.label == r->label[row];
            for (int32_t p = from; p < r->n_more; p++)
                known |= r->more[p].label == own.label;
            if (!known)
                r->more[r->n_more++] = own;
        }
    }
    return SP_OK;
}

sp_status sp_mover_hinges(mover *m, sp_error *err) {
    hinges h = {.m = m};
    sp_status status = list_ends(&h, err);
    if (status == SP_OK)
        status = find_bodies(&h, err);
    if (status == SP_OK)
        status = label(&h, err);
    sp_free(h.next);
    sp_free(h.angles);
    sp_free(h.members);
    return status;
}
