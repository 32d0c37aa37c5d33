/* Sources and detectors: walls, parts of walls, single grains, planes. */
#include "network/place.h"

#include "base/base.h"
#include "base/text.h"
#include "network/network_cell.h"
#include "network/rows.h"
#include "packing/geometry.h"

#include <math.h>
#include <sonopack/network.h>
#include <stdio.h>
#include <string.h>

sp_place sp_place_wall(void) { return (sp_place){.kind = SP_PLACE_WALL}; }

/* The direction of a plane at a point: the up axis, or x (shear); of a ring along its radius, or across. */
static void way_at(const sp_network *net, const sp_place *at, const double x[3], double way[3]) {
    way[0] = way[1] = way[2] = 0;
    if (net->cell != SP_CELL_RING) {
        way[at->shear ? 0 : net->dim - 1] = 1;
        return;
    }
    const double c = 0.5 * net->box[0], r = hypot(x[0] - c, x[1] - c);
    way[0] = (at->shear ? x[1] - c : x[0] - c) / r;
    way[1] = (at->shear ? c - x[0] : x[1] - c) / r;
}

/* The same at the contact of a spring. */
static void way_of(const sp_network *net, const sp_place *at, const sp_spring *s, double way[3]) {
    double x[3];
    for (int a = 0; a < 3; a++)
        x[a] = net->x[3 * (int64_t)s->i + a] + s->ri * s->n[a];
    way_at(net, at, x, way);
}

static double height_of(const sp_network *net, int32_t grain) {
    const double *x = net->x + 3 * (int64_t)grain;
    return net->cell == SP_CELL_RING ? sp_ring_level(net->box, x) : x[net->dim - 1];
}

/* Largest component along a wall of its normal that counts as rounding: normals may come in single precision. */
static const double LEVEL = 1e-7;

static bool is_level(const sp_network *net, const sp_spring *s) {
    const int across = s->j >= SP_TOP ? net->dim - 1 : s->j >= SP_RIGHT ? 0 : 1;
    for (int a = 0; a < net->dim; a++)
        if (a != across && !(fabs(s->n[a]) <= LEVEL))
            return false;
    return sp_packing_wall_side(s->j) * s->n[across] > 0;
}

/* The way of a wall at a contact with normal n: along n into the packing at the bottom, out of it at the top, which is
 * up between level walls. shear: along the wall, which is x between level walls (and only there in 3D). */
static void set_way(const sp_network *net, int32_t wall, bool shear, const double n[3], double way[3]) {
    for (int a = 0; a < 3; a++)
        way[a] = wall == SP_BOTTOM ? -n[a] : n[a];
    if (!shear)
        return;
    const double across[3] = {net->dim == 2 ? way[1] : 1, net->dim == 2 ? -way[0] : 0, 0};
    for (int a = 0; a < 3; a++)
        way[a] = across[a];
}

sp_status sp_network_need_level_walls(const sp_network *net, const char *what, sp_error *err) {
    if (net->cell == SP_CELL_RING)
        return sp_cell_need_flat(net->cell, what, err);
    for (int32_t k = net->n_bulk; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        if (!is_level(net, s))
            return sp_fail(err, SP_EREFUSED,
                           "contact %d has the normal %.6g %.6g %.6g, of an inclined %s wall: %s needs a bottom wall "
                           "below and a top wall above, with vertical normals; turn the packing",
                           s->contact, s->n[0], s->n[1], s->n[2], sp_side_names[-1 - s->j], what);
    }
    return SP_OK;
}

/* Subtracts `stiffness` x `push` times a spring's row of coefficients. */
static void add_row(const sp_network *net, const sp_spring *s, int width, double stiffness, const double *row,
                    double push, double *out) {
    for (int a = 0; a < width; a++)
        out[(int64_t)(a < net->dof ? s->i : s->j) * net->dof + a % net->dof] -= stiffness * row[a] * push;
}

/* Component of a gap along a way. */
static double along(const sp_network *net, const double *gap, const double way[3]) {
    double sum = 0;
    for (int a = 0; a < net->dim; a++)
        sum += gap[a] * way[a];
    return sum;
}

/* Adds the response of a wall's spring. Its energy is 1/2 sum k (b . u + gap . w)^2, with w the displacement of the
 * wall. A unit of w along the wall's way exerts the force -k b gap on the grain, and a displacement u of the grain
 * exerts a force on the wall with the same coefficients. In addition, a grain that rotates about the wall's normal
 * turns the tangential force at rest. A moving wall does not, so this term belongs to detectors (the top wall) only. */
static void add_wall_spring(const sp_network *net, int32_t k, bool shear, double *out) {
    const sp_spring *s = &net->springs[k];
    sp_rows rows;
    sp_turns turns;
    double way[3];
    set_way(net, s->j, shear, s->n, way);
    sp_network_turns(net, k, &turns);
    for (int q = 0; q < turns.count && s->j == SP_TOP; q++)
        add_row(net, s, net->dof, 1, turns.right[q], along(net, turns.left_gap[q], way), out);
    sp_network_rows(net, s, &rows);
    for (int q = 0; q < rows.count; q++)
        add_row(net, s, net->dof, rows.k[q], rows.b[q], along(net, rows.gap[q], way), out);
}

/* x of a grain's centre, in [0, period) where the network is periodic. */
static double wrapped(const sp_network *net, int32_t grain) {
    const double period = net->box[0], x = net->x[3 * (int64_t)grain];
    return sp_network_periodic(net, 0) ? x - period * floor(x / period) : x;
}

bool sp_place_in_disc(const sp_network *net, const sp_place *at, const double x[3]) {
    const double centre[2] = {at->x, at->y};
    double square = 0;
    for (int a = 0; a < 2; a++) {
        double off = x[a] - centre[a];
        if (sp_network_periodic(net, a))
            off -= net->box[a] * round(off / net->box[a]);
        square += off * off;
    }
    return square <= 0.25 * at->diameter * at->diameter;
}

static bool belongs(const sp_network *net, const sp_place *at, const sp_spring *s) {
    if (at->kind == SP_PLACE_GRAIN)
        return net->grain[s->i] == at->grain;
    if (at->kind == SP_PLACE_DISC)
        return sp_place_in_disc(net, at, net->x + 3 * (int64_t)s->i);
    if (at->kind != SP_PLACE_PART)
        return true;
    const double x = wrapped(net, s->i);
    return x >= at->from && x < at->to;
}

/* Adds the springs of one wall that belong to the place. Returns their number. */
static int32_t add_wall(const sp_network *net, const sp_place *at, int32_t wall, double *out) {
    int32_t count = 0;
    for (int32_t k = net->n_bulk; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        if (s->j != wall || !belongs(net, at, s) || (at->shear && s->kt == 0))
            continue;
        add_wall_spring(net, k, at->shear, out);
        count++;
    }
    return count;
}

/* A ring has directions everywhere. */
static sp_status need_directions(const sp_network *net, const char *what, sp_error *err) {
    return net->cell == SP_CELL_RING ? SP_OK : sp_network_need_level_walls(net, what, err);
}

static sp_status find_grain(const sp_network *net, const sp_place *at, int32_t *row, sp_error *err) {
    if (at->grain < 0 || at->grain >= net->n_all)
        return sp_fail(err, SP_EINVAL, "grain %d, must be 0 .. %d", at->grain, net->n_all - 1);
    for (int32_t k = 0; k < net->n; k++)
        if (net->grain[k] == at->grain) {
            *row = k;
            return SP_OK;
        }
    return sp_fail(err, SP_EREFUSED, "grain %d is a rattler: it carries no sound", at->grain);
}

static sp_status check_plane(const sp_network *net, const sp_place *at, sp_error *err) {
    const double height = net->box[net->dim - 1];
    const bool around = sp_network_periodic(net, net->dim - 1);
    if ((at->height > 0 || (around && at->height == 0)) && at->height < height)
        return SP_OK;
    return sp_fail(err, SP_EINVAL, "plane at %g, must be %s 0 and below the height %.6g", at->height,
                   around ? "at or above" : "above", height);
}

static bool is_inside(double x, double length) { return x >= 0 && x <= length; }

static sp_status check_disc(const sp_network *net, const sp_place *at, sp_error *err) {
    const double most = fmin(net->box[0], net->box[1]);
    if (net->dim == 3 && is_inside(at->x, net->box[0]) && is_inside(at->y, net->box[1]) && at->diameter > 0 &&
        at->diameter <= most)
        return sp_network_need_level_walls(net, "a disc on a wall", err);
    if (net->dim < 3)
        return sp_fail(err, SP_EINVAL, "a disc on a wall of a packing in %d dimensions: must be a part, part:X0:X1",
                       net->dim);
    return sp_fail(err, SP_EINVAL,
                   "disc at %g, %g of diameter %g: must be within 0 .. %.6g and 0 .. %.6g, and no wider than %.6g",
                   at->x, at->y, at->diameter, net->box[0], net->box[1], most);
}

static sp_status check_walls(const sp_network *net, const sp_place *at, bool source, sp_error *err) {
    if (net->cell != SP_CELL_PERIODIC || at->kind == SP_PLACE_PLANE || at->kind == SP_PLACE_GRAIN)
        return SP_OK;
    return sp_fail(
        err, SP_EREFUSED,
        "the cell is periodic and has no %s wall: the %s must be plane:Y, a plane at the height Y, or grain:I",
        source ? "bottom" : "top", source ? "source" : "detector");
}

/* Checks the place, sets out to 0, and finds the row of a grain (otherwise *row = -1). */
static sp_status begin(const sp_network *net, const sp_place *at, bool source, double *out, int32_t *row,
                       sp_error *err) {
    if (at->shear && net->dim < 2)
        return sp_fail(err, SP_EINVAL, "shear in one dimension, must be normal");
    sp_status status = check_walls(net, at, source, err);
    if (status == SP_OK && at->kind == SP_PLACE_PLANE)
        status = check_plane(net, at, err);
    if (status != SP_OK)
        return status;
    if (at->kind == SP_PLACE_PART && !(net->dim > 1 && at->from >= 0 && at->from < at->to && at->to <= net->box[0]))
        return sp_fail(err, SP_EINVAL, "part %g .. %g of a wall, must be an interval in 0 .. %.6g", at->from, at->to,
                       net->dim > 1 ? net->box[0] : 0);
    *row = -1;
    if (at->kind == SP_PLACE_GRAIN)
        status = find_grain(net, at, row, err);
    if (at->kind == SP_PLACE_DISC)
        status = check_disc(net, at, err);
    if (status == SP_OK && at->kind == SP_PLACE_PLANE)
        status = need_directions(net, "a plane", err);
    if (status == SP_OK && at->kind == SP_PLACE_PART)
        status = sp_network_need_level_walls(net, "a part of a wall", err);
    if (status == SP_OK && at->shear && net->dim == 3)
        status = sp_network_need_level_walls(net, "shear along x", err);
    for (int64_t k = 0; k < sp_network_dofs(net) && status == SP_OK; k++)
        out[k] = 0;
    return status;
}

static sp_status nothing_there(const sp_place *at, const char *wall, const char *what, sp_error *err) {
    return sp_fail(err, SP_EREFUSED, "no carrying contact%s at the %s wall%s: nothing can be %s",
                   at->shear ? " with friction" : "", wall,
                   at->kind == SP_PLACE_PART   ? " in this part"
                   : at->kind == SP_PLACE_DISC ? " in this disc"
                                               : "",
                   what);
}

/* Half the thickness of the layer of grains that a plane moves: half a mean diameter. */
static const double LAYER = 0.5;

/* Moves a grain by a unit. */
static void add_unit(const sp_network *net, const sp_place *at, int32_t grain, double *out) {
    double way[3];
    way_at(net, at, net->x + 3 * (int64_t)grain, way);
    for (int a = 0; a < net->dim; a++)
        out[(int64_t)grain * net->dof + a] = way[a];
}

/* Moves the grains of the layer at a plane, across the period of the cell. Returns their number. */
static int32_t add_layer(const sp_network *net, const sp_place *at, double *out) {
    const int up = net->dim - 1;
    int32_t count = 0;
    for (int32_t i = 0; i < net->n; i++) {
        double above = height_of(net, i) - at->height;
        if (sp_network_periodic(net, up))
            above -= net->box[up] * floor((above + LAYER) / net->box[up]);
        if (!(above >= -LAYER && above < LAYER))
            continue;
        add_unit(net, at, i, out);
        count++;
    }
    return count;
}

sp_status sp_network_source_at(const sp_network *net, sp_source source, const sp_place *at, double *out,
                               sp_error *err) {
    if (source != SP_SOURCE_IMPULSE && source != SP_SOURCE_VELOCITY && source != SP_SOURCE_DISPLACEMENT)
        return sp_fail(err, SP_EINVAL, "source %d, must be impulse, velocity or displacement", (int)source);
    int32_t row;
    sp_status status = begin(net, at, true, out, &row, err);
    if (status != SP_OK)
        return status;
    if (at->kind == SP_PLACE_PLANE) {
        if (add_layer(net, at, out) == 0)
            return sp_fail(err, SP_EREFUSED, "no grain that carries is within %g d of the plane at %g", LAYER,
                           at->height);
    } else if (add_wall(net, at, SP_BOTTOM, out) == 0) {
        if (row < 0)
            return nothing_there(at, "bottom", "sent in", err);
        status = need_directions(net, "a grain that does not touch the bottom wall", err);
        if (status != SP_OK)
            return status;
        add_unit(net, at, row, out);
    }
    for (int64_t k = 0; source == SP_SOURCE_VELOCITY && k < sp_network_dofs(net); k++)
        out[k] *= net->mass[k];
    return SP_OK;
}

/* Adds the force on one end of a spring along the way of the place: on i (end 0), or on j or the wall (end 1). */
static void add_force(const sp_network *net, const sp_place *at, int32_t k, int end, double *out) {
    const sp_spring *s = &net->springs[k];
    double way[3];
    way_of(net, at, s, way);
    sp_rows rows;
    sp_turns turns;
    sp_network_rows(net, s, &rows);
    sp_network_turns(net, k, &turns);
    for (int q = 0; q < rows.count; q++)
        add_row(net, s, rows.width, rows.k[q], rows.b[q], along(net, end == 0 ? rows.b[q] : rows.gap[q], way), out);
    for (int q = 0; q < turns.count; q++)
        add_row(net, s, turns.width, 1, turns.right[q], along(net, end == 0 ? turns.left[q] : turns.left_gap[q], way),
                out);
}

/* How many of the planes at `height` + m periods a centre is above, counted from the plane m = 0; between walls that is
 * the only one. */
static int32_t level_of(const sp_network *net, double y, double height) {
    const int up = net->dim - 1;
    return sp_network_periodic(net, up) ? (int32_t)ceil((y - height) / net->box[up]) : y > height;
}

int sp_place_crossing(const sp_network *net, double height, double y, double rise, int32_t j, double other,
                      int32_t *low) {
    const int up = net->dim - 1;
    const int32_t from = level_of(net, y, height);
    int32_t to = from;
    if (j >= 0)
        to = level_of(net, other, height);
    else if (j >= SP_TOP)
        to = j == SP_TOP;
    if (j >= 0 && sp_network_periodic(net, up))
        to += (int32_t)lround((y + rise - other) / net->box[up]);
    *low = from < to ? from : to;
    return to - from;
}

static int crossing(const sp_network *net, int32_t k, double height, int32_t *low) {
    const sp_spring *s = &net->springs[k];
    const int up = net->dim - 1;
    const double other = s->j >= 0 ? height_of(net, s->j) : 0;
    return sp_place_crossing(net, height, height_of(net, s->i), net->length[k] * s->n[up], s->j, other, low);
}

static int32_t add_plane(const sp_network *net, const sp_place *at, double *out) {
    int32_t count = 0, low;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const int up = crossing(net, k, at->height, &low);
        if (up == 0)
            continue;
        add_force(net, at, k, up < 0 ? 0 : 1, out);
        count++;
    }
    return count;
}

double sp_network_plane_height(const sp_network *net, double height) {
    const sp_place at = {.kind = SP_PLACE_PLANE};
    const int up = net->dim - 1;
    double weight = 0, sum = 0, way[3];
    int32_t low;
    for (int32_t k = 0; k < net->n_springs; k++) {
        const sp_spring *s = &net->springs[k];
        if (crossing(net, k, height, &low) == 0)
            continue;
        way_of(net, &at, s, way);
        const double steep = along(net, s->n, way), rise = steep * net->length[k], part = steep * steep;
        const double w = (part * s->kn + (1 - part) * s->kt) * fabs(rise);
        weight += w;
        sum += w * (height_of(net, s->i) + 0.5 * rise - low * net->box[up]);
    }
    return weight > 0 ? sum / weight : NAN;
}

sp_status sp_network_detector_at(const sp_network *net, const sp_place *at, double *out, sp_error *err) {
    int32_t row;
    sp_status status = begin(net, at, false, out, &row, err);
    if (status != SP_OK)
        return status;
    if (at->kind == SP_PLACE_PLANE) {
        if (add_plane(net, at, out) == 0)
            return sp_fail(err, SP_EREFUSED, "no carrying contact crosses the plane at %g", at->height);
        return SP_OK;
    }
    if (add_wall(net, at, SP_TOP, out) > 0)
        return SP_OK;
    if (row < 0)
        return nothing_there(at, "top", "detected", err);
    status = need_directions(net, "a grain that does not touch the top wall", err);
    if (status != SP_OK)
        return status;
    for (int32_t k = 0; k < net->n_springs; k++)
        if (net->springs[k].i == row || net->springs[k].j == row)
            add_force(net, at, k, net->springs[k].i == row ? 0 : 1, out);
    return SP_OK;
}

/* Whether a spring is one of those of a wall that a place acts through. */
static bool acts(const sp_network *net, const sp_place *at, int32_t wall, int32_t k) {
    const sp_spring *s = &net->springs[k];
    return at->kind != SP_PLACE_PLANE && s->j == wall && belongs(net, at, s) && !(at->shear && s->kt == 0);
}

/* The end of a spring on which a detector without a wall sees the force: -1 for i, 1 for the far end, 0 for none. */
static int seen_end(const sp_network *net, const sp_place *at, int32_t k) {
    const sp_spring *s = &net->springs[k];
    int32_t low;
    if (at->kind == SP_PLACE_PLANE)
        return crossing(net, k, at->height, &low) < 0 ? -1 : crossing(net, k, at->height, &low) > 0;
    if (net->grain[s->i] == at->grain)
        return -1;
    return s->j >= 0 && net->grain[s->j] == at->grain;
}

void sp_place_gaps(const sp_network *net, const sp_place *at, bool source, double *gap) {
    const int32_t wall = source ? SP_BOTTOM : SP_TOP;
    bool walls = false;
    for (int64_t k = 0; k < 3 * (int64_t)net->n_springs; k++)
        gap[k] = 0;
    for (int32_t k = net->n_bulk; k < net->n_springs; k++)
        if (acts(net, at, wall, k)) {
            set_way(net, wall, at->shear, net->springs[k].n, gap + 3 * (int64_t)k);
            walls = true;
        }
    for (int32_t k = 0; k < net->n_springs && !walls && !source; k++) {
        double way[3];
        way_of(net, at, &net->springs[k], way);
        for (int a = 0; a < net->dim; a++)
            gap[3 * (int64_t)k + a] = seen_end(net, at, k) * way[a] + 0.0;
    }
}

bool sp_network_touches(const sp_network *net, int32_t wall) {
    for (int32_t k = net->n_bulk; k < net->n_springs; k++)
        if (net->springs[k].j == wall)
            return true;
    return false;
}

sp_status sp_network_source(const sp_network *net, sp_source source, double *out, sp_error *err) {
    const sp_place wall = sp_place_wall();
    return sp_network_source_at(net, source, &wall, out, err);
}

sp_status sp_network_detector(const sp_network *net, double *out, sp_error *err) {
    const sp_place wall = sp_place_wall();
    return sp_network_detector_at(net, &wall, out, err);
}

/* ---- text: "plane:12.5:shear" ------------------------------------------------------------------------------------ */

static const char *wall_of(bool source) { return source ? "bottom" : "top"; }

static sp_status wrong(const char *text, bool source, sp_error *err) {
    return sp_fail(err, SP_EINVAL,
                   "%.60s: must be %s, part:X0:X1 with X0 below X1, disc:X:Y:DIAMETER, plane:Y or grain:I, optionally "
                   "followed by :normal or :shear",
                   text, wall_of(source));
}

/* A length on the command line. */
static bool read_length(const char *word, double *out) { return sp_word_number(word, out) && *out >= 0 && *out <= 1e9; }

/* Whether the words name a place; a component has been taken off. */
static bool read_words(int count, char *const *word, bool source, sp_place *at) {
    int64_t grain;
    if (count == 0 ||
        (count == 1 && (strcmp(word[0], wall_of(source)) == 0 || strcmp(word[0], source ? "inner" : "outer") == 0)))
        return true;
    if (count == 2 && strcmp(word[0], "grain") == 0) {
        at->kind = SP_PLACE_GRAIN;
        const bool good = sp_word_integer(word[1], &grain) && grain >= 0 && grain <= INT32_MAX;
        at->grain = good ? (int32_t)grain : 0;
        return good;
    }
    if (count == 2 && strcmp(word[0], "plane") == 0) {
        at->kind = SP_PLACE_PLANE;
        return read_length(word[1], &at->height);
    }
    if (count == 4 && strcmp(word[0], "disc") == 0) {
        at->kind = SP_PLACE_DISC;
        return read_length(word[1], &at->x) && read_length(word[2], &at->y) && read_length(word[3], &at->diameter) &&
               at->diameter > 0;
    }
    at->kind = SP_PLACE_PART;
    return count == 3 && strcmp(word[0], "part") == 0 && read_length(word[1], &at->from) &&
           read_length(word[2], &at->to) && at->from < at->to;
}

sp_status sp_place_read(const char *text, bool source, sp_place *out, bool *component, sp_error *err) {
    char copy[200], *word[5] = {NULL}, *rest = copy;
    sp_place at = sp_place_wall();
    int count = 0;
    if (strlen(text) >= sizeof copy)
        return wrong(text, source, err);
    strcpy(copy, text);
    while (rest && count < 5)
        word[count++] = strsep(&rest, ":");
    at.shear = strcmp(word[count - 1], "shear") == 0;
    const bool given = at.shear || strcmp(word[count - 1], "normal") == 0;
    if (rest || !read_words(count - given, word, source, &at))
        return wrong(text, source, err);
    if (component)
        *component = given;
    *out = at;
    return SP_OK;
}

char *sp_place_text(const sp_place *at, bool source, char text[SP_PLACE_TEXT]) {
    const char *component = at->shear ? "shear" : "normal";
    char one[SP_NUMBER_TEXT], two[SP_NUMBER_TEXT], three[SP_NUMBER_TEXT];
    switch (at->kind) {
    case SP_PLACE_WALL: snprintf(text, SP_PLACE_TEXT, "%s:%s", wall_of(source), component); break;
    case SP_PLACE_GRAIN: snprintf(text, SP_PLACE_TEXT, "grain:%d:%s", at->grain, component); break;
    case SP_PLACE_PLANE:
        snprintf(text, SP_PLACE_TEXT, "plane:%s:%s", sp_number_text(at->height, one), component);
        break;
    case SP_PLACE_PART:
        snprintf(text, SP_PLACE_TEXT, "part:%s:%s:%s", sp_number_text(at->from, one), sp_number_text(at->to, two),
                 component);
        break;
    case SP_PLACE_DISC:
        snprintf(text, SP_PLACE_TEXT, "disc:%s:%s:%s:%s", sp_number_text(at->x, one), sp_number_text(at->y, two),
                 sp_number_text(at->diameter, three), component);
        break;
    }
    return text;
}
