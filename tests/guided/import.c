/* Packings of other programs. The input is a line of options, and after lines "====" the files of grains, contacts and
 * walls. What is imported is a sound packing, and can be written and read again. */
#include "guided.h"

#include <math.h>
#include <sonopack/study/import.h>
#include <sonopack/study/store.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerInitialize(int *count, char ***words) { return count == NULL || words == NULL; }

/* One word of the first line. Returns the status of those that are read by the library. */
static sp_status take_option(sp_import_options *o, char *word, sp_error *err) {
    char *value = strchr(word, '=');
    const size_t key = value ? (size_t)(value++ - word) : 0;
    const struct {
        const char *name;
        const char **text;
        double *number;
    } option[] = {{"contacts", &o->contacts, NULL},
                  {"walls", &o->walls, NULL},
                  {"columns", &o->columns, NULL},
                  {"types", &o->types, NULL},
                  {"kn", NULL, &o->kn},
                  {"kt-ratio", NULL, &o->kt_ratio},
                  {"length-unit", NULL, &o->length_unit},
                  {"force-unit", NULL, &o->force_unit}};
    for (size_t k = 0; k < sizeof option / sizeof *option; k++)
        if (key == strlen(option[k].name) && strncmp(word, option[k].name, key) == 0) {
            if (option[k].text)
                *option[k].text = value;
            else
                *option[k].number = fabs(strtod(value, NULL)) + 1e-9; /* as the command has checked */
            return SP_OK;
        }
    if (key == 4 && strncmp(word, "from", 4) == 0)
        o->form = (sp_form)((unsigned char)*value % SP_FORM_OURS);
    else if (key == 8 && strncmp(word, "material", 8) == 0)
        return sp_material_read(value, &o->material, err);
    else
        return sp_import_set(o, word, err);
    return SP_OK;
}

static void check_packing(const sp_packing *p, const sp_import_report *r) {
    sp_error err = guided_error();
    sp_packing again;
    const char *path = guided_output(0);
    must(guided_good(sp_packing_check(p, &err), &err));
    must(r->grains == p->n && r->contacts == p->n_contacts && r->notes >= 0 && r->notes <= SP_IMPORT_NOTES);
    must(guided_good(sp_packing_save(p, path, &err), &err));
    must(guided_good(sp_packing_read(path, &again, &err), &err));
    must(sp_packing_hash(p) == sp_packing_hash(&again));
    sp_packing_free(&again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    guided_parts in = guided_split(data, size, 4);
    char *word[GUIDED_WORDS];
    sp_import_options o = sp_import_options_default();
    sp_error err = guided_error();
    sp_status status = SP_OK;
    sp_packing p;
    sp_import_report report = {0};
    const int words = guided_words(in.part[0], word);
    for (int k = 0; k < words && status == SP_OK; k++)
        status = take_option(&o, word[k], &err);
    const char *path = guided_file(0, in.count > 1 ? in.part[1] : "", in.count > 1 ? in.size[1] : 0);
    /* names of files on this machine would make the outcome depend on it */
    o.contacts = in.count > 2 && in.size[2] > 0 ? guided_file(1, in.part[2], in.size[2])
                 : o.contacts                   ? "overlap"
                                                : NULL;
    o.walls = in.count > 3      ? guided_file(2, in.part[3], in.size[3])
              : !o.walls        ? NULL
              : *o.walls == 'b' ? "balance"
              : *o.walls == 'n' ? "none"
                                : "overlap";
    if (guided_good(status, &err) && guided_good(sp_import(path, &o, &p, &report, &err), &err)) {
        check_packing(&p, &report);
        sp_packing_free(&p);
    }
    guided_free(&in);
    return 0;
}
