/* Elastic moduli of a packing from a file, as another program may have written it.
 *
 *   moduli_of_file FILE
 *
 * FILE is HDF5 or text (docs/file-format.md describes both). A file is never taken on trust: sp_packing_read refuses
 * what is no packing, and sp_packing_audit measures how far its forces are from balance before anything is made of
 * them. Moduli are in E*, speeds in sqrt(E* / rho), with rho the density of the grain material. */
#include <sonopack/sonopack.h>
#include <sonopack/study/store.h>

#include <stdio.h>

static const double threshold = 1e-4; /* contacts below this fraction of p d^2 carry nothing */

static sp_status check(const sp_packing *p, sp_error *err) {
    sp_audit audit;
    char reason[200];
    sp_status status = sp_packing_audit(p, threshold, &audit, err);
    if (status != SP_OK)
        return status;
    const double worst = sp_audit_worst(&audit, 1e-3, reason, sizeof reason);
    printf("%d grains, %d of them rattlers; p = %g E*; largest relative fault %.1e%s%s\n", (int)p->n,
           (int)audit.rattlers, p->pressure, worst, *reason ? ": " : "", reason);
    return SP_OK;
}

static sp_status find_moduli(const sp_packing *p, sp_moduli *out, sp_error *err) {
    const sp_network_options options = sp_network_options_default();
    const double margin = 3.0; /* layers of this height at both walls are not bulk */
    sp_statics statics;
    sp_network net = sp_network_none();
    sp_status status = sp_statics_make(p, threshold, margin, &statics, err);
    if (status == SP_OK)
        status = sp_network_make(p, &options, &net, err);
    if (status == SP_OK) /* the density without rattlers turns moduli into speeds of long waves */
        status = sp_moduli_make(&net, statics.phi3s, out, err);
    sp_network_free(&net);
    return status;
}

static void show(const char *name, double value, double error, const char *unit) {
    printf("  %-4s %10.6f +- %.0e %s\n", name, value, error, unit);
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fprintf(stderr, "usage: %s FILE\n", argv[0]);
        return 2;
    }
    sp_error err = {0};
    sp_packing packing = sp_packing_none();
    sp_moduli moduli;
    sp_status status = sp_packing_read(argv[1], &packing, &err);
    if (status == SP_OK)
        status = check(&packing, &err);
    if (status == SP_OK)
        status = find_moduli(&packing, &moduli, &err);
    const int dim = packing.dim;
    sp_packing_free(&packing);
    if (status != SP_OK) {
        fprintf(stderr, "%s: %s\n", sp_status_name(status), err.text);
        return 1;
    }
    show("C11", moduli.c11, moduli.error11, "E*");
    show("C12", moduli.c12, moduli.error12, "E*");
    show("C22", moduli.c22, moduli.error22, "E*");
    if (dim == 2)
        show("C33", moduli.c33, moduli.error33, "E*");
    printf("long waves from wall to wall: c_l = %.4f, c_t = %.4f sqrt(E*/rho)\n", moduli.c_l, moduli.c_t);
    return 0;
}
