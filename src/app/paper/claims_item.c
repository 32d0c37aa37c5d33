/* Makes the item "claims" from all its parts. */
#include "paper/claims.h"

sp_status sp_paper_make_claims(paper *p, int item, sp_error *err) {
    (void)item;
    static sp_status (*const part[])(paper *, sp_error *) = {
        sp_paper_claim_margins, sp_paper_claim_forces,     sp_paper_claim_speeds,  sp_paper_claim_lattices,
        sp_paper_claim_unequal, sp_paper_claim_soft_modes, sp_paper_claim_damping, sp_paper_claim_energy};
    const int parts = sizeof part / sizeof *part;
    sp_status status = SP_OK;
    for (int k = 0; k < parts && status == SP_OK; k++) {
        status = part[k](p, err);
        if (status == SP_OK)
            status = sp_paper_tell(p, "claims", (p->cost_done + p->cost) / (2 * p->cost), err);
    }
    return status;
}
