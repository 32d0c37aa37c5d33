/* Writes groups, attributes and datasets. */
#include "base/base.h"
#include "store/h5.h"

#include <math.h>
#include <string.h>

/* Data up to this size go into the object's header, larger data into chunks. Both have checksums. */
static const size_t compact_limit = 32768, chunk_limit = (size_t)1 << 19;

static hid_t disk_type(sp_h5_type type) {
    switch (type) {
    case SP_H5_F64: return H5T_IEEE_F64LE;
    case SP_H5_I32: return H5T_STD_I32LE;
    case SP_H5_I64: return H5T_STD_I64LE;
    case SP_H5_U64: return H5T_STD_U64LE;
    case SP_H5_U8: return H5T_STD_U8LE;
    }
    return H5I_INVALID_HID;
}

void sp_h5_group(sp_h5 *h, const char *path) {
    if (h->status != SP_OK)
        return;
    hid_t gcpl = H5Pcreate(H5P_GROUP_CREATE), group = H5I_INVALID_HID;
    /* no time stamps, so that equal data give equal bytes; up to 64 links in the header of the group */
    if (gcpl >= 0 && H5Pset_obj_track_times(gcpl, false) >= 0 && H5Pset_link_phase_change(gcpl, 64, 32) >= 0)
        group = H5Gcreate2(h->file, path, H5P_DEFAULT, gcpl, H5P_DEFAULT);
    H5Pclose(gcpl);
    if (group < 0 || H5Gclose(group) < 0)
        sp_h5_fail(h, SP_ENOMEM, "cannot put %s into the file", path);
}

/* ---- attributes ------------------------------------------------------------------------------------------------ */

/* Octave reads ASCII, but no UTF-8: most texts are both. */
static hid_t text_type(size_t length, bool ascii) {
    const H5T_cset_t set = ascii ? H5T_CSET_ASCII : H5T_CSET_UTF8;
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type >= 0 && (H5Tset_size(type, length ? length : 1) < 0 || H5Tset_cset(type, set) < 0 ||
                      H5Tset_strpad(type, H5T_STR_NULLPAD) < 0)) {
        H5Tclose(type);
        type = H5I_INVALID_HID;
    }
    return type;
}

static void put_attribute(sp_h5 *h, const char *object, const char *name, int count, hid_t type, const void *data) {
    hsize_t dim = (hsize_t)count;
    if (h->status != SP_OK)
        return;
    hid_t space = count ? H5Screate_simple(1, &dim, NULL) : H5Screate(H5S_SCALAR);
    hid_t attribute = H5I_INVALID_HID;
    if (space >= 0 && type >= 0)
        attribute = H5Acreate_by_name(h->file, object, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    bool good = attribute >= 0 && H5Awrite(attribute, type, data) >= 0;
    good = (attribute < 0 || H5Aclose(attribute) >= 0) && good;
    H5Sclose(space);
    if (!good)
        sp_h5_fail(h, SP_ENOMEM, "cannot put the attribute %s of %s into the file", name, object);
}

void sp_h5_attribute_texts(sp_h5 *h, const char *object, const char *name, int count, const char *const *text) {
    size_t width = 1;
    const int texts = count ? count : 1;
    for (int k = 0; k < texts; k++)
        width = strlen(text[k]) > width ? strlen(text[k]) : width;
    char *packed = sp_h5_alloc(h, texts, width);
    if (!packed)
        return;
    for (int k = 0; k < texts; k++)
        memcpy(packed + (size_t)k * width, text[k], strlen(text[k]));
    hid_t type = text_type(width, false);
    put_attribute(h, object, name, count, type, packed);
    H5Tclose(type);
    sp_free(packed);
}

void sp_h5_attribute_ints(sp_h5 *h, const char *object, const char *name, int count, const int32_t *value) {
    put_attribute(h, object, name, count, H5T_NATIVE_INT32, value);
}

void sp_h5_attribute_reference(sp_h5 *h, const char *object, const char *name, const char *target) {
    hobj_ref_t reference;
    if (h->status == SP_OK && H5Rcreate(&reference, h->file, target, H5R_OBJECT, H5I_INVALID_HID) < 0)
        sp_h5_fail(h, SP_ENOMEM, "cannot refer to %s", target);
    put_attribute(h, object, name, 0, H5T_STD_REF_OBJ, &reference);
}

/* ---- datasets -------------------------------------------------------------------------------------------------- */

/* Fill value of a chunk that a damaged index lost. No check accepts it as data. */
static bool set_fill(hid_t dcpl, hid_t disk) {
    const double no_number = NAN;
    const int64_t no_index = INT32_MIN;
    if (H5Tget_class(disk) == H5T_FLOAT)
        return H5Pset_fill_value(dcpl, H5T_NATIVE_DOUBLE, &no_number) >= 0;
    return H5Tget_class(disk) != H5T_INTEGER || H5Pset_fill_value(dcpl, H5T_NATIVE_INT64, &no_index) >= 0;
}

/* Layout for `bytes` of data: in the header, or in chunks of whole rows with Fletcher checksums. single: always in
 * chunks, of one row each. */
static hid_t creation_list(int rank, const hsize_t *dims, hid_t disk, size_t bytes, bool single) {
    hid_t dcpl = H5Pcreate(H5P_DATASET_CREATE);
    bool good = dcpl >= 0 && H5Pset_obj_track_times(dcpl, false) >= 0 && set_fill(dcpl, disk);
    if (good && (single ? bytes == 0 : bytes <= compact_limit)) {
        good = H5Pset_layout(dcpl, H5D_COMPACT) >= 0;
    } else if (good && rank > 0) {
        hsize_t chunk[SP_H5_RANK];
        memcpy(chunk, dims, (size_t)rank * sizeof *dims);
        int split = 0; /* the first axis longer than 1 */
        while (split < rank - 1 && dims[split] == 1)
            split++;
        hsize_t rows = single ? 1 : dims[split] * chunk_limit / bytes;
        chunk[split] = rows < 1 ? 1 : rows > dims[split] ? dims[split] : rows;
        good = H5Pset_chunk(dcpl, rank, chunk) >= 0 && H5Pset_fletcher32(dcpl) >= 0;
    }
    if (!good && dcpl >= 0) {
        H5Pclose(dcpl);
        dcpl = H5I_INVALID_HID;
    }
    return dcpl;
}

/* type: on the disk, and in memory. Closes the space and the list. */
static void put_dataset(sp_h5 *h, const sp_h5_name *name, const hid_t type[2], hid_t space, hid_t dcpl,
                        const void *data) {
    hid_t set = H5I_INVALID_HID;
    if (type[0] >= 0 && space >= 0 && dcpl >= 0)
        set = H5Dcreate2(h->file, name->path, type[0], space, H5P_DEFAULT, dcpl, H5P_DEFAULT);
    bool good = set >= 0 && (H5Sget_simple_extent_npoints(space) == 0 ||
                             H5Dwrite(set, type[1], H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0);
    good = (set < 0 || H5Dclose(set) >= 0) && good;
    H5Pclose(dcpl);
    H5Sclose(space);
    if (!good)
        sp_h5_fail(h, SP_ENOMEM, "cannot put %s into the file", name->path);
    sp_h5_attribute_texts(h, name->path, "unit", 0, &name->unit);
    sp_h5_attribute_texts(h, name->path, "description", 0, &name->description);
}

static void put(sp_h5 *h, const sp_h5_name *name, sp_h5_type type, const sp_h5_shape *shape, bool single,
                const void *data) {
    hsize_t dims[SP_H5_RANK];
    size_t bytes = sp_h5_type_size(type);
    if (h->status != SP_OK)
        return;
    for (int k = 0; k < shape->rank; k++) {
        dims[k] = (hsize_t)shape->dim[k];
        bytes *= (size_t)shape->dim[k];
    }
    const hid_t types[2] = {disk_type(type), sp_h5_memory_type(type)};
    put_dataset(h, name, types, shape->rank ? H5Screate_simple(shape->rank, dims, NULL) : H5Screate(H5S_SCALAR),
                creation_list(shape->rank, dims, disk_type(type), bytes, single), data);
}

void sp_h5_put(sp_h5 *h, const sp_h5_name *name, sp_h5_type type, const sp_h5_shape *shape, const void *data) {
    put(h, name, type, shape, false, data);
}

void sp_h5_put_rows(sp_h5 *h, const sp_h5_name *name, sp_h5_type type, const sp_h5_shape *shape, const void *data) {
    put(h, name, type, shape, true, data);
}

void sp_h5_put_fields(sp_h5 *h, int count, const sp_h5_field *field, const void *from) {
    const sp_h5_shape single = {0};
    for (const sp_h5_field *f = field; f < field + count; f++)
        sp_h5_put(h, &f->name, f->type, &single, (const char *)from + f->offset);
}

void sp_h5_put_text(sp_h5 *h, const sp_h5_name *name, const char *text) {
    size_t length = strlen(text), ascii = 0;
    if (h->status != SP_OK)
        return;
    while (ascii < length && (unsigned char)text[ascii] < 0x80)
        ascii++;
    const hid_t type = text_type(length, ascii == length), types[2] = {type, type};
    put_dataset(h, name, types, H5Screate(H5S_SCALAR), creation_list(0, NULL, type, length, false),
                length ? text : "\0");
    H5Tclose(type);
}
