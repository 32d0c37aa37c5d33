# `cmake --install`: command, libraries, headers, man page, documentation, completions, CMake and pkg-config files.
include(CMakePackageConfigHelpers)

set(components sonopack sonopack_tapped sonopack_study)
install(TARGETS ${components} EXPORT sonopackTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}
  RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS sonopack_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY include/sonopack DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h")
# The command writes them from its own tables of options.
set(man_page ${PROJECT_BINARY_DIR}/sonopack.1)
set(man_page_sources ${PROJECT_SOURCE_DIR}/cmake/man.sh ${PROJECT_SOURCE_DIR}/docs/man/sonopack.1.in)
add_custom_command(OUTPUT ${man_page}
  COMMAND sh ${PROJECT_SOURCE_DIR}/cmake/man.sh ${PROJECT_SOURCE_DIR}/docs/man/sonopack.1.in
    ${CMAKE_CROSSCOMPILING_EMULATOR} $<TARGET_FILE:sonopack_command> > ${man_page}
  DEPENDS sonopack_command $<$<TARGET_EXISTS:sonopack_python>:sonopack_python> ${man_page_sources} VERBATIM)
install(FILES ${man_page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
set(completions ${PROJECT_BINARY_DIR}/completions)
add_custom_command(OUTPUT ${completions}/sonopack ${completions}/_sonopack ${completions}/sonopack.fish
  COMMAND ${CMAKE_COMMAND} -E make_directory ${completions}
  COMMAND sonopack_command completion bash > ${completions}/sonopack
  COMMAND sonopack_command completion zsh > ${completions}/_sonopack
  COMMAND sonopack_command completion fish > ${completions}/sonopack.fish
  DEPENDS sonopack_command VERBATIM)
add_custom_target(sonopack_completions ALL
  DEPENDS ${completions}/sonopack ${completions}/_sonopack ${completions}/sonopack.fish ${man_page})
install(FILES ${completions}/sonopack DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${completions}/_sonopack DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)
install(FILES ${completions}/sonopack.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)
install(DIRECTORY share/sonopack DESTINATION ${CMAKE_INSTALL_DATADIR}) # what other programs include
install(FILES README.md CHANGELOG.md CONTRIBUTING.md CITATION.cff LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
# with what their links lead to
install(DIRECTORY docs packings examples DESTINATION ${CMAKE_INSTALL_DOCDIR} PATTERN man EXCLUDE PATTERN api EXCLUDE)
install(FILES python/sonopack/view/three/README.md python/sonopack/view/three/LICENSE python/sonopack/view/three/SHA256SUMS
  DESTINATION ${CMAKE_INSTALL_DOCDIR}/python/sonopack/view/three)
install(DIRECTORY python/examples DESTINATION ${CMAKE_INSTALL_DOCDIR}/python PATTERN __pycache__ EXCLUDE)
install(FILES tests/package/consumer.c tests/package/consumer_all.c DESTINATION ${CMAKE_INSTALL_DOCDIR}/tests/package)
install(DIRECTORY tests/foreign/samples DESTINATION ${CMAKE_INSTALL_DOCDIR}/tests/foreign PATTERN __pycache__ EXCLUDE)
install(FILES .clang-tidy DESTINATION ${CMAKE_INSTALL_DOCDIR})

# Command and shared libraries find each other wherever the tree is moved.
file(RELATIVE_PATH bin_to_lib /${CMAKE_INSTALL_BINDIR} /${CMAKE_INSTALL_LIBDIR})
set_target_properties(sonopack_command PROPERTIES INSTALL_RPATH "$ORIGIN/${bin_to_lib}")
set_target_properties(${components} PROPERTIES INSTALL_RPATH "$ORIGIN")

set(cmake_folder ${CMAKE_INSTALL_LIBDIR}/cmake/sonopack)
set(HDF5_PKGCONFIG ${HDF5_MODULE_NAME})
set(hdf5_lib "")
if(NOT HDF5_PKGCONFIG)
  set(hdf5_lib "-lhdf5 ")
endif()
install(EXPORT sonopackTargets NAMESPACE sonopack:: DESTINATION ${cmake_folder})
configure_package_config_file(cmake/sonopackConfig.cmake.in ${PROJECT_BINARY_DIR}/sonopackConfig.cmake
  INSTALL_DESTINATION ${cmake_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/sonopackConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/sonopackConfig.cmake ${PROJECT_BINARY_DIR}/sonopackConfigVersion.cmake
  cmake/FindCHOLMOD.cmake DESTINATION ${cmake_folder})

# One pkg-config file a library. ours: the libraries of this project that it stands on; theirs: the pkg-config modules
# of others; libs: what has no module. A static library alone needs all of them on every link line, so that they are
# public ones there.
file(RELATIVE_PATH PC_PREFIX /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" PC_PREFIX "${PC_PREFIX}")
function(install_pkgconfig PC_NAME PC_LIBRARY PC_DESCRIPTION ours theirs libs)
  set(PC_REQUIRES "${ours}")
  set(PC_REQUIRES_PRIVATE "")
  set(PC_LIBS "")
  set(PC_LIBS_PRIVATE "")
  if(BUILD_SHARED_LIBS)
    set(PC_REQUIRES_PRIVATE "${theirs}")
    set(PC_LIBS_PRIVATE "${libs}")
  else()
    set(PC_REQUIRES "${ours} ${theirs}")
    set(PC_LIBS " ${libs}")
  endif()
  configure_file(cmake/sonopack.pc.in ${PROJECT_BINARY_DIR}/${PC_NAME}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${PC_NAME}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endfunction()
install_pkgconfig(sonopack sonopack "${PROJECT_DESCRIPTION}" "" "lapacke lapack blas arpack" "-lcholmod -pthread -lm")
install_pkgconfig(sonopack-tapped sonopack_tapped "The tapped column of particles" "sonopack = ${PROJECT_VERSION}" "" "-lm")
install_pkgconfig(sonopack-study sonopack_study "Scenes, studies and files of granular packings"
  "sonopack-tapped = ${PROJECT_VERSION}" "libconfig ${HDF5_PKGCONFIG}" "${hdf5_lib}-pthread -lm")
