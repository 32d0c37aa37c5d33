/* Applies the tangent stiffness of contacts, with Coulomb's limit. */
#include "elastic/tangent.h"
#include "linalg/vector.h"
#include "packing/contact.h"

#include <string.h>

bool sp_contact_slides(const vibration *m, const touching *t) { return m->turns && t->kn > 0 && t->held < 1; }

int sp_tangent_component(const sp_network *net, int d) { return d < net->dim || net->dim == 3 ? d : 5; }

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int k = 0; k < 3; k++)
        out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

/* Change of the tangential force of a contact at Coulomb's limit. Along the force it is the change of the normal force
 * times the friction coefficient, whatever the slip; across it the spring still acts. The first part makes the
 * stiffness nonsymmetric. */
static void limit_friction(const vibration *m, const touching *t, double along, double push[3]) {
    double force[3];
    for (int a = 0; a < 3; a++)
        force[a] = t->ft0[a] + t->ft[a];
    const double size = sp_norm(3, force);
    if (!(size > 0))
        return;
    const double part = sp_dot(3, force, push) / size;
    for (int a = 0; a < 3; a++)
        push[a] = t->held * (push[a] - part * force[a] / size) - m->friction * t->kn * along * force[a] / size;
}

/* Change of the force on i due to the relative displacement and to the rotations times lever arms. */
static void force_change(const vibration *m, const touching *t, const double moved[3], const double turn[3],
                         double push[3]) {
    const double *n = m->straight ? t->n0 : t->n, along = sp_dot(3, moved, n);
    memset(push, 0, 3 * sizeof *push);
    if (m->turns) {
        const double rest = t->overlap > 0 ? contact_normal_stiffness(t->e, t->overlap) : 0;
        const double kt = 0.5 * m->eta * (rest + t->kn);
        double arm[3];
        cross(turn, n, arm);
        for (int a = 0; a < 3; a++)
            push[a] = kt * (moved[a] - along * n[a] - arm[a]);
    }
    if (sp_contact_slides(m, t))
        limit_friction(m, t, along, push);
    for (int a = 0; a < 3; a++)
        push[a] += t->kn * along * n[a];
}

/* Adds the forces of a contact due to the displacements `in`. */
static void add_contact(const vibration *m, const sp_network *net, const int32_t *row, const touching *t,
                        const double *in, double *out) {
    const int64_t i = (int64_t)(row[t->i] - 1) * net->dof;
    const int64_t j = t->j < 0 ? -1 : (int64_t)(row[t->j] - 1) * net->dof;
    double moved[3] = {0}, turn[3] = {0}, push[3], twist[3];
    for (int d = 0; d < net->dof; d++) {
        const int c = sp_tangent_component(net, d);
        const double one = in[i + d], other = j < 0 ? 0 : in[j + d];
        if (c < 3)
            moved[c] = other - one;
        else
            turn[c - 3] = t->arm_i * one + t->arm_j * other;
    }
    force_change(m, t, moved, turn, push);
    cross(m->straight ? t->n0 : t->n, push, twist);
    for (int d = 0; d < net->dof; d++) {
        const int c = sp_tangent_component(net, d);
        out[i + d] -= c < 3 ? push[c] : t->arm_i * twist[c - 3];
        if (j >= 0)
            out[j + d] -= c < 3 ? -push[c] : t->arm_j * twist[c - 3];
    }
}

void sp_tangent_apply(const vibration *m, const sp_network *net, const int32_t *row, const double *in, double *out) {
    for (int32_t k = 0; k < m->count; k++)
        if (m->touch[k].kn > 0)
            add_contact(m, net, row, &m->touch[k], in, out);
}
