#ifndef SP_CLI_PLACES_H
#define SP_CLI_PLACES_H
/* Places of sources and detectors as words: PLACE[:normal|:shear] with PLACE one of bottom (sources), top and plane:Y
 * (detectors), part:X0:X1, grain:I; or the component alone for the whole wall. */

#include "cli/cli.h"

typedef enum cli_component { COMPONENT_OPEN = 0, COMPONENT_NORMAL, COMPONENT_SHEAR } cli_component;

typedef struct cli_places {
    bool sources; /* else detectors */
    int32_t n, capacity;
    sp_place *at;
    cli_component *component; /* COMPONENT_OPEN: cli_places_settle decides */
} cli_places;

bool cli_component_of(const char *word, cli_component *out);
/* Adds the place of a word; messages name the option. SP_EINVAL for a word that is none. */
sp_status cli_places_add(cli_places *p, const char *option, const char *word, sp_error *err);
/* Adds `count` planes that divide the height into equal layers. */
sp_status cli_places_add_planes(cli_places *p, int64_t count, double height, sp_error *err);
/* The component of all places that have none of their own; a list without a place becomes the whole wall. */
sp_status cli_places_settle(cli_places *p, bool shear, sp_error *err);
void cli_places_free(cli_places *p);

enum { CLI_PLACE_TEXT = 100 };
/* "plane:12.5:normal": the word that cli_places_add reads back. */
char *cli_place_text(const sp_place *at, bool source, char text[CLI_PLACE_TEXT]);

#endif
