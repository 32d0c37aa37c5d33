#ifndef SP_CLI_FILES_H
#define SP_CLI_FILES_H
/* Commands that read packings, one after another, and print one table; and what they would take. */

#include "cli/cli.h"

#include <sonopack/cost.h>

/* ---- --dry-run: a table of what a command would make, and what that would take --------------------------------- */

/* The row of the options of a command whose arguments begin with `common`. */
#define CLI_DRY_RUN                                                                                                    \
    {                                                                                                                  \
        "dry-run", NULL,                                                                                               \
            "Make and write nothing: print what would be made, and what CPU time, memory and disk it "                 \
            "would take",                                                                                              \
            CLI_FLAG, CLI_FIELD(common.dry_run)                                                                        \
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

/* ---- files ------------------------------------------------------------------------------------------------------ */

/* One file, open. */
typedef struct cli_file {
    const char *path;
    const sp_scene *scene; /* of --set, --threshold and --prestress */
    sp_packing packing;
    sp_network network;
    bool cut;    /* columns for the place of the packing in its series are missing */
    bool failed; /* add() may set it after it has reported an error itself: the exit status becomes CLI_FAILED */
} cli_file;

typedef enum cli_file_contents { CLI_PATH = 0, CLI_PACKING, CLI_NETWORK } cli_file_contents;

/* What the syntax of commands on packings has in common. */
#define CLI_ONE_PACKING .file_name = "packing", .files_min = 1, .files_max = 1, .finds_material = true
#define CLI_PACKINGS    .file_name = "packing", .files_min = 1, .files_max = CLI_ANY_NUMBER, .finds_material = true

/* What a command does with its files. `arguments` begin with a cli_common. */
typedef struct cli_files {
    const char *groups;         /* groups of keys that --set takes */
    cli_file_contents contents; /* what of a cli_file is read before add() is called */
    bool stop;                  /* the first bad file ends the command; else it is reported, and the next is read */
    sp_status (*begin)(void *arguments, cli_writer *w); /* adds columns; may be NULL */
    /* Adds the rows of one file. Its message needs no file name, unless contents is CLI_PATH. */
    sp_status (*add)(void *arguments, cli_file *file, cli_writer *w);
    sp_status (*end)(void *arguments, cli_writer *w); /* after the last file; may be NULL */
    /* With --dry-run, in place of the others: what one file would take; NULL: the command has no --dry-run. */
    sp_status (*plan)(void *arguments, const cli_file *file, cli_plan *plan, sp_error *err);
    unsigned kernels;   /* that cost the most: bits 1 << sp_kernel */
    bool tells_network; /* its comments have all options of the network; else the unusual ones follow */
} cli_files;

#define CLI_OF_NETWORK .groups = "network", .contents = CLI_NETWORK

/* Runs the command on common->file[] and writes the table. Returns the exit status. */
int cli_run_files(const cli_files *command, void *arguments);

/* Warnings of packings whose results nobody should trust. Before one is made: of a box that will be lower than 6
 * diameters. Of a packing that is read: of such a box, or of more rattlers than carrying grains. */
void cli_warn_low_box(const cli_common *common, const sp_pack_spec *spec);
void cli_warn_packing(const cli_common *common, const char *path, const sp_packing *p, const sp_network *net);
/* Adds the numbers of zero modes as comments. */
void cli_zero_modes(cli_writer *w, const sp_zero_modes *z);

/* Runs a command that prints one table and reads no packings. Returns the exit status. */
int cli_run_table(void *arguments, sp_status (*work)(void *arguments, cli_writer *w));

/* SP_EREFUSED for a packing in a periodic cell. `what`, such as "a front", begins at a wall. */
sp_status cli_need_walls(const sp_packing *p, const char *what, sp_error *err);

/* For commands that read packings themselves: its place in a series goes into the rows of the file. */
void cli_keep_series(const sp_packing *p, cli_file *file);

/* Reads a packing and makes its network. The message names the file. Free both, even after a failure. */
sp_status cli_read_network(const char *path, const sp_network_options *opt, sp_packing *p, sp_network *net,
                           sp_error *err);

#endif
