#ifndef SONOPACK_COST_H
#define SONOPACK_COST_H
/* What computations will take, before they are made: CPU time, wall time and memory, from laws that were fitted to
 * measured times (src/core/cost/laws.inc). docs/benchmarks.md compares them with measurements: nine cases in ten lie
 * within a factor of two. Estimating takes microseconds, measuring the machine some milliseconds. */

#include <sonopack/modes.h>
#include <sonopack/packing.h>
#include <sonopack/signal.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Pieces of work that stand for all: another machine is faster in some than in others. */
typedef enum sp_kernel {
    SP_KERNEL_STEP = 0, /* time steps of grains */
    SP_KERNEL_PRODUCT,  /* products with K */
    SP_KERNEL_DENSE,    /* LAPACK */
    SP_KERNEL_SPARSE,   /* sparse factors and their solves */
    SP_KERNELS
} sp_kernel;

/* Time of each kernel over that on the machine of the laws. */
typedef struct sp_machine {
    double slower[SP_KERNELS];
} sp_machine;
SP_API sp_machine sp_machine_reference(void); /* all 1 */
/* Runs kernels on this machine, those whose bit 1 << sp_kernel is set, and takes the median of some runs each: 5 to 20
 * ms a kernel. The others get the geometric mean of those. SP_ENOMEM. */
SP_API sp_status sp_machine_measure(unsigned kernels, sp_machine *out, sp_error *err);

typedef struct sp_cost {
    double cpu, wall; /* [s] wall: with the threads that were asked for, on free cores. NAN: no law */
    double memory;    /* largest, beside what the program has anyway [byte] */
} sp_cost;
/* One after the other. */
SP_API sp_cost sp_cost_add(sp_cost a, sp_cost b);

/* ---- packings --------------------------------------------------------------------------------------------------- */

/* What a compression will be like; its outcome scatters by 1.5 from seed to seed, so do these numbers. */
typedef struct sp_packing_forecast {
    sp_cost cost;
    double steps, height, contacts; /* of a compression: steps of all its stages; height [d] */
    double rattlers;                /* grains */
} sp_packing_forecast;
/* spec: checked (sp_pack_spec_check), with its grains known. */
SP_API sp_packing_forecast sp_packing_expect(const sp_pack_spec *spec, int threads, const sp_machine *machine);

/* ---- networks --------------------------------------------------------------------------------------------------- */

typedef struct sp_network_size {
    int dim;
    double grains, dofs, springs; /* that carry */
    double height, pressure;
    double omega; /* upper bound of all frequencies */
} sp_network_size;
SP_API sp_network_size sp_network_size_of(const sp_network *net, double height);
/* The network of a packing that does not exist yet. */
SP_API sp_network_size sp_network_size_expect(const sp_pack_spec *spec, const sp_packing_forecast *packing);

/* until = 0 stands for sp_signal_window. *method: the one that auto stands for. *products: with K, 0 for modal sums.
 * Either may be NULL. verlet and lax-wendroff have no law. */
SP_API sp_cost sp_cost_signal(const sp_network_size *net, const sp_signal_options *opt, const sp_machine *machine,
                              sp_signal_method *method, double *products);
/* Modes in a range; a band is taken for `expected` modes. */
SP_API sp_cost sp_cost_modes(const sp_network_size *net, const sp_modes_options *opt, const sp_modes_range *range,
                             double expected, const sp_machine *machine);

/* Other results of a network; count: frequencies of harmonic driving, bins of a density, modes compared with a strip,
 * else 1. */
typedef enum sp_network_result {
    SP_RESULT_NETWORK = 0, /* reading a packing and making its network */
    SP_RESULT_STATICS,
    SP_RESULT_MODULI,
    SP_RESULT_PROBES,       /* the four of a study */
    SP_RESULT_DENSITY,      /* of states, by kernel polynomials */
    SP_RESULT_TRANSMISSION, /* without lines */
    SP_RESULT_DISPERSION,
    SP_RESULT_HARMONIC,
    SP_RESULT_CONTINUUM,
    SP_RESULT_SAMPLE, /* saving a sample in a store */
    SP_RESULTS
} sp_network_result;
SP_API sp_cost sp_cost_result(sp_network_result what, const sp_network_size *net, double count,
                              const sp_machine *machine);

/* ---- files ------------------------------------------------------------------------------------------------------ */

/* Bytes of a packing's HDF5 file, exact but for the padding of large arrays (below 20 kB). */
SP_API double sp_bytes_packing(int dim, double grains, double contacts);
SP_API double sp_bytes_packing_text(int dim, double grains, double contacts); /* within a tenth */
/* Bytes of a table as TSV, within a fifth. */
SP_API double sp_bytes_table(double rows, int columns);

#ifdef __cplusplus
}
#endif
#endif
