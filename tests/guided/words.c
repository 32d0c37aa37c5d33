/* Words of the command line: numbers, units, materials. The first byte chooses. */
#include "base/base.h"
#include "base/text.h"
#include "guided.h"

#include <math.h>
#include <sonopack/network.h>
#include <sonopack/units.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerInitialize(int *count, char ***words) { return count == NULL || words == NULL; }

static void try_number(const char *word) {
    double x, again;
    int64_t whole;
    uint64_t natural;
    char text[SP_NUMBER_TEXT];
    if (sp_word_number(word, &x) && !isnan(x)) {
        must(sp_word_number(sp_number_text(x, text), &again) && memcmp(&x, &again, sizeof x) == 0);
        must(sp_word_number(sp_number_plain(x, text), &again) && memcmp(&x, &again, sizeof x) == 0);
    }
    if (sp_word_integer(word, &whole))
        must(whole == strtoll(word, NULL, 10));
    if (sp_word_unsigned(word, &natural))
        must(natural == strtoull(word, NULL, 10));
}

static void try_material(const char *word) {
    sp_material m, again;
    char text[SP_MATERIAL_TEXT];
    sp_error err = guided_error();
    if (!guided_good(sp_material_read(word, &m, &err), &err))
        return;
    must(guided_good(sp_material_check(&m, &err), &err));
    must(guided_good(sp_material_read(sp_material_text(&m, text), &again, &err), &err));
    must(memcmp(&m, &again, sizeof m) == 0);
}

static void try_unit(const char *word) {
    const sp_material glass = {70e9, 0.22, 2500, 1e-3};
    char si[SP_UNIT_TEXT];
    double factor, value;
    sp_error err = guided_error();
    if (guided_good(sp_unit_to_si(word, &glass, &factor, si, &err), &err))
        must(factor > 0 && strnlen(si, sizeof si) < sizeof si);
    static const char *const unit[] = {"d", "E*", "d / sqrt(E* / rho)", "kHz", "kPa", "mm", "1"};
    for (size_t k = 0; k < sizeof unit / sizeof *unit; k++)
        if (guided_good(sp_quantity_read(word, unit[k], k % 2 ? &glass : NULL, &value, &err), &err))
            must(isfinite(value));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static void (*const reader[])(const char *) = {try_number, try_material, try_unit};
    if (size < 1)
        return 0;
    guided_parts in = guided_split(data + 1, size - 1, 1);
    reader[data[0] % 3](in.part[0]);
    guided_free(&in);
    return 0;
}
