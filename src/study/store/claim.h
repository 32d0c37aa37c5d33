#ifndef SP_STORE_CLAIM_H
#define SP_STORE_CLAIM_H
/* Who makes a sample, where several processes work on one store: locks on bytes of the file .sonopack-lock, one byte a
 * sample, found by its name. The system gives them back when a process ends, however it ends, and passes them on to
 * other machines where the file system is shared (fcntl(2), "open file description locks"). Where it has no locks,
 * everything is free: a sample may then be made twice, each time the same. */

#include <sonopack/status.h>
#include <stdbool.h>
#include <stdint.h>

typedef struct sp_claims {
    int fd;    /* < 0: not open */
    bool none; /* there are no locks here */
    int64_t held, room;
    uint64_t *byte; /* [held] that this process holds; sp_free */
} sp_claims;

typedef enum sp_claimed { SP_CLAIM_FREE = 0, SP_CLAIM_MINE, SP_CLAIM_OTHERS } sp_claimed;

void sp_claims_close(sp_claims *c);
/* Takes the sample, unless another process, or another thread of this one, has it. SP_CLAIM_MINE: this process has it
 * now; SP_CLAIM_FREE: there are no locks here. With wait it waits until the other one is done. */
sp_claimed sp_claim_take(sp_claims *c, const char *dir, const char *name, bool wait);
void sp_claim_release(sp_claims *c, const char *name);
bool sp_claim_holds(const sp_claims *c, const char *name);

#endif
