#ifndef SP_CLI_SPRINGS_H
#define SP_CLI_SPRINGS_H
/* What signal, modes, moduli and bench share: the network of a packing file and the options that shape it. */

#include "cli/cli.h"

/* Child of argp: --threshold F and --prestress, on top of the network keys of --set. Its input is a cli_springs. */
typedef struct cli_springs {
    double threshold; /* < 0: not given */
    bool prestress;
} cli_springs;
extern const struct argp cli_springs_argp;

/* Scene of --set, with the options on top; keys of `groups` are taken. Free with sp_scene_free. */
sp_status cli_springs_scene(const cli_common *common, const cli_springs *springs, const char *groups, sp_scene *out,
                            sp_error *err);
/* Reads a packing and makes its network; messages name the file. Either is safe to free afterwards, come what may. */
sp_status cli_read_network(const char *path, const sp_network_options *opt, sp_packing *p, sp_network *net,
                           sp_error *err);
/* Name of a source, and back; false: no such name. */
const char *cli_source_name(sp_source source);
bool cli_source_of(const char *word, sp_source *out);

#endif
