#ifndef SP_CLI_PACK_ENGINE_H
#define SP_CLI_PACK_ENGINE_H
/* pack --engine lammps. */

#include "cli/cli.h"

/* Options of pack; zero: not given. */
typedef struct pack_engine {
    int engine; /* index in pack_engine_words */
    int64_t ranks;
    const char *lammps, *prepare, *collect;
} pack_engine;

enum { PACK_ENGINE_SONOPACK = 0, PACK_ENGINE_LAMMPS };
extern const char *const pack_engine_words[];

/* SP_EINVAL if options contradict each other. */
sp_status pack_engine_check(const pack_engine *e, const cli_common *common, bool seed_given, sp_error *err);
/* --prepare: writes the files of a run to the folder. */
sp_status pack_engine_prepare(const pack_engine *e, const cli_common *common, sp_scene *scene, sp_error *err);
/* Where --collect has its scene. path has SP_PATH_MAX bytes. */
sp_status pack_engine_scene(const pack_engine *e, char *path, sp_error *err);
/* Runs LAMMPS beside the output, or collects, and makes the packing with its scene. The folder of a run is removed by
 * pack_engine_clean, once the packing is saved; after a failure it stays, and the reason names it. */
sp_status pack_engine_make(const pack_engine *e, const cli_common *common, sp_scene *scene, sp_packing *out,
                           sp_error *err);
void pack_engine_clean(const pack_engine *e, const cli_common *common);

#endif
