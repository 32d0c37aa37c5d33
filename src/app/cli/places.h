#ifndef SP_CLI_PLACES_H
#define SP_CLI_PLACES_H
/* Places of sources and detectors, as written on the command line: PLACE[:normal|:shear], where PLACE is bottom (for a
 * source), top or plane:Y (for a detector), part:X0:X1 or grain:I. A component alone stands for the whole wall. */

#include "cli/cli.h"

enum { CLI_PLACES_MAX = 1000 };

typedef enum cli_component { COMPONENT_DEFAULT = 0, COMPONENT_NORMAL, COMPONENT_SHEAR } cli_component;
extern const char *const cli_component_names[]; /* "normal", "shear" */

typedef struct cli_places {
    bool sources; /* else detectors */
    int32_t n;
    sp_place at[CLI_PLACES_MAX];
    cli_component component[CLI_PLACES_MAX];
} cli_places;

/* Adds a place. Messages name the option. */
sp_status cli_places_add(cli_places *p, const char *option, const char *word, sp_error *err);
/* Adds `count` planes that divide the height into equal layers. */
sp_status cli_places_add_planes(cli_places *p, int64_t count, double height, sp_error *err);
/* Sets the component of all places that do not name one. An empty list becomes the whole wall. */
sp_status cli_places_set_component(cli_places *p, bool shear, sp_error *err);

enum { CLI_PLACE_TEXT = 100 };
/* A word like "plane:12.5:normal", which cli_places_add can read. */
char *cli_place_text(const sp_place *at, bool source, char text[CLI_PLACE_TEXT]);

#endif
