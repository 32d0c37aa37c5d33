/* Tables that figures and pulses are read from, TSV and CSV, and words that describe pulses. The first byte chooses. */
#include "cli/plot_input.h"
#include "cli/pulse.h"
#include "guided.h"

#include <math.h>
#include <sonopack/front.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static char csv[80]; /* a name that ends in .csv, of file 0 */

int LLVMFuzzerInitialize(int *count, char ***words) {
    must(count && words);
    snprintf(csv, sizeof csv, "%s/table.csv", guided_folder());
    must(symlink(guided_file(0, "", 0), csv) == 0);
    return 0;
}

static void try_table(const char *path) {
    sp_error err = guided_error();
    sp_table t;
    if (!guided_good(plot_read_table(path, &t, &err), &err))
        return;
    must(t.columns >= 1 && t.rows >= 0);
    sp_table_free(&t);
}

static void try_signals(const char *path) {
    sp_error err = guided_error();
    const sp_scene scene = sp_scene_default();
    const sp_front_options options = sp_front_options_default();
    sp_front front;
    plot_signals s;
    bool packing = true;
    must(guided_good(plot_is_packing(path, &packing, &err), &err));
    if (packing || !guided_good(plot_read_signals(path, &scene, &s, &err), &err))
        return;
    must(s.n >= 1);
    for (int k = 0; k < s.n; k++)
        if (guided_good(sp_front_find(s.signal[k].n, s.signal[k].t, s.signal[k].f, &options, &front, &err), &err))
            must(isfinite(front.t10) && front.t_peak >= front.t10 && front.amplitude > 0);
    plot_signals_free(&s);
}

static void try_pulse(const char *path) {
    char word[100];
    sp_error err = guided_error();
    cli_pulse p;
    snprintf(word, sizeof word, "file:%s", path);
    must(guided_good(cli_pulse_parse(word, &p, &err), &err));
    if (guided_good(cli_pulse_open(&p, &err), &err))
        must(guided_good(sp_pulse_check(&p.pulse, &err), &err));
    cli_pulse_free(&p);
}

static void try_word(const char *text) {
    sp_error err = guided_error();
    cli_pulse p;
    if (strncmp(text, "file:", 5) != 0 && guided_good(cli_pulse_parse(text, &p, &err), &err))
        must(guided_good(sp_pulse_check(&p.pulse, &err), &err));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0)
        return 0;
    guided_parts in = guided_split(data + 1, size - 1, 1);
    const char *path = guided_file(0, in.part[0], in.size[0]);
    switch (data[0] % 4) {
    case 0: try_table(csv); break;
    case 1: try_signals(data[0] & 4 ? csv : path); break;
    case 2: try_pulse(data[0] & 4 ? csv : path); break;
    default: try_word(in.part[0]); break;
    }
    guided_free(&in);
    return 0;
}
