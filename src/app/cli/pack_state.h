#ifndef SP_CLI_PACK_STATE_H
#define SP_CLI_PACK_STATE_H
/* Where `sonopack pack' keeps the state of a making that may be ended, beside its packing. */

#include "base/file.h"
#include "cli/cli.h"

typedef struct pack_state {
    const cli_common *common;
    char path[SP_PATH_MAX];   /* "": none is kept */
    double every, written_at; /* seconds between two writings, and the clock then */
    bool due;                 /* the next one is written at once */
    char *found;              /* what was there at the start: the making goes on from it */
    size_t found_size;
    char *last; /* the last one that has not been written */
    size_t last_size, last_room;
    bool kept; /* a state of this making is in the file */
} pack_state;

/* Looks for the state of an earlier, equal command. */
sp_status pack_state_open(const cli_common *common, const sp_pack_spec *spec, double every, pack_state *out,
                          sp_error *err);
/* Takes one state. */
sp_status pack_state_take(pack_state *s, const void *state, size_t size, sp_error *err);
/* Whether a stop now loses little: a state is there, or none is kept at all. */
bool pack_state_has(const pack_state *s);
/* The making was stopped: what is left in memory goes into the file. */
sp_status pack_state_stop(pack_state *s, sp_error *err);
/* The packing is there: the file goes. */
void pack_state_done(pack_state *s);
void pack_state_free(pack_state *s);

#endif
