#ifndef SP_EXAMPLE_H
#define SP_EXAMPLE_H
/* For the help of one key: a value to try, and where the default comes from. */

#include "scene/field.h"

typedef struct sp_example {
    const char *key;
    const char *value;  /* in the syntax of --set */
    const char *source; /* of the default */
} sp_example;

/* NULL for a key without an example, which the tests do not allow. */
const sp_example *sp_field_example(const sp_field *f);

#endif
