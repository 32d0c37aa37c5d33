# `cmake --install`: command, library, headers, man page, documentation, completions, CMake and pkg-config files.
include(CMakePackageConfigHelpers)

install(TARGETS sonopack EXPORT sonopackTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS sonopack_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY include/sonopack DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
install(FILES docs/man/sonopack.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES completions/sonopack.bash RENAME sonopack
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
# with what their links lead to
install(DIRECTORY docs packings DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN man EXCLUDE)
install(FILES tests/package/consumer.c DESTINATION ${CMAKE_INSTALL_DOCDIR}/tests/package)

# The command finds a shared library beside it wherever the tree is moved.
file(RELATIVE_PATH bin_to_lib /${CMAKE_INSTALL_BINDIR} /${CMAKE_INSTALL_LIBDIR})
set_target_properties(sonopack_command PROPERTIES INSTALL_RPATH "$ORIGIN/${bin_to_lib}")

set(cmake_folder ${CMAKE_INSTALL_LIBDIR}/cmake/sonopack)
set(HDF5_PKGCONFIG ${HDF5_MODULE_NAME})
install(EXPORT sonopackTargets NAMESPACE sonopack:: DESTINATION ${cmake_folder})
configure_package_config_file(cmake/sonopackConfig.cmake.in ${PROJECT_BINARY_DIR}/sonopackConfig.cmake
  INSTALL_DESTINATION ${cmake_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/sonopackConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/sonopackConfig.cmake ${PROJECT_BINARY_DIR}/sonopackConfigVersion.cmake
  cmake/FindCHOLMOD.cmake DESTINATION ${cmake_folder})

# A static library alone needs its dependencies on every link line, so that they are public ones there.
set(pc_requires "cairo libconfig lapacke lapack blas ${HDF5_MODULE_NAME}")
set(pc_libs "-lumfpack -lcholmod -pthread -lm")
if(BUILD_SHARED_LIBS)
  set(PC_REQUIRES "")
  set(PC_REQUIRES_PRIVATE "${pc_requires}")
  set(PC_LIBS "")
  set(PC_LIBS_PRIVATE "${pc_libs}")
else()
  set(PC_REQUIRES "${pc_requires}")
  set(PC_REQUIRES_PRIVATE "")
  set(PC_LIBS " ${pc_libs}")
  set(PC_LIBS_PRIVATE "")
endif()
file(RELATIVE_PATH PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" PC_PREFIX "${PC_PREFIX}")
configure_file(cmake/sonopack.pc.in ${PROJECT_BINARY_DIR}/sonopack.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/sonopack.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
