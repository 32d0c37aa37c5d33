# `cpack` (or `./run deb`): a Debian package of everything that is installed.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sonopack)
set(CPACK_PACKAGE_VENDOR sonopack)
set(CPACK_PACKAGE_CONTACT "the sonopack project <sonopack@localhost>")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR})
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}") # the first line, which cpack puts before these
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Compresses packings of frictional Hertz-Mindlin grains, reads those of other
programs and of experiments, and gives the signal that a pulse at one wall
makes at the other, speeds of sound, elastic moduli, eigenmodes and spectra,
each with its error. With C libraries.")
# what a program that is linked with the libraries needs
set(CPACK_DEBIAN_PACKAGE_SUGGESTS
  "libsuitesparse-dev, libarpack2-dev, liblapacke-dev, libopenblas-dev, libhdf5-dev, libconfig-dev")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
include(CPack)
