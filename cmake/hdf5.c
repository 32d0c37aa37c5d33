/* Whether the archive of HDF5 can be linked without the libraries that its drivers for networks need. */
#include <hdf5.h>

int main(int count, char **words) {
    return H5Fopen(words[count - 1], H5F_ACC_RDONLY, H5P_DEFAULT) < 0;
}
