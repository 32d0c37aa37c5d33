/* Reads HDF5 files. The type and the extents of every dataset are checked, and no size is accepted that exceeds what
 * the file can hold. */
#include "base/base.h"
#include "store/h5.h"

#include <stdio.h>
#include <string.h>

/* ---- how a dataset is stored --------------------------------------------------------------------------------------
 */

/* Deflate compresses zeros 1032 to 1, so no valid dataset has more data per byte of its file. */
static const uint64_t packing_limit = 1100;

/* To read a single number HDF5 takes memory for the whole chunk, which may be far larger than the data. Other programs
 * write one chunk a frame: it may be larger if the file holds a good part of it. */
static const uint64_t chunk_limit = (uint64_t)1 << 26, chunk_packing = 16;

/* HDF5 spends up to 0.2 ms on a chunk however small it is. A dataset may have so many, and one more for every so many
 * bytes. That allows for vectors of modes, which have a chunk a row and no more rows than columns. */
enum { CHUNKS_OF_ANY = 1024, BYTES_OF_CHUNK = 1024 };

typedef struct layout {
    H5D_layout_t kind;
    bool inside;      /* the data are in the file itself */
    bool deflated;    /* once */
    bool foreign;     /* uses a filter that nobody here needs, or one twice */
    uint64_t element; /* bytes on the disk */
    uint64_t bytes;   /* of all elements */
    uint64_t chunk;   /* bytes of a chunk; UINT64_MAX: more than a number can count */
    uint64_t chunks;
    uint64_t row;  /* bytes of what no chunk can divide but by columns */
    uint64_t held; /* bytes in the file */
} layout;

static uint64_t product(uint64_t a, uint64_t b) { return __builtin_mul_overflow(a, b, &a) ? UINT64_MAX : a; }

static void judge_chunks(hid_t dcpl, const sp_h5_shape *shape, layout *l) {
    hsize_t chunk[SP_H5_RANK] = {0};
    const int rank = H5Pget_chunk(dcpl, SP_H5_RANK, chunk);
    l->chunk = l->element;
    l->chunks = 1;
    for (int k = 0; k < rank && k < SP_H5_RANK; k++) {
        const uint64_t size = chunk[k] > 0 ? chunk[k] : 1;
        l->chunk = product(l->chunk, size);
        l->chunks = product(l->chunks, ((uint64_t)shape->dim[k] + size - 1) / size);
    }
}

/* An unknown filter would make HDF5 look for a plugin on this machine and load it. */
static void judge_filters(hid_t dcpl, layout *l) {
    unsigned seen = 0;
    const int count = H5Pget_nfilters(dcpl);
    for (int k = 0; k < count; k++) {
        unsigned flags, config;
        size_t values = 0;
        const H5Z_filter_t filter = H5Pget_filter2(dcpl, (unsigned)k, &flags, &values, NULL, 0, NULL, &config);
        const bool known =
            filter == H5Z_FILTER_DEFLATE || filter == H5Z_FILTER_SHUFFLE || filter == H5Z_FILTER_FLETCHER32;
        l->foreign = l->foreign || !known || seen & 1u << filter;
        l->deflated = l->deflated || filter == H5Z_FILTER_DEFLATE;
        seen |= known ? 1u << filter : 0;
    }
}

static layout layout_of(sp_h5 *h, hid_t set, const sp_h5_shape *shape, size_t element) {
    hid_t dcpl = H5Dget_create_plist(set);
    layout l = {.kind = dcpl >= 0 ? H5Pget_layout(dcpl) : H5D_LAYOUT_ERROR, .element = element, .bytes = element};
    l.inside = l.kind == H5D_COMPACT || l.kind == H5D_CHUNKED ||
               (l.kind == H5D_CONTIGUOUS && H5Pget_external_count(dcpl) == 0);
    l.row = element;
    for (int k = 0, split = 0; k < shape->rank; k++) {
        l.bytes = product(l.bytes, (uint64_t)shape->dim[k]);
        l.row = split ? product(l.row, (uint64_t)shape->dim[k]) : l.row;
        split = split || shape->dim[k] != 1;
    }
    const hsize_t kept = l.bytes > 0 ? H5Dget_storage_size(set) : 0;
    l.held = kept < h->size ? kept : h->size;
    if (l.kind == H5D_CHUNKED) {
        judge_chunks(dcpl, shape, &l);
        judge_filters(dcpl, &l);
    }
    if (dcpl >= 0)
        H5Pclose(dcpl);
    return l;
}

static sp_status check_chunks(sp_h5 *h, const char *path, const layout *l) {
    const uint64_t many = CHUNKS_OF_ANY + l->bytes / BYTES_OF_CHUNK, held = product(chunk_packing, l->held);
    const uint64_t least = l->row > chunk_limit ? l->row : chunk_limit, most = held > least ? held : least;
    if (l->foreign)
        return sp_h5_fail(h, SP_EFORMAT,
                          "%s uses a filter that is unknown here, or one twice; must be deflate (gzip), shuffle and "
                          "fletcher32, or none",
                          path);
    if (l->chunk > most)
        return sp_h5_fail(h, SP_EFORMAT, "%s has chunks of %.3g MB; must be at most %.3g", path,
                          (double)l->chunk * 1e-6, (double)most * 1e-6);
    if (l->chunks > many)
        return sp_h5_fail(h, SP_EFORMAT, "%s has %llu chunks for %.3g MB; must have at most %llu", path,
                          (unsigned long long)l->chunks, (double)l->bytes * 1e-6, (unsigned long long)many);
    return SP_OK;
}

/* What HDF5 would take of memory and time for a dataset must be in proportion to what the file holds: judged before
 * anything of it is read. element: its bytes on the disk. */
static sp_status check_layout(sp_h5 *h, hid_t set, const char *path, const sp_h5_shape *shape, size_t element) {
    const layout l = layout_of(h, set, shape, element);
    if (l.kind == H5D_LAYOUT_ERROR) /* of a dataset that is open: HDF5 has found no memory for its properties */
        return sp_h5_fail(h, SP_ENOMEM, "no memory: cannot read the layout of %s", path);
    if (!l.inside)
        return sp_h5_fail(h, SP_EFORMAT, "%s keeps its data elsewhere; must be in the file itself", path);
    sp_status status = l.kind == H5D_CHUNKED ? check_chunks(h, path, &l) : SP_OK;
    if (status != SP_OK)
        return status;
    if (l.bytes / (l.deflated ? packing_limit : 1) > l.held || (l.bytes > 0 && l.held == 0))
        return sp_h5_fail(h, SP_EFORMAT, "%s claims %.3g MB, which the file does not hold", path,
                          (double)l.bytes * 1e-6);
    return SP_OK;
}

/* ---- datasets -------------------------------------------------------------------------------------------------- */

/* Whether a path exists. Every part of it must be a hard link, so that no link leads into another file. */
static bool path_exists(sp_h5 *h, const char *path) {
    char part[256];
    for (const char *end = path; *end;) {
        end += strcspn(end + 1, "/") + 1;
        H5L_info_t info;
        int length = snprintf(part, sizeof part, "%.*s", (int)(end - path), path);
        if (length >= (int)sizeof part || H5Lexists(h->file, part, H5P_DEFAULT) <= 0 ||
            H5Lget_info(h->file, part, &info, H5P_DEFAULT) < 0 || info.type != H5L_TYPE_HARD)
            return false;
    }
    return true;
}

bool sp_h5_has(sp_h5 *h, const char *path) {
    if (h->status != SP_OK)
        return false;
    const bool has = path_exists(h, path);
    if (!has && (h->code != 0 || sp_h5_short_of_memory()))
        sp_h5_fail(h, SP_EFORMAT, "%s cannot be read", path);
    H5Eclear2(H5E_DEFAULT);
    return has;
}

static const char *type_name(H5T_class_t class) {
    return class == H5T_FLOAT ? "floating point" : class == H5T_INTEGER ? "integer" : "text";
}

static H5T_class_t class_of(sp_h5_type type) { return type == SP_H5_F64 ? H5T_FLOAT : H5T_INTEGER; }

/* Whether a type, which is closed, is of this class. *size: its bytes on the disk. */
static bool is_type(hid_t type, H5T_class_t class, size_t *size) {
    *size = type >= 0 ? H5Tget_size(type) : 0;
    const bool good = type >= 0 && H5Tget_class(type) == class && (class == H5T_STRING || *size <= 8);
    if (type >= 0)
        H5Tclose(type);
    return good;
}

static sp_status read_shape(sp_h5 *h, hid_t set, const char *path, int rank, sp_h5_shape *shape) {
    hid_t space = H5Dget_space(set);
    hsize_t dims[SP_H5_RANK] = {0};
    int found = space >= 0 && H5Sis_simple(space) > 0 ? H5Sget_simple_extent_ndims(space) : -1;
    H5S_class_t class = space >= 0 ? H5Sget_simple_extent_type(space) : H5S_NO_CLASS;
    if (found == rank && rank > 0 && H5Sget_simple_extent_dims(space, dims, NULL) != rank)
        found = -1;
    if (space >= 0)
        H5Sclose(space);
    if (found != rank || class == H5S_NULL)
        return sp_h5_fail(h, SP_EFORMAT, "%s has %d axes; must be %d", path, found, rank);
    *shape = (sp_h5_shape){.rank = rank};
    for (int k = 0; k < rank; k++) {
        if (dims[k] > INT32_MAX)
            return sp_h5_fail(h, SP_EFORMAT, "%s has %llu entries along axis %d; at most %d", path,
                              (unsigned long long)dims[k], k, INT32_MAX);
        shape->dim[k] = (int64_t)dims[k];
    }
    return SP_OK;
}

static sp_status check_extents(sp_h5 *h, const char *path, const sp_h5_shape *found, const sp_h5_shape *expected) {
    for (int k = 0; k < found->rank; k++)
        if (found->dim[k] != expected->dim[k])
            return sp_h5_fail(h, SP_EFORMAT, "%s has %lld entries along axis %d; must be %lld", path,
                              (long long)found->dim[k], k, (long long)expected->dim[k]);
    return SP_OK;
}

/* Opens a dataset, and checks its type, its rank, how it is stored, and its extents unless expected is NULL. Negative
 * if the file has failed. */
static hid_t open_dataset(sp_h5 *h, const char *path, H5T_class_t class, int rank, const sp_h5_shape *expected,
                          sp_h5_shape *found) {
    size_t element;
    if (h->status != SP_OK)
        return H5I_INVALID_HID;
    if (!path_exists(h, path)) {
        sp_h5_fail(h, SP_EFORMAT, "no dataset %s", path);
        return H5I_INVALID_HID;
    }
    const hid_t set = H5Dopen2(h->file, path, H5P_DEFAULT);
    if (set < 0)
        sp_h5_fail(h, SP_EFORMAT, "%s is no intact dataset", path);
    else if (!is_type(H5Dget_type(set), class, &element))
        sp_h5_fail(h, SP_EFORMAT, "%s has the wrong type; must be %s", path, type_name(class));
    else if (read_shape(h, set, path, rank, found) == SP_OK && check_layout(h, set, path, found, element) == SP_OK &&
             expected)
        check_extents(h, path, found, expected);
    if (h->status == SP_OK)
        return set;
    if (set >= 0)
        H5Dclose(set);
    return H5I_INVALID_HID;
}

/* Closes a dataset. */
static sp_status end_dataset(sp_h5 *h, hid_t set, const char *path, bool read) {
    if (!read)
        sp_h5_fail(h, SP_EFORMAT, "%s cannot be read", path);
    H5Dclose(set);
    return h->status;
}

sp_status sp_h5_find(sp_h5 *h, const char *path, sp_h5_type type, int rank, sp_h5_shape *shape) {
    const hid_t set = open_dataset(h, path, class_of(type), rank, NULL, shape);
    return set < 0 ? h->status : end_dataset(h, set, path, true);
}

sp_status sp_h5_get(sp_h5 *h, const char *path, sp_h5_type type, const sp_h5_shape *expected, void *data) {
    sp_h5_shape shape;
    const hid_t set = open_dataset(h, path, class_of(type), expected->rank, expected, &shape);
    if (set < 0)
        return h->status;
    return end_dataset(h, set, path,
                       !data || H5Dread(set, sp_h5_memory_type(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
}

sp_status sp_h5_get_fields(sp_h5 *h, int count, const sp_h5_field *field, void *to) {
    const sp_h5_shape single = {0};
    for (const sp_h5_field *f = field; f < field + count; f++)
        sp_h5_get(h, f->name.path, f->type, &single, (char *)to + f->offset);
    return h->status;
}

/* Reads part of an open dataset. */
static bool read_rows(hid_t set, sp_h5_type type, int64_t width, int64_t first, int64_t count, void *data) {
    const hsize_t from[2] = {(hsize_t)first, 0}, size[2] = {(hsize_t)count, (hsize_t)width};
    hid_t memory = H5Screate_simple(2, size, NULL), space = H5Dget_space(set);
    const bool good = memory >= 0 && space >= 0 &&
                      H5Sselect_hyperslab(space, H5S_SELECT_SET, from, NULL, size, NULL) >= 0 &&
                      H5Dread(set, sp_h5_memory_type(type), memory, space, H5P_DEFAULT, data) >= 0;
    H5Sclose(space);
    H5Sclose(memory);
    return good;
}

sp_status sp_h5_get_rows(sp_h5 *h, const char *path, sp_h5_type type, const sp_h5_shape *expected, int64_t first,
                         int64_t count, void *data) {
    sp_h5_shape shape;
    const hid_t set = open_dataset(h, path, class_of(type), expected->rank, expected, &shape);
    if (set < 0)
        return h->status;
    return end_dataset(h, set, path, count == 0 || read_rows(set, type, shape.dim[1], first, count, data));
}

/* ---- texts ----------------------------------------------------------------------------------------------------- */

/* Texts have a fixed length; Python writes texts of variable length. False if it cannot be read. */
static bool read_text(sp_h5 *h, hid_t set, hid_t type, char **text) {
    char *buffer = NULL;
    if (H5Tis_variable_str(type) <= 0) {
        *text = sp_h5_alloc(h, (int64_t)H5Tget_size(type) + 1, 1);
        return !*text || H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text) >= 0;
    }
    const bool good = H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &buffer) >= 0;
    if (good && (*text = sp_h5_alloc(h, (int64_t)strlen(buffer ? buffer : "") + 1, 1)) && buffer)
        memcpy(*text, buffer, strlen(buffer));
    if (buffer) {
        hid_t space = H5Dget_space(set);
        H5Dvlen_reclaim(type, space, H5P_DEFAULT, &buffer);
        H5Sclose(space);
    }
    return good;
}

sp_status sp_h5_get_text(sp_h5 *h, const char *path, char **text) {
    sp_h5_shape shape;
    const hid_t set = open_dataset(h, path, H5T_STRING, 0, NULL, &shape);
    *text = NULL;
    if (set < 0)
        return h->status;
    hid_t type = H5Dget_type(set);
    const bool good = read_text(h, set, type, text);
    H5Tclose(type);
    if (end_dataset(h, set, path, good) != SP_OK) {
        sp_free(*text);
        *text = NULL;
    }
    return h->status;
}

sp_status sp_h5_get_word(sp_h5 *h, const char *path, const char *const *words, int *out) {
    char *text = NULL, list[120] = "";
    int word = 0;
    if (sp_h5_get_text(h, path, &text) != SP_OK)
        return h->status;
    while (words[word] && strcmp(text, words[word]) != 0)
        word++;
    for (int k = 0; words[k]; k++)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s",
                 k == 0         ? ""
                 : words[k + 1] ? ", "
                                : " or ",
                 words[k]);
    if (words[word])
        *out = word;
    else
        sp_h5_fail(h, SP_EFORMAT, "%s is '%.60s'; must be %s", path, text, list);
    sp_free(text);
    return h->status;
}

/* ---- attributes ------------------------------------------------------------------------------------------------ */

/* Opens an attribute of this class with `count` entries; 0: a single value. Negative if the file has failed. */
static hid_t open_attribute(sp_h5 *h, const char *object, const char *name, H5T_class_t class, int count) {
    hid_t attribute = H5I_INVALID_HID;
    size_t size;
    if (h->status != SP_OK)
        return attribute;
    if (!path_exists(h, object))
        sp_h5_fail(h, SP_EFORMAT, "no group %s", object);
    else if (H5Aexists_by_name(h->file, object, name, H5P_DEFAULT) <= 0)
        sp_h5_fail(h, SP_EFORMAT, "no attribute %s of %s", name, object);
    else if ((attribute = H5Aopen_by_name(h->file, object, name, H5P_DEFAULT, H5P_DEFAULT)) < 0)
        sp_h5_fail(h, SP_EFORMAT, "the attribute %s of %s is damaged", name, object);
    if (h->status != SP_OK)
        return H5I_INVALID_HID;
    hid_t space = H5Aget_space(attribute);
    const bool good = is_type(H5Aget_type(attribute), class, &size) && space >= 0 &&
                      H5Sget_simple_extent_npoints(space) == (count ? count : 1);
    if (space >= 0)
        H5Sclose(space);
    if (good)
        return attribute;
    H5Aclose(attribute);
    sp_h5_fail(h, SP_EFORMAT, "the attribute %s of %s has the wrong type or size; must be %d of %s", name, object,
               count ? count : 1, type_name(class));
    return H5I_INVALID_HID;
}

sp_status sp_h5_attribute_int(sp_h5 *h, const char *object, const char *name, int64_t *value) {
    const hid_t attribute = open_attribute(h, object, name, H5T_INTEGER, 0);
    if (attribute < 0)
        return h->status;
    if (H5Aread(attribute, H5T_NATIVE_INT64, value) < 0)
        sp_h5_fail(h, SP_EFORMAT, "the attribute %s of %s cannot be read", name, object);
    H5Aclose(attribute);
    return h->status;
}

/* Compares entries of fixed width to those expected. */
static bool fixed_texts_equal(hid_t attribute, hid_t type, int count, const char *const *text) {
    char buffer[SP_H5_RANK * 64 + 1] = {0};
    size_t width = H5Tget_size(type);
    if (width == 0 || width > 64 || count > SP_H5_RANK || H5Aread(attribute, type, buffer) < 0)
        return false;
    bool equal = true;
    for (int k = 0; k < count; k++)
        equal = equal && strncmp(buffer + (size_t)k * width, text[k], width) == 0 && strlen(text[k]) <= width;
    return equal;
}

static bool variable_texts_equal(hid_t attribute, hid_t type, int count, const char *const *text) {
    char *entry[SP_H5_RANK] = {0};
    if (count > SP_H5_RANK || H5Aread(attribute, type, entry) < 0)
        return false;
    bool equal = true;
    for (int k = 0; k < count; k++)
        equal = equal && entry[k] && strcmp(entry[k], text[k]) == 0;
    hid_t space = H5Aget_space(attribute);
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, entry);
    H5Sclose(space);
    return equal;
}

sp_status sp_h5_check_texts(sp_h5 *h, const char *object, const char *name, int count, const char *const *text) {
    const hid_t attribute = open_attribute(h, object, name, H5T_STRING, count);
    if (attribute < 0)
        return h->status;
    hid_t type = H5Aget_type(attribute);
    bool equal = H5Tis_variable_str(type) > 0 ? variable_texts_equal(attribute, type, count, text)
                                              : fixed_texts_equal(attribute, type, count, text);
    H5Tclose(type);
    H5Aclose(attribute);
    if (equal)
        return SP_OK;
    char list[200] = "";
    for (int k = 0; k < count; k++) {
        size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", k ? ", " : "", text[k]);
    }
    return sp_h5_fail(h, SP_EFORMAT, "the attribute %s of %s must be: %s", name, object, list);
}
