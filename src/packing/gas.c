#include "base/base.h"
#include "numeric/random.h"
#include "packing/making.h"

#include <math.h>

void sp_radii_draw(const sp_pack_spec *spec, double *r) {
    sp_random stream = sp_random_make(spec->seed, SP_STREAM_DIAMETERS);
    for (int32_t i = 0; i < spec->grains; i++)
        r[i] = 0.5 * (spec->diameter_min + (spec->diameter_max - spec->diameter_min) * sp_random_uniform(&stream));
}

/* Square cells, each at least a largest diameter wide, with the grains in them as linked lists. */
typedef struct gas_cells {
    int nx, ny;
    double wx, wy;
    int32_t *head, *next;
} gas_cells;

static bool overlaps(const gas_cells *cells, const sp_pack_spec *spec, const double *r, const double *x, int32_t i) {
    const double *xi = x + 3 * (size_t)i;
    int cx = (int)(xi[0] / cells->wx), cy = (int)(xi[1] / cells->wy);
    for (int oy = -1; oy <= 1; oy++)
        for (int ox = -1; ox <= 1; ox++) {
            int ny = cy + oy, nx = (cx + ox + cells->nx) % cells->nx;
            if (ny < 0 || ny >= cells->ny)
                continue;
            for (int32_t j = cells->head[(size_t)ny * (size_t)cells->nx + (size_t)nx]; j >= 0; j = cells->next[j]) {
                double dx = x[3 * (size_t)j] - xi[0], dy = x[3 * (size_t)j + 1] - xi[1], reach = r[i] + r[j];
                dx -= spec->width * nearbyint(dx / spec->width);
                if (dx * dx + dy * dy < reach * reach)
                    return true;
            }
        }
    return false;
}

sp_status sp_gas_make(const sp_pack_spec *spec, const double *r, double *x, double *height, sp_error *err) {
    sp_status status = SP_OK;
    double area = 0;
    for (int32_t i = 0; i < spec->grains; i++)
        area += 3.14159265358979323846 * r[i] * r[i];
    /* few grains: still room for the largest to lie anywhere */
    const double h = fmax(area / (spec->gas_fraction * spec->width), 2.0 * spec->diameter_max);
    gas_cells cells = {.nx = (int)fmax(1, floor(spec->width / spec->diameter_max)),
                       .ny = (int)fmax(1, floor(h / spec->diameter_max))};
    cells.wx = spec->width / cells.nx;
    cells.wy = h / cells.ny;
    const size_t count = (size_t)cells.nx * (size_t)cells.ny;
    cells.head = sp_alloc(count, sizeof *cells.head);
    cells.next = sp_alloc((size_t)spec->grains, sizeof *cells.next);
    if (!cells.head || !cells.next) {
        status = sp_fail_memory(err, count * 4 + (size_t)spec->grains * 4);
        goto out;
    }
    for (size_t k = 0; k < count; k++)
        cells.head[k] = -1;
    sp_random stream = sp_random_make(spec->seed, SP_STREAM_GAS);
    for (int32_t i = 0; i < spec->grains; i++) {
        double *xi = x + 3 * (size_t)i;
        int64_t tries = 0;
        do {
            if (++tries > 1000000) {
                status = sp_fail(err, SP_EFAILED,
                                 "no room for grain %d of the starting gas: packing.gas_fraction = %g is too dense", i,
                                 spec->gas_fraction);
                goto out;
            }
            xi[0] = spec->width * sp_random_uniform(&stream);
            xi[1] = r[i] + (h - 2 * r[i]) * sp_random_uniform(&stream);
        } while (overlaps(&cells, spec, r, x, i));
        size_t cell = (size_t)((int)(xi[1] / cells.wy)) * (size_t)cells.nx + (size_t)((int)(xi[0] / cells.wx));
        cells.next[i] = cells.head[cell];
        cells.head[cell] = i;
    }
    *height = h;
out:
    sp_free(cells.next);
    sp_free(cells.head);
    return status;
}
