#ifndef SP_CLI_DRY_RUN_H
#define SP_CLI_DRY_RUN_H
/* --dry-run: a table of what a command would make, and what that would take. */

#include "cli/cli.h"

#include <sonopack/cost.h>

/* The row of the options of a command whose arguments begin with `common`. */
#define CLI_DRY_RUN                                                                                                    \
    {                                                                                                                  \
        "dry-run", NULL,                                                                                               \
            "Make and write nothing: print what would be made, and what CPU time, memory and disk it "                 \
            "would take",                                                                                              \
            CLI_FLAG, .field = offsetof(arguments, common.dry_run)                                                     \
    }

/* A plan under way. cli_plan_begin fills it. */
typedef struct cli_plan {
    const cli_common *common;
    sp_machine machine;
    sp_table table;
    cli_writer w;
    sp_cost total;
    double bytes, longest; /* longest: wall time of what cannot be divided [s] */
} cli_plan;

/* Measures the machine by those kernels (bits 1 << sp_kernel), and adds the columns. */
sp_status cli_plan_begin(const cli_common *common, unsigned kernels, cli_plan *plan, sp_error *err);
/* Adds a row, and to the total. bytes: on the disk. */
void cli_plan_add(cli_plan *plan, const char *what, int64_t count, sp_cost cost, double bytes);
/* Adds a row that costs nothing, such as samples that are there. */
void cli_plan_note(cli_plan *plan, const char *what, int64_t count);
/* Adds the total, and prints the table on stdout, whatever -o says. jobs: how many rows of work are done at a time. */
sp_status cli_plan_end(cli_plan *plan);
void cli_plan_free(cli_plan *plan);

/* Adds the rows of a study into the folder `store', which need not exist: which samples it has, and what the others
 * would take. */
sp_status cli_plan_study(cli_plan *plan, const sp_scene *study, const sp_study_options *opt, const char *store,
                         sp_error *err);

#endif
