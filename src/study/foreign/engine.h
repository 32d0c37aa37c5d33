#ifndef SP_FOREIGN_ENGINE_H
#define SP_FOREIGN_ENGINE_H
/* Packings that LAMMPS makes: the files of a run, and what comes out (the command runs it). */

#include "base/file.h"
#include "base/text.h"

#include <sonopack/packing.h>

/* The files of a run in its folder. WORDS is what LAMMPS and its launcher print. */
typedef enum sp_engine_file {
    SP_ENGINE_GAS = 0, /* data file of the gas */
    SP_ENGINE_INPUT,   /* input script */
    SP_ENGINE_SCENE,   /* the scene that both follow from */
    SP_ENGINE_WORDS,
    SP_ENGINE_LOG,
    SP_ENGINE_GRAINS,   /* dump of the grains at the end */
    SP_ENGINE_CONTACTS, /* of their contacts */
    SP_ENGINE_RESULT,   /* one line, written last */
    SP_ENGINE_FILES
} sp_engine_file;
extern SP_SHARED const char *const sp_engine_names[SP_ENGINE_FILES];

/* ---- writing (engine_deck.c, engine_gas.c) ---------------------------------------------------------------------- */

/* What the input script says in numbers; all in d, E* and rho. */
typedef struct sp_engine_deck {
    int dim;
    int32_t grains;
    double period[2], height; /* of the gas */
    double pressure, friction;
    double kn, kt;             /* F_n = kn sqrt(R12) n^(3/2) and k_t = kt sqrt(R12 n) of two grains; walls: twice */
    double restitution;        /* for which `damping tsuji' has the fraction of critical damping that is wanted */
    double tangential_damping; /* viscous tangential over viscous normal coefficient */
    bool free_viscosity;       /* Coulomb's law does not limit the viscous tangential force, which comes from */
    double weak_kn, weak_restitution, weak_damping; /* contacts of their own, with the same meaning as above */
    double piston_mass, smallest;                   /* smallest diameter */
    double step;
    double skin;       /* of the neighbour lists */
    double calm, rest; /* largest accelerations: below the first a global damping begins, below the second it ends */
    double drag;       /* rate of the global damping */
    int64_t steps;     /* at most */
} sp_engine_deck;

/* SP_EINVAL names the key if LAMMPS cannot make such a packing. The spec is complete and checked. */
SP_SHARED sp_status sp_engine_check(const sp_pack_spec *spec, sp_error *err);
/* The numbers for a resolved spec and a gas of this height. */
SP_SHARED sp_engine_deck sp_engine_plan(const sp_pack_spec *spec, double height);
/* Pressure under which LAMMPS packs: that of the spec unless it would push grains through each other. */
SP_SHARED double sp_engine_pressure(const sp_pack_spec *spec);
/* The number for which the polynomial of `damping tsuji' is `alpha'. */
SP_SHARED double sp_engine_restitution(double alpha);
/* Adds the input script to a text. */
void sp_engine_add_deck(sp_text *t, const sp_engine_deck *d);
/* Writes gas and input script to a folder, which exists. SP_EINVAL, SP_EFAILED (no room for the gas), SP_EIO. */
SP_SHARED sp_status sp_engine_write(const sp_pack_spec *spec, const char *folder, sp_error *err);

/* ---- reading (engine_log.c, engine_collect.c) -------------------------------------------------------------------- */

enum { SP_ENGINE_TEXT = 200 };

/* What the log tells so far. */
typedef struct sp_engine_log {
    char version[SP_ENGINE_TEXT]; /* "29 Sep 2021 - Update 2"; "" if it is not there */
    char fault[SP_ENGINE_TEXT];   /* the first line that begins with ERROR; "" if there is none */
    int64_t steps;                /* of the last row of thermodynamic output; -1: there is none */
    double acceleration, height;
} sp_engine_log;
/* Reads the end of the log and its beginning, or what was printed if there is no log. Never fails: what cannot be read
 * is not known. */
SP_SHARED void sp_engine_read_log(const char *folder, sp_engine_log *out);
/* A date such as "29 Sep 2021 ..." as 20210929; 0 if it is none. */
SP_SHARED int sp_engine_date(const char *version);

/* What LAMMPS has made. */
typedef struct sp_engine_result {
    int64_t steps;
    double acceleration, height;
    char version[SP_ENGINE_TEXT];
    sp_audit audit; /* of the packing at rest */
} sp_engine_result;

/* Reads what LAMMPS has left in the folder, with the tangential forces; then brings it to rest under the pressure of
 * the spec. hooks: watch, user, threads. SP_EFORMAT if a file is cut, or not of this spec; SP_EFAILED if LAMMPS did not
 * reach rest, the packing does not, or the audit finds a fault. */
SP_SHARED sp_status sp_engine_collect(const sp_pack_spec *spec, const char *folder, const sp_pack_hooks *hooks,
                                      sp_packing *out, sp_engine_result *result, sp_error *err);

/* The path of a file in a folder; SP_EINVAL if it is too long. out has SP_PATH_MAX bytes. */
SP_SHARED sp_status sp_engine_path(const char *folder, sp_engine_file file, char *out, sp_error *err);
/* The same, and SP_EFORMAT if there is something else than a regular file: a pipe in a folder of someone else's would
 * keep us waiting. */
sp_status sp_engine_look(const char *folder, sp_engine_file file, char *out, sp_error *err);

#endif
