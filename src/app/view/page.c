/* Puts the page together: the text made at build time, the title, and the data of the packings. */
#include "view/view.h"

#include "base/base.h"
#include "packing/geometry.h"
#include "view/parts.h"
#include "view/web.h"

#include <inttypes.h>
#include <sonopack/version.h>
#include <stdio.h>
#include <string.h>

static void tell(const view_part *part, const char *what) {
    if (part->report && part->report->stage)
        part->report->stage(part->report->user, what);
}

/* In SI units: the page then shows numbers in these, if its reader or the command wants it. */
static void describe_material(view_json *j, const sp_material *m) {
    if (m->young == 0) {
        view_text(j, "material", NULL);
        return;
    }
    view_open(j, "material", '{');
    view_number(j, "E", m->young);
    view_number(j, "nu", m->poisson);
    view_number(j, "rho", m->density);
    view_number(j, "d", m->diameter);
    view_close(j, '}');
}

static void describe(view_json *j, const char *name, const sp_packing *p, const sp_network_options *network) {
    char number[24];
    view_text(j, "name", name);
    snprintf(number, sizeof number, "%016" PRIx64, sp_packing_hash(p));
    view_text(j, "hash", number);
    snprintf(number, sizeof number, "%" PRIu64, p->seed); /* beyond the integers of a double */
    view_text(j, "seed", number);
    view_integer(j, "dimension", p->dim);
    view_integer(j, "grains", p->n);
    view_integer(j, "contacts", p->n_contacts);
    view_numbers(j, "box", p->dim, p->box);
    if (p->cell != SP_CELL_PISTON || p->gravity != 0) {
        view_text(j, "cell", sp_cell_names[p->cell]);
        view_numbers(j, "tilt", 3, p->tilt);
        view_number(j, "gravity", p->gravity);
    }
    view_number(j, "pressure", p->pressure);
    view_number(j, "friction", p->friction);
    view_number(j, "poisson", p->poisson);
    view_text(j, "wall", sp_wall_names[p->wall]);
    view_number(j, "threshold", network->threshold);
    view_truth(j, "prestress", network->prestress);
    describe_material(j, &p->material);
    view_text(j, "scene", p->scene);
}

/* The grains of the network, and what moves on them. */
static sp_status add_motion(view_json *j, view_part *part, sp_error *err) {
    const view_options *o = part->options;
    sp_network net = sp_network_none();
    sp_error reason = {0};
    if ((o->modes || o->wave) && sp_network_make(part->packing, &o->network, &net, &reason) == SP_OK)
        part->net = &net;
    part->reason = &reason;
    if (part->net)
        view_add_network(j, &net);
    if (part->net && o->modes)
        tell(part, "modes");
    sp_status status = view_add_modes(j, part, err);
    if (status == SP_OK && part->net && o->wave)
        tell(part, "wave");
    if (status == SP_OK)
        status = view_add_wave(j, part, err);
    sp_network_free(&net);
    part->net = NULL;
    part->reason = NULL;
    return status;
}

sp_status view_add(view_page *page, const char *name, const sp_packing *p, const view_options *options,
                   const view_report *report, sp_error *err) {
    view_json j = {.text = &page->data, .follows = page->packings > 0};
    view_part part = {.packing = p, .options = options, .report = report};
    view_open(&j, NULL, '{');
    describe(&j, name, p, &options->network);
    sp_status status = view_add_grains(&j, p, options->network.threshold, err);
    if (status == SP_OK)
        status = add_motion(&j, &part, err);
    view_close(&j, '}');
    page->packings++;
    if (status == SP_OK && page->data.failed)
        status = sp_fail_memory(err, 2 * page->data.size);
    return status;
}

/* ---- the text --------------------------------------------------------------------------------------------------- */

/* Text for HTML, outside of scripts. */
static void add_escaped(sp_text *out, const char *text) {
    for (const char *s = text; *s;) {
        const size_t length = view_letter(s);
        if (length > 1 || (length == 1 && *s >= 0x20 && !strchr("<>&\"'", *s)))
            sp_text_bytes(out, s, length);
        else
            sp_text_add(out, "&#%d;", length == 0 ? 0xfffd : *s >= 0x20 ? *s : ' ');
        s += length ? length : 1;
    }
}

static void add_data(sp_text *out, const view_page *page) {
    sp_text_add(out, "{\"format\":\"sonopack-view\",\"version\":1,\"program\":\"%s\",\"units\":\"%s\",\n\"packings\":[",
                sp_version(), page->si ? "si" : "own");
    sp_text_bytes(out, page->data.data, page->data.size);
    sp_text_add(out, "]}");
}

/* Copies the page up to a marker and moves behind it. Each marker stands in the page once. */
static const char *copy_to(sp_text *out, const char *at, const char *marker) {
    const char *found = strstr(at, marker);
    sp_text_bytes(out, at, (size_t)(found - at));
    return found + strlen(marker);
}

sp_status view_finish(const view_page *page, const char *title, sp_text *out, sp_error *err) {
    const char *at = (const char *)view_web_page;
    at = copy_to(out, at, VIEW_TITLE);
    add_escaped(out, title);
    at = copy_to(out, at, VIEW_DATA);
    add_data(out, page);
    sp_text_bytes(out, at, strlen(at));
    return out->failed ? sp_fail_memory(err, 2 * page->data.size) : SP_OK;
}

void view_free(view_page *page) {
    sp_text_free(&page->data);
    page->packings = 0;
}
