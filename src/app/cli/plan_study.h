#ifndef SP_CLI_PLAN_STUDY_H
#define SP_CLI_PLAN_STUDY_H
/* --dry-run of a study: which samples a store has, and what the others would take. */

#include "cli/dry_run.h"

/* Adds the rows of a study into the folder `store`, which need not exist. Each begins with `prefix`. */
sp_status cli_plan_study(cli_plan *plan, const char *prefix, const sp_scene *study, const sp_study_options *opt,
                         const char *store, sp_error *err);

#endif
