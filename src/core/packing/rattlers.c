/* Finds the grains that do not carry force. */
#include "base/base.h"

#include <sonopack/packing.h>
#include <stdlib.h>
#include <string.h>

/* Contacts needed to carry force: 2 with friction or in 1D, dim + 1 without friction; with a weight dim, on which a
 * grain rests. */
static int32_t contacts_needed(const sp_packing *p) {
    return p->dim == 1 || p->friction > 0 ? 2 : p->dim + (p->gravity > 0 ? 0 : 1);
}

/* Lists the carrying contacts of each grain i at list[start[i] .. start[i+1]-1]. */
static void list_contacts(const sp_packing *p, const uint8_t *carrying, int32_t *start, int32_t *list) {
    for (int32_t c = 0; c < p->n_contacts; c++) {
        if (!carrying[c])
            continue;
        start[p->contacts[c].i + 1]++;
        if (p->contacts[c].j >= 0)
            start[p->contacts[c].j + 1]++;
    }
    for (int32_t i = 0; i < p->n; i++)
        start[i + 1] += start[i];
    for (int32_t c = p->n_contacts - 1; c >= 0; c--) {
        if (!carrying[c])
            continue;
        list[--start[p->contacts[c].i + 1]] = c;
        if (p->contacts[c].j >= 0)
            list[--start[p->contacts[c].j + 1]] = c;
    }
    /* filling has moved each start[i+1] back to the start of row i */
    memmove(start, start + 1, (size_t)p->n * sizeof *start);
}

sp_status sp_packing_rattlers(const sp_packing *p, double threshold, uint8_t *rattler, uint8_t *carrying,
                              int32_t *n_rattlers, sp_error *err) {
    size_t n = (size_t)p->n, contacts = (size_t)p->n_contacts;
    sp_status status = SP_OK;
    uint8_t *out = sp_alloc(n, 1), *carries = sp_alloc(contacts, 1);
    int32_t *start = sp_alloc(n + 2, sizeof *start), *list = sp_alloc(2 * contacts, sizeof *list);
    int32_t *count = sp_alloc(n, sizeof *count), *queue = sp_alloc(n, sizeof *queue);
    if (!out || !carries || !start || !list || !count || !queue) {
        status = sp_fail_memory(err, n * 14 + contacts * 9);
        goto out;
    }
    const int32_t needed = contacts_needed(p);
    int32_t queued = 0, total = 0, ends = 0;
    for (int32_t c = 0; c < p->n_contacts; c++) {
        carries[c] = p->contacts[c].fn > threshold * p->pressure;
        ends += carries[c] ? (p->contacts[c].j >= 0 ? 2 : 1) : 0;
    }
    list_contacts(p, carries, start, list);
    start[p->n] = ends;
    for (int32_t i = 0; i < p->n; i++) {
        count[i] = start[i + 1] - start[i];
        if (count[i] < needed) {
            out[i] = 1;
            queue[queued++] = i;
        }
    }
    for (; total < queued; total++) { /* removing a grain may leave its neighbours with too few contacts */
        int32_t i = queue[total];
        for (int32_t k = start[i]; k < start[i + 1]; k++) {
            const sp_contact *contact = &p->contacts[list[k]];
            if (!carries[list[k]])
                continue;
            carries[list[k]] = 0;
            int32_t other = contact->i == i ? contact->j : contact->i;
            if (other >= 0 && --count[other] < needed && !out[other]) {
                out[other] = 1;
                queue[queued++] = other;
            }
        }
    }
    if (rattler)
        memcpy(rattler, out, n);
    if (carrying)
        memcpy(carrying, carries, contacts);
    if (n_rattlers)
        *n_rattlers = total;
out:
    sp_free(queue);
    sp_free(count);
    sp_free(list);
    sp_free(start);
    sp_free(carries);
    sp_free(out);
    return status;
}
