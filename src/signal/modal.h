#ifndef SP_MODAL_H
#define SP_MODAL_H

#include <sonopack/signal.h>

enum { SP_MODAL_DOFS = 20000 }; /* sp_modes_dense refuses more */

/* The sum over all modes, Eq. (3). s->t and s->n are given; fills f and error. */
sp_status sp_signal_by_modes(const sp_network *net, const sp_signal_options *opt, sp_signal *s, sp_error *err);

#endif
