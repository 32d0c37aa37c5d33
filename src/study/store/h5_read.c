/* Reads HDF5 files. The type and the extents of every dataset are checked, and no size is accepted that exceeds what
 * the file can hold (h5_layout.c). */
#include "base/base.h"
#include "store/h5.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

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
    bool has = path_exists(h, path);
    if (!has && h->code == 0 && sp_h5_short_of_memory())
        h->code = ENOMEM;
    H5Eclear2(H5E_DEFAULT);
    return has || h->code != 0;
}

static const char *type_name(H5T_class_t class) {
    return class == H5T_FLOAT ? "floating point" : class == H5T_INTEGER ? "integer" : "text";
}

static H5T_class_t class_of(sp_h5_type type) { return type == SP_H5_F64 ? H5T_FLOAT : H5T_INTEGER; }

static sp_status check_type(sp_h5 *h, hid_t set, const char *path, H5T_class_t class, sp_error *err) {
    hid_t type = H5Dget_type(set);
    bool good = type >= 0 && H5Tget_class(type) == class && (class == H5T_STRING || H5Tget_size(type) <= 8);
    if (type >= 0)
        H5Tclose(type);
    return good ? SP_OK : sp_h5_fail(h, err, SP_EFORMAT, "%s has the wrong type; must be %s", path, type_name(class));
}

static sp_status read_shape(sp_h5 *h, hid_t set, const char *path, int rank, sp_h5_shape *shape, sp_error *err) {
    hid_t space = H5Dget_space(set);
    hsize_t dims[SP_H5_RANK] = {0};
    int found = space >= 0 && H5Sis_simple(space) > 0 ? H5Sget_simple_extent_ndims(space) : -1;
    H5S_class_t class = space >= 0 ? H5Sget_simple_extent_type(space) : H5S_NO_CLASS;
    if (found == rank && rank > 0 && H5Sget_simple_extent_dims(space, dims, NULL) != rank)
        found = -1;
    if (space >= 0)
        H5Sclose(space);
    if (found != rank || class == H5S_NULL)
        return sp_h5_fail(h, err, SP_EFORMAT, "%s has %d axes; must be %d", path, found, rank);
    shape->rank = rank;
    for (int k = 0; k < rank; k++) {
        if (dims[k] > INT32_MAX)
            return sp_h5_fail(h, err, SP_EFORMAT, "%s has %llu entries along axis %d; at most %d", path,
                              (unsigned long long)dims[k], k, INT32_MAX);
        shape->dim[k] = (int64_t)dims[k];
    }
    return SP_OK;
}

static sp_status open_dataset(sp_h5 *h, const char *path, hid_t *set, sp_error *err) {
    if (!path_exists(h, path))
        return sp_h5_fail(h, err, SP_EFORMAT, "no dataset %s", path);
    *set = H5Dopen2(h->file, path, H5P_DEFAULT);
    return *set >= 0 ? SP_OK : sp_h5_fail(h, err, SP_EFORMAT, "%s is no intact dataset", path);
}

static size_t disk_size(hid_t set) {
    hid_t type = H5Dget_type(set);
    const size_t size = type >= 0 ? H5Tget_size(type) : 0;
    if (type >= 0)
        H5Tclose(type);
    return size;
}

/* Checks type, rank and storage of an open dataset. */
static sp_status look_at(sp_h5 *h, hid_t set, const char *path, sp_h5_type type, sp_h5_shape *shape, sp_error *err) {
    sp_status status = check_type(h, set, path, class_of(type), err);
    if (status == SP_OK)
        status = read_shape(h, set, path, shape->rank, shape, err);
    return status == SP_OK ? sp_h5_check_layout(h, set, path, shape, disk_size(set), err) : status;
}

sp_status sp_h5_find(sp_h5 *h, const char *path, sp_h5_type type, int rank, sp_h5_shape *shape, sp_error *err) {
    hid_t set = H5I_INVALID_HID;
    sp_status status = open_dataset(h, path, &set, err);
    if (status != SP_OK)
        return status;
    *shape = (sp_h5_shape){.rank = rank};
    status = look_at(h, set, path, type, shape, err);
    H5Dclose(set);
    return status;
}

static sp_status check_extents(sp_h5 *h, const char *path, const sp_h5_shape *found, const sp_h5_shape *expected,
                               sp_error *err) {
    for (int k = 0; k < found->rank; k++)
        if (found->dim[k] != expected->dim[k])
            return sp_h5_fail(h, err, SP_EFORMAT, "%s has %lld entries along axis %d; must be %lld", path,
                              (long long)found->dim[k], k, (long long)expected->dim[k]);
    return SP_OK;
}

sp_status sp_h5_get(sp_h5 *h, const char *path, sp_h5_type type, const sp_h5_shape *expected, void *data,
                    sp_error *err) {
    hid_t set = H5I_INVALID_HID;
    sp_status status = open_dataset(h, path, &set, err);
    if (status != SP_OK)
        return status;
    sp_h5_shape shape = {.rank = expected->rank};
    status = look_at(h, set, path, type, &shape, err);
    if (status == SP_OK)
        status = check_extents(h, path, &shape, expected, err);
    if (status == SP_OK && data && H5Dread(set, sp_h5_memory_type(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
        status = sp_h5_fail(h, err, SP_EFORMAT, "%s cannot be read", path);
    H5Dclose(set);
    return status;
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
                         int64_t count, void *data, sp_error *err) {
    hid_t set = H5I_INVALID_HID;
    sp_status status = open_dataset(h, path, &set, err);
    if (status != SP_OK)
        return status;
    sp_h5_shape shape = {.rank = expected->rank};
    status = look_at(h, set, path, type, &shape, err);
    if (status == SP_OK)
        status = check_extents(h, path, &shape, expected, err);
    if (status == SP_OK && count > 0 && !read_rows(set, type, shape.dim[1], first, count, data))
        status = sp_h5_fail(h, err, SP_EFORMAT, "%s cannot be read", path);
    H5Dclose(set);
    return status;
}

/* ---- texts ----------------------------------------------------------------------------------------------------- */

/* Texts have a fixed length; Python writes texts of variable length. */
static sp_status read_fixed(sp_h5 *h, hid_t set, hid_t type, const char *path, char **text, sp_error *err) {
    const size_t size = H5Tget_size(type);
    char *buffer = sp_alloc(size + 1, 1);
    if (!buffer)
        return sp_fail_memory(err, size);
    if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, buffer) < 0) {
        sp_free(buffer);
        return sp_h5_fail(h, err, SP_EFORMAT, "%s cannot be read", path);
    }
    *text = buffer;
    return SP_OK;
}

static sp_status read_variable(sp_h5 *h, hid_t set, hid_t type, const char *path, char **text, sp_error *err) {
    char *buffer = NULL;
    hid_t space = H5Dget_space(set);
    sp_status status = SP_OK;
    if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, &buffer) < 0)
        status = sp_h5_fail(h, err, SP_EFORMAT, "%s cannot be read", path);
    if (status == SP_OK && !(*text = sp_strdup(buffer ? buffer : "")))
        status = sp_fail_memory(err, 1);
    if (buffer)
        H5Dvlen_reclaim(type, space, H5P_DEFAULT, &buffer);
    H5Sclose(space);
    return status;
}

sp_status sp_h5_get_text(sp_h5 *h, const char *path, char **text, sp_error *err) {
    hid_t set = H5I_INVALID_HID;
    sp_status status = open_dataset(h, path, &set, err);
    if (status != SP_OK)
        return status;
    sp_h5_shape shape;
    status = check_type(h, set, path, H5T_STRING, err);
    if (status == SP_OK)
        status = read_shape(h, set, path, 0, &shape, err);
    if (status == SP_OK)
        status = sp_h5_check_layout(h, set, path, &shape, disk_size(set), err);
    if (status == SP_OK) {
        hid_t type = H5Dget_type(set);
        status = H5Tis_variable_str(type) > 0 ? read_variable(h, set, type, path, text, err)
                                              : read_fixed(h, set, type, path, text, err);
        H5Tclose(type);
    }
    H5Dclose(set);
    return status;
}

/* ---- attributes ------------------------------------------------------------------------------------------------ */

/* Opens an attribute of this class with `count` entries; 0: a single value. */
static sp_status open_attribute(sp_h5 *h, const char *object, const char *name, H5T_class_t class, int count,
                                hid_t *attribute, sp_error *err) {
    if (!path_exists(h, object))
        return sp_h5_fail(h, err, SP_EFORMAT, "no group %s", object);
    if (H5Aexists_by_name(h->file, object, name, H5P_DEFAULT) <= 0)
        return sp_h5_fail(h, err, SP_EFORMAT, "no attribute %s of %s", name, object);
    *attribute = H5Aopen_by_name(h->file, object, name, H5P_DEFAULT, H5P_DEFAULT);
    if (*attribute < 0)
        return sp_h5_fail(h, err, SP_EFORMAT, "the attribute %s of %s is damaged", name, object);
    hid_t type = H5Aget_type(*attribute), space = H5Aget_space(*attribute);
    bool good = type >= 0 && H5Tget_class(type) == class && (class == H5T_STRING || H5Tget_size(type) <= 8);
    good = good && space >= 0 && H5Sget_simple_extent_npoints(space) == (count ? count : 1);
    if (type >= 0)
        H5Tclose(type);
    if (space >= 0)
        H5Sclose(space);
    if (good)
        return SP_OK;
    H5Aclose(*attribute);
    return sp_h5_fail(h, err, SP_EFORMAT, "the attribute %s of %s has the wrong type or size; must be %d of %s", name,
                      object, count ? count : 1, type_name(class));
}

sp_status sp_h5_attribute_int(sp_h5 *h, const char *object, const char *name, int64_t *value, sp_error *err) {
    hid_t attribute = H5I_INVALID_HID;
    sp_status status = open_attribute(h, object, name, H5T_INTEGER, 0, &attribute, err);
    if (status != SP_OK)
        return status;
    if (H5Aread(attribute, H5T_NATIVE_INT64, value) < 0)
        status = sp_h5_fail(h, err, SP_EFORMAT, "the attribute %s of %s cannot be read", name, object);
    H5Aclose(attribute);
    return status;
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

sp_status sp_h5_check_texts(sp_h5 *h, const char *object, const char *name, int count, const char *const *text,
                            sp_error *err) {
    hid_t attribute = H5I_INVALID_HID;
    sp_status status = open_attribute(h, object, name, H5T_STRING, count, &attribute, err);
    if (status != SP_OK)
        return status;
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
    return sp_h5_fail(h, err, SP_EFORMAT, "the attribute %s of %s must be: %s", name, object, list);
}
