#ifndef SP_TEAM_H
#define SP_TEAM_H
/* A few threads that share one piece of work again and again, many thousand times a second. */

#include <sonopack/status.h>

typedef struct sp_team sp_team;
/* Part `part` of `parts` of the work; parts must not depend on each other. */
typedef void (*sp_team_work)(void *data, int part, int parts);

/* threads - 1 new threads beside the caller's. *out stays NULL for one thread: sp_team_run then works alone. */
SP_SHARED sp_status sp_team_make(int threads, sp_team **out, sp_error *err);
/* Returns when all parts are done. The caller does part 0. */
SP_SHARED void sp_team_run(sp_team *team, sp_team_work work, void *data);
SP_SHARED void sp_team_free(sp_team *team);

#endif
