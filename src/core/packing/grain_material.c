/* The material of the grains as text. */
#include "base/base.h"
#include "base/text.h"

#include <math.h>
#include <sonopack/packing.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const struct material_key {
    const char *name, *key, *unit;
    size_t offset;
} material_key[] = {{"E", "material.E", " Pa", offsetof(sp_material, young)},
                    {"nu", "material.nu", "", offsetof(sp_material, poisson)},
                    {"rho", "material.rho", " kg/m^3", offsetof(sp_material, density)},
                    {"d", "material.d", " m", offsetof(sp_material, diameter)}};
enum { MATERIAL_KEYS = sizeof material_key / sizeof *material_key };

static double value_of(const sp_material *m, const struct material_key *k) {
    double value;
    memcpy(&value, (const char *)m + k->offset, sizeof value);
    return value;
}

sp_status sp_material_check(const sp_material *m, sp_error *err) {
    for (int k = 0; k < MATERIAL_KEYS; k++) {
        const struct material_key *key = &material_key[k];
        const double value = value_of(m, key);
        const bool ratio = key->offset == offsetof(sp_material, poisson);
        if (ratio ? !(value >= 0 && value <= 0.5) : !(value > 0 && isfinite(value)))
            return sp_fail_key(err, SP_EINVAL, key->key, " = %g%s: must be %s", value, key->unit,
                               ratio ? "0 .. 0.5" : "positive and finite");
    }
    return SP_OK;
}

double sp_material_modulus(const sp_material *m) { return m->young / (1 - m->poisson * m->poisson); }

static sp_status read_value(char *word, sp_material *m, bool given[MATERIAL_KEYS], sp_error *err) {
    char *value = strchr(word, '=');
    int k = 0;
    if (value)
        *value++ = '\0';
    while (k < MATERIAL_KEYS && strcmp(word, material_key[k].name) != 0)
        k++;
    if (!value || k == MATERIAL_KEYS)
        return sp_fail(err, SP_EINVAL, "material: '%.40s': must be E=..., nu=..., rho=... or d=...", word);
    if (given[k])
        return sp_fail_key(err, SP_EINVAL, material_key[k].key, ": is given twice");
    double number;
    if (!sp_word_number(value, &number))
        return sp_fail_key(err, SP_EINVAL, material_key[k].key, " = '%.40s': must be a number", value);
    memcpy((char *)m + material_key[k].offset, &number, sizeof number);
    given[k] = true;
    return SP_OK;
}

sp_status sp_material_read(const char *text, sp_material *out, sp_error *err) {
    sp_material m = {0};
    bool given[MATERIAL_KEYS] = {false};
    char *copy = sp_strdup(text), *rest = copy;
    sp_status status = copy ? SP_OK : sp_fail_memory(err, strlen(text) + 1);
    sp_locale locale = sp_locale_enter();
    for (char *word; status == SP_OK && (word = strsep(&rest, ", \t"));)
        if (*word)
            status = read_value(word, &m, given, err);
    sp_locale_leave(&locale);
    sp_free(copy);
    for (int k = 0; status == SP_OK && k < MATERIAL_KEYS; k++)
        if (!given[k])
            status = sp_fail_key(err, SP_EINVAL, material_key[k].key,
                                 ": is missing; a material is E=70e9,nu=0.22,rho=2500,d=1e-3 (Pa, kg/m^3, m)");
    if (status == SP_OK)
        status = sp_material_check(&m, err);
    if (status == SP_OK)
        *out = m;
    return status;
}

char *sp_material_text(const sp_material *m, char text[SP_MATERIAL_TEXT]) {
    size_t used = 0;
    for (int k = 0; k < MATERIAL_KEYS; k++) {
        char number[SP_NUMBER_TEXT];
        used += (size_t)snprintf(text + used, SP_MATERIAL_TEXT - used, "%s%s=%s", k ? "," : "", material_key[k].name,
                                 sp_number_text(value_of(m, &material_key[k]), number));
    }
    return text;
}
