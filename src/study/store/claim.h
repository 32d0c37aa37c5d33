#ifndef SP_STORE_CLAIM_H
#define SP_STORE_CLAIM_H
/* Claims: several processes that work on one store agree on who makes a sample. A claim is a lock on one byte of the
 * file .sonopack-lock, found from the sample's name. The system releases it when the process ends in any way, and
 * shares it with other machines if the file system does (fcntl(2), "open file description locks"). A file system
 * without locks leaves every sample free; some are then made twice, with the same result. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct sp_claims {
    int fd;    /* negative: not open */
    bool none; /* the file system has no locks */
    int64_t held;
    size_t capacity;
    uint64_t *byte; /* [held] bytes locked by this process; sp_free */
} sp_claims;

typedef enum sp_claimed { SP_CLAIM_FREE = 0, SP_CLAIM_MINE, SP_CLAIM_OTHERS } sp_claimed;

void sp_claims_close(sp_claims *c);
/* Claims a sample. SP_CLAIM_MINE: this process has it now. SP_CLAIM_OTHERS: another process or thread has it.
 * SP_CLAIM_FREE: there are no locks. With wait, waits until another process releases it. */
sp_claimed sp_claim_take(sp_claims *c, const char *dir, const char *name, bool wait);
void sp_claim_release(sp_claims *c, const char *name);
bool sp_claim_holds(const sp_claims *c, const char *name);

#endif
