/* What a compression will take. Its steps follow from height, pressure, friction and protocol (packing.inc), the time
 * of a step from the grains and their contacts (laws.inc), the memory from packing/make.c, which refuses by it. */
#include "cost/laws.h"
#include "packing/prepare.h"

#include <math.h>

enum { SHARED_DISKS = 5000, SHARED_SPHERES = 3000 }; /* grains from which threads share a packing */
/* CPU time of two threads over that of one (1.06 to 1.13), and the part that one thread does; the wall time that
 * follows from them was not measured on free cores. */
static const double SHARING = 1.1, SERIAL = 0.05;

/* Pressure in units of that at which the laws were fitted, to a power. */
static double pressed(const sp_pack_spec *s, double power) { return pow(s->pressure / 1e-4, power); }

static bool is_ordered(const sp_pack_spec *s) {
    return s->kind == SP_PACK_CHAIN || (s->kind == SP_PACK_TRIANGULAR && !(s->diameter_min < s->diameter_max));
}

/* Without friction more contacts close, and hardly a grain is left out. */
static double roughness(const sp_pack_spec *s) { return 1 - exp(-s->friction / 0.2); }

static double height_of(const sp_pack_spec *s) {
    if (s->kind == SP_PACK_CHAIN)
        return s->grains;
    if (s->kind == SP_PACK_TRIANGULAR)
        return s->grains / floor(s->width + 0.5) * sqrt(0.75);
    const double area = s->width * (s->dim == 3 ? s->depth : 1);
    const double solid =
        s->grains * (s->dim == 2 ? sp_sizes_mean_area(s) / 0.815 : sp_sizes_mean_volume(s) / 0.59) / area;
    return fmax(solid, 0.5 * (s->diameter_min + s->diameter_max));
}

/* A layer of spheres: a few of the largest hold up the piston, which swings on them for long. */
static bool is_layer(const sp_pack_spec *s, double height) {
    return s->kind == SP_PACK_PISTON && s->dim == 3 && height < 2;
}

static double contacts_of(const sp_pack_spec *s, double height) {
    const double q = pressed(s, 0.25), smooth = 1 - roughness(s);
    if (s->kind == SP_PACK_CHAIN)
        return s->grains + 1.0;
    if (s->kind == SP_PACK_TRIANGULAR)
        return 3.0 * s->grains;
    if (is_layer(s, height))
        return 0.05 * s->grains;
    return s->grains * (s->dim == 2 ? 1.28 + 0.57 * smooth + 0.34 * q : 1.65 + 1.1 * smooth + 0.55 * q);
}

static double rattlers_of(const sp_pack_spec *s, double height) {
    if (s->kind == SP_PACK_CHAIN || s->kind == SP_PACK_TRIANGULAR)
        return 0;
    const double rough = 0.17 / (1 + 1.1 * pressed(s, 1.0 / 3));
    return s->grains * fmax(is_layer(s, height) ? 0.95 : 0, rough * (0.25 + 0.75 * roughness(s)));
}

/* ---- steps ------------------------------------------------------------------------------------------------------ */

typedef enum grains_kind { ROUGH, SMOOTH } grains_kind;

typedef struct steps_law {
    int dim;
    sp_cell cell;
    sp_protocol protocol;
    grains_kind grains;
    double steps, height, pressure; /* at 1 d and 1e-4; powers */
    double time, slower;            /* of a step over that of laws.inc, at 1e-4; power of the pressure */
} steps_law;

static const steps_law laws[] = {
#define STEPS(dim, cell, protocol, grains, steps, a, b, time, c)                                                       \
    {dim, SP_CELL_##cell, SP_PROTOCOL_##protocol, grains, steps, a, b, time, c},
#include "cost/packing.inc"
#undef STEPS
};

/* The row of a compression, which is complete: there is one for each dimension, cell and protocol. The default without
 * a lag, of nearly equal disks, is somfai2005. */
static const steps_law *law_of(const sp_pack_spec *s) {
    const bool lagless = s->protocol == SP_PROTOCOL_DEFAULT && s->lag == 0;
    const sp_protocol protocol = lagless ? SP_PROTOCOL_SOMFAI2005 : s->protocol;
    const grains_kind grains = s->friction > 0 ? ROUGH : SMOOTH;
    const int dim = s->dim == 3 ? 3 : 2;
    for (size_t k = 0; k < sizeof laws / sizeof *laws; k++)
        if (laws[k].dim == dim && laws[k].cell == s->cell && laws[k].protocol == protocol && laws[k].grains == grains)
            return &laws[k];
    return &laws[0];
}

/* Outside of 1e-6 .. 1e-3, where the rows were fitted: without a piston, grains creep longer at small pressures, and
 * those that a strain brings together move longer at large ones. */
static double outer_factor(const sp_pack_spec *s) {
    const bool strained = s->cell != SP_CELL_PISTON;
    const double low = strained ? 0.8 / (1 + s->pressure / 1e-7) : 0;
    const double high = s->protocol == SP_PROTOCOL_AFFINE ? 1.7 : strained ? 0.7 : 0;
    return 1 + low + high * pow(s->pressure / 1e-2, 1.2);
}

/* At small pressures contacts are soft and tolerances small, at large ones grains soon stop each other. */
static double pressure_factor(const sp_pack_spec *s) {
    if (s->protocol == SP_PROTOCOL_QUICK && s->cell == SP_CELL_PISTON)
        return 1;
    return (1 + pow(1e-8 / s->pressure, 0.4)) / (1 + 0.7 * pow(s->pressure / 1e-2, 0.6)) / 0.985 * outer_factor(s);
}

/* Slow where grains roll for long: disks under a piston. */
static double friction_factor(const sp_pack_spec *s) {
    if (!(s->friction > 0))
        return 1;
    const double most = s->cell == SP_CELL_PISTON && s->dim == 2 ? 10 : 0.7;
    return fmax(0.6, pow(fmin(s->friction, most) / 0.5, 0.4 * fmin(1, pressed(s, 0.1))));
}

/* A packing must be calmer, or the grains are unlike: the smallest set the time step. */
static double detail_factor(const sp_pack_spec *s) {
    const double usual = fmin(1e-10, 1e-6 * s->pressure);
    const double decades = s->tolerance > 0 ? log10(usual / s->tolerance) : 0;
    const double smallest = fmin(2, fmax(0.6, pow(0.8 / s->diameter_min, 2)));
    return smallest * fmax(0.4, 1 + 0.04 * decades);
}

/* Grains of a lattice are nearly in place from the start, unless their differences disorder it. */
static double lattice_factor(const sp_pack_spec *s) {
    const double closed = 3 * s->pressure / pow(s->diameter_max - s->diameter_min, 1.5); /* P*, docs/physics.md */
    return 0.25 + 0.35 / (1 + pow(closed / 0.3, 2));
}

/* The rows know boxes of up to about ten diameters. A strain leaves tall columns of spheres with more to settle, most
 * of all at small pressures: ten packings 5 wide, 10 to 80 high, at 1e-6 to 1e-3, one seed each, took up to 3.8 times
 * as long as the row alone says. */
static double tall_factor(const sp_pack_spec *s, double height) {
    const double usual = 10;
    if (s->dim != 3 || s->cell != SP_CELL_PISTON || s->protocol != SP_PROTOCOL_AFFINE || !(height > usual))
        return 1;
    return pow(height / usual, fmin(1.1, 0.5 + 0.2 * fmax(0, log10(1e-4 / s->pressure))));
}

/* The rows know boxes about as wide as high. Waves across a wider one take longer to die away: disks 25 high at 1e-3
 * took 1.35 times the steps where they were 100 wide (64 packings), 2.5 times at 400, one packing. */
static double wide_factor(const sp_pack_spec *s, double height) {
    const double wide = fmax(s->width, s->dim == 3 ? s->depth : 0);
    return s->kind == SP_PACK_PISTON && s->cell == SP_CELL_PISTON ? pow(fmax(1, wide / height), 0.3) : 1;
}

static double stage_steps(const sp_pack_spec *s, double height) {
    const steps_law *law = law_of(s);
    double steps = law->steps * pow(height, law->height) * pressed(s, law->pressure);
    steps *= tall_factor(s, height) * wide_factor(s, height);
    if (s->kind == SP_PACK_TRIANGULAR)
        steps *= lattice_factor(s);
    if (is_layer(s, height))
        steps *= 4;
    if (s->compression == SP_COMPRESSION_ISOTROPIC)
        steps *= 1.45;
    if (s->reference)
        steps *= 5.3;
    return steps * pressure_factor(s) * friction_factor(s) * detail_factor(s);
}

/* The first stage starts from a gas, the others from a packing. */
static double all_steps(const sp_pack_spec *s, double height) {
    const double again = 0.35;
    sp_pack_spec stage = *s;
    double steps = 0;
    for (int32_t k = 0; k < sp_pack_stages(s); k++) {
        stage.pressure = sp_pack_stage_pressure(s, k);
        steps += stage_steps(&stage, height) * (k > 0 || s->kind == SP_PACK_FILE ? again : 1);
    }
    return steps;
}

/* ---- the whole -------------------------------------------------------------------------------------------------- */

/* Steps in a gas are short ones, those in a dense packing are not, and protocols and cells take more or fewer in each.
 */
static double seconds_of(const sp_pack_spec *s, double steps, const sp_machine *machine) {
    const sp_work work = s->reference      ? SP_WORK_STEP_PLAIN
                         : s->dim == 2     ? SP_WORK_STEP_DISKS
                         : s->friction > 0 ? SP_WORK_STEP_SPHERES
                                           : SP_WORK_STEP_SMOOTH_SPHERES;
    /* contacts one by one: 5.3 times the CPU time of 600 disks at 1e-4, 4.6 times at 1e-6, in 1.02 times the steps */
    const double history = s->tangential == SP_TANGENTIAL_HISTORY && s->friction > 0 && !s->reference ? 5 : 1;
    const double overhead = s->grains < 300 ? 1 + 20.0 / s->grains : 1;
    const steps_law *law = law_of(s);
    return sp_law_seconds(work, s->grains, steps, machine) * law->time * pressed(s, law->slower) * overhead * history;
}

sp_packing_forecast sp_packing_expect(const sp_pack_spec *given, int threads, const sp_machine *machine) {
    const sp_pack_spec s = sp_pack_spec_resolve(given);
    const double height = height_of(&s);
    sp_packing_forecast f = {
        .height = height, .contacts = contacts_of(&s, height), .rattlers = rattlers_of(&s, height)};
    f.cost.memory = sp_pack_memory(&s);
    if (is_ordered(&s)) {
        f.cost.cpu = f.cost.wall = 1e-6 * s.grains * machine->slower[SP_KERNEL_STEP];
        return f;
    }
    if (s.kind == SP_PACK_MINIMUM) { /* 500 to 8000 disks, 1000 to 4000 spheres: within a factor of 2 */
        const double grains = s.grains;
        f.steps = sp_pack_stages(&s) * 14000 * pow(grains / 500, 0.5) * pressed(&s, -0.65 / s.law_exponent);
        f.cost.cpu = f.cost.wall = (s.dim == 2 ? 4e-8 : 1e-7) * grains * f.steps * machine->slower[SP_KERNEL_STEP];
        return f;
    }
    f.steps = all_steps(&s, height);
    f.cost.cpu = f.cost.wall = seconds_of(&s, f.steps, machine);
    if (threads > 1 && s.grains >= (s.dim == 3 ? SHARED_SPHERES : SHARED_DISKS)) {
        f.cost.wall *= SERIAL + SHARING * (1 - SERIAL) / threads;
        f.cost.cpu *= SHARING;
    }
    return f;
}
