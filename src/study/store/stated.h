#ifndef SP_STORE_STATED_H
#define SP_STORE_STATED_H
/* What a file says of its packing beside grains and contacts, compared with these. Each returns SP_EFAILED with the
 * field at fault as the key of the error, its stored value, and what it must be. */

#include <sonopack/study/store.h>

/* Fails with this text. */
sp_status sp_at_odds(sp_error *err, const char *field, double stored, double expected);

/* The keys of the packing's own scene. A scene that this version cannot read is left out. SP_ENOMEM. */
sp_status sp_stated_scene(const sp_packing *p, sp_error *err);
/* The residual, against the forces. */
sp_status sp_stated_residual(const sp_packing *p, const sp_audit *audit, sp_error *err);
/* Masses, rattlers and steps in an HDF5 file, which are there for other programs. */
sp_status sp_stated_unread(const char *path, const sp_packing *p, sp_error *err);

#endif
