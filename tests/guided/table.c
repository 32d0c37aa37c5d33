/* Tables as text: what is read and written is read again with the same bits. */
#include "guided.h"

#include <sonopack/units.h>
#include <string.h>

int LLVMFuzzerInitialize(int *count, char ***words) { return count == NULL || words == NULL; }

static void check_numbers(const sp_table *a, const sp_table *b) {
    for (int64_t k = 0; k < a->rows * a->columns; k++) {
        const double x = sp_table_number(a, k / a->columns, (int)(k % a->columns)),
                     y = sp_table_number(b, k / a->columns, (int)(k % a->columns));
        must(memcmp(&x, &y, sizeof x) == 0 || (x != x && y != y));
    }
}

/* The text that is written is the same once more. But for what is written with backslashes, which are read as such, and
 * for a name that begins with a byte order mark, in the first place. */
static void check_again(const sp_table *t) {
    sp_error err = guided_error();
    sp_table again;
    char *text = sp_table_text(t, SP_TSV), *second = NULL;
    must(text != NULL);
    if (strchr(text, '\\') || strncmp(text, "\xef\xbb\xbf", 3) == 0) {
        sp_free(text);
        return;
    }
    must(guided_good(sp_table_read(guided_file(1, text, strlen(text)), &again, &err), &err));
    must(again.columns == t->columns && again.rows == t->rows && again.comments == t->comments);
    check_numbers(t, &again);
    second = sp_table_text(&again, SP_TSV);
    must(second != NULL && strcmp(text, second) == 0);
    sp_free(text);
    sp_free(second);
    sp_table_free(&again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    const sp_material glass = {70e9, 0.22, 2500, 1e-3};
    sp_error err = guided_error();
    sp_table t;
    if (!guided_good(sp_table_read(guided_file(0, data, size), &t, &err), &err))
        return 0;
    must(t.columns >= 1 && t.rows >= 0);
    check_again(&t);
    for (int form = SP_CSV; form <= SP_JSON; form++)
        sp_free(sp_table_text(&t, (sp_table_format)form));
    guided_good(sp_table_to_si(&t, &glass, &err), &err);
    sp_table_free(&t);
    return 0;
}
