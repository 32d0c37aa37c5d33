/* Describes the ensembles of packings as scenes. */
#include "paper/ensemble.h"

#include "scene/field.h"

#include <math.h>
#include <stdio.h>

#define PILE      "kind = \"piston\"; width = 24; friction = 0.5; poisson = 0; seed = 1; "
#define PRESSURES "{ key = \"packing.pressure\"; values = [1e-7, 1e-6, 1e-5, 1e-4]; }"
#define LATTICE   "kind = \"triangular\"; width = 24; poisson = 0; "
#define SMOOTH    "{ key = \"packing.friction\"; values = [0.0, 0.5]; }"
#define CHAIN     "kind = \"chain\"; pressure = 1e-4; friction = 0; seed = 1; "
#define LENGTHS   "sweep = ({ key = \"packing.grains\"; values = [25, 50, 100, 200, 400, 800]; });"

static const struct {
    const char *name; /* shown as progress */
    const char *scene;
    double share;  /* number of samples relative to that of the paper's own ensembles; 0: a single sample */
    int32_t least; /* least number of samples, unless the other ensembles have fewer */
    double cost;   /* CPU seconds of one sample of every combination, measured on one machine */
} ensembles[PAPER_ENSEMBLES] = {
    [PAPER_SQUARE] = {"600 grains", "packing = { grains = 600; " PILE "}; study = { sweep = (" PRESSURES "); };", 1, 1,
                      2.1},
    [PAPER_LOW] = {"200 grains", "packing = { grains = 200; " PILE "}; study = { sweep = (" PRESSURES "); };", 1, 1,
                   0.5},
    [PAPER_SHORT] = {"100 and 400 grains",
                     "packing = { pressure = 1e-4; " PILE
                     "}; study = { sweep = ({ key = \"packing.grains\"; values = [100, 400]; }); };",
                     1, 1, 0.13},
    [PAPER_TALL] = {"1200 grains", "packing = { grains = 1200; pressure = 1e-4; " PILE "};", 1, 1, 0.6},
    [PAPER_TALLEST] = {"2400 grains", "packing = { grains = 2400; pressure = 1e-4; " PILE "};", 0.5, 2, 1.6},
    [PAPER_SMOOTH] = {"without friction",
                      "packing = { grains = 600; pressure = 1e-4; kind = \"piston\"; width = 24; friction = 0; "
                      "seed = 1; };",
                      1, 1, 0.4},
    [PAPER_SPHERES] = {"spheres",
                       "packing = { dimension = 3; grains = 1000; pressure = 1e-4; kind = \"piston\"; width = 8; "
                       "friction = 0; diameter_min = 1; diameter_max = 1; seed = 1; };",
                       0.25, 2, 5},
    [PAPER_LATTICE] = {"lattices",
                       "packing = { " LATTICE "}; study = { sweep = (" SMOOTH
                       ", { key = \"packing.pressure\"; values = [1e-7, 5e-7, 1e-6, 1e-5, 1e-4]; },"
                       "{ key = \"packing.grains\"; values = [216, 672]; }); };",
                       0, 1, 0.2},
    [PAPER_LATTICE_LONG] = {"lattices",
                            "packing = { pressure = 5e-7; " LATTICE "}; study = { sweep = (" SMOOTH
                            ", { key = \"packing.grains\"; values = [480, 1104, 2208, 4416]; }); };",
                            0, 1, 0.5},
    /* alpha = (3e-5)^(2/3) = 9.6549e-4, the width of the distribution: P* = 3 p/alpha^(3/2) = 1e5 p */
    [PAPER_UNEVEN] = {"uneven lattices",
                      "packing = { diameter_min = 0.99951725532; diameter_max = 1.00048274468; seed = 1; " LATTICE
                      "}; study = { sweep = (" SMOOTH ", { key = \"packing.pressure\"; values = [1e-6, 1e-5, 1e-4]; },"
                      "{ key = \"packing.grains\"; values = [216, 672]; }); };",
                      0.25, 2, 1.5},
    [PAPER_UNEVEN_LOW] = {"uneven lattices",
                          "packing = { grains = 672; diameter_min = 0.995; diameter_max = 1.005; seed = 1; " LATTICE
                          "}; study = { sweep = (" SMOOTH
                          ", { key = \"packing.pressure\"; values = [1e-7, 1e-6]; }); };",
                          0.1, 2, 5.5},
    [PAPER_CHAIN_1] = {"chains",
                       "packing = { diameter_min = 0.9; diameter_max = 1.1; " CHAIN "}; study = { " LENGTHS "};", 1, 1,
                       0.05},
    [PAPER_CHAIN_2] = {"chains",
                       "packing = { diameter_min = 0.8; diameter_max = 1.2; " CHAIN "}; study = { " LENGTHS "};", 1, 1,
                       0.05},
    [PAPER_CHAIN_4] = {"chains",
                       "packing = { diameter_min = 0.6; diameter_max = 1.4; " CHAIN "}; study = { " LENGTHS "};", 1, 1,
                       0.05},
};

static int32_t count(paper_ensemble e, int32_t samples) {
    if (!(ensembles[e].share > 0))
        return 1;
    const int32_t most = (int32_t)ceil(ensembles[e].share * samples), least = ensembles[e].least;
    return most >= least ? most : samples < least ? samples : least;
}

double sp_paper_chain_spread(paper_ensemble e) {
    return e == PAPER_CHAIN_1 ? 0.1 : e == PAPER_CHAIN_2 ? 0.2 : e == PAPER_CHAIN_4 ? 0.4 : 0;
}

sp_status sp_paper_ensemble_scene(paper_ensemble e, int32_t samples, sp_protocol protocol, sp_scene *out,
                                  sp_error *err) {
    char number[64], way[64], *override[] = {number, way};
    snprintf(way, sizeof way, "packing.protocol=%s", sp_paper_protocol_name(protocol));
    snprintf(number, sizeof number, "study.samples=%d", count(e, samples));
    const bool piston = e <= PAPER_SPHERES;
    return sp_scene_parse(ensembles[e].scene, ensembles[e].name, piston ? 2 : 1, override, out, err);
}

double sp_paper_ensemble_cost(paper_ensemble e, int32_t samples, sp_protocol protocol) {
    const double slower = e <= PAPER_SPHERES && protocol != SP_PROTOCOL_QUICK ? 5 : 1; /* measured ratio */
    return slower * ensembles[e].cost * count(e, samples);
}

const char *sp_paper_ensemble_name(paper_ensemble e) { return ensembles[e].name; }

const char *sp_paper_protocol_name(sp_protocol protocol) {
    for (const sp_word *w = sp_field_find("packing.protocol")->words; w->word; w++)
        if (w->value == (unsigned)protocol)
            return w->word;
    return "";
}
