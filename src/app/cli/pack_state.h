#ifndef SP_CLI_PACK_STATE_H
#define SP_CLI_PACK_STATE_H
/* The file beside a packing in which `sonopack pack' saves the state of a compression, so that it can be continued. */

#include "base/file.h"
#include "cli/cli.h"

typedef struct pack_state {
    const cli_common *common;
    char path[SP_PATH_MAX];   /* "": no state is saved */
    double every, written_at; /* seconds between two writes, and the clock at the last one */
    bool due;                 /* the next state is written at once */
    char *found;              /* the state at the start, which the compression continues; or NULL */
    size_t found_size;
    char *last; /* the last state that has not been written */
    size_t last_size, last_capacity;
    bool kept; /* the file has a state of this compression */
} pack_state;

/* Looks for the state of an earlier, equal command. */
sp_status pack_state_open(const cli_common *common, const sp_pack_spec *spec, double every, pack_state *out,
                          sp_error *err);
/* Takes the present state, and writes it if it is time to. */
sp_status pack_state_update(pack_state *s, const void *state, size_t size, sp_error *err);
/* Whether the compression can be stopped without loss: a state can be written, or none is to be saved. */
bool pack_state_is_safe(const pack_state *s);
/* Writes the last state after the compression was stopped. */
sp_status pack_state_flush(pack_state *s, sp_error *err);
/* Removes the file after the packing has been saved. */
void pack_state_remove(pack_state *s);
void pack_state_free(pack_state *s);

#endif
