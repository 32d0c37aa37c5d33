# The Python package: `import sonopack` from python/ of the build folder, and from SONOPACK_PYTHON_DIR of an
# installation. Debian's Python comes first, since its numpy and h5py use the same OpenBLAS and HDF5.
find_program(SONOPACK_PYTHON_COMMAND python3 HINTS /usr/bin REQUIRED)
set(Python3_EXECUTABLE ${SONOPACK_PYTHON_COMMAND})
find_package(Python3 REQUIRED COMPONENTS Interpreter Development.Module)
execute_process(COMMAND ${Python3_EXECUTABLE} -c "import cffi" RESULT_VARIABLE no_cffi OUTPUT_QUIET ERROR_QUIET)
if(no_cffi)
  message(FATAL_ERROR "SONOPACK_PYTHON needs cffi (python3-cffi) for ${Python3_EXECUTABLE}")
endif()
set(SONOPACK_PYTHON_DIR lib/python3/dist-packages CACHE STRING "Folder of the Python package below the prefix")

set(package ${PROJECT_BINARY_DIR}/python/sonopack)
set(python_source ${PROJECT_SOURCE_DIR}/python)
file(GLOB_RECURSE python_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/*.h)
file(GLOB python_modules CONFIGURE_DEPENDS ${python_source}/sonopack/*.py ${python_source}/sonopack/*.pyi
  ${python_source}/sonopack/py.typed)
set(native ${PROJECT_BINARY_DIR}/python-source)
add_custom_command(OUTPUT ${native}/_native.c ${native}/_records.py ${native}/_reference.py
  COMMAND ${Python3_EXECUTABLE} -B ${python_source}/generate.py ${PROJECT_SOURCE_DIR}/include ${python_source}/native.h
    ${native}
  # cffi leaves an unchanged file as it is
  COMMAND ${CMAKE_COMMAND} -E touch ${native}/_native.c
  DEPENDS ${python_source}/generate.py ${python_source}/native.h ${python_headers}
  COMMENT "Writing the Python extension" VERBATIM)

# The stable interface of Python 3: one file for all its versions.
add_library(sonopack_python MODULE ${native}/_native.c)
set_target_properties(sonopack_python PROPERTIES PREFIX "" OUTPUT_NAME _native SUFFIX .abi3.so
  LIBRARY_OUTPUT_DIRECTORY ${package} C_VISIBILITY_PRESET hidden)
target_link_libraries(sonopack_python PRIVATE Python3::Module sonopack_study sonopack_tapped sonopack Threads::Threads)
if(BUILD_SHARED_LIBS)
  file(RELATIVE_PATH package_to_lib /${SONOPACK_PYTHON_DIR}/sonopack /${CMAKE_INSTALL_LIBDIR})
  set_target_properties(sonopack_python PROPERTIES INSTALL_RPATH "$ORIGIN/${package_to_lib}")
else()
  # its copy of the library is its own affair
  target_link_options(sonopack_python PRIVATE LINKER:--exclude-libs,ALL)
endif()

# Links, so that a change of a module needs no build.
set(linked ${native}/_records.py ${native}/_reference.py ${python_modules})
set(commands "")
foreach(module ${linked})
  get_filename_component(name ${module} NAME)
  list(APPEND commands COMMAND ${CMAKE_COMMAND} -E create_symlink ${module} ${package}/${name})
endforeach()
add_custom_command(OUTPUT ${native}/linked ${commands} COMMAND ${CMAKE_COMMAND} -E touch ${native}/linked
  DEPENDS ${native}/_records.py ${linked} VERBATIM)
add_custom_target(sonopack_python_modules ALL DEPENDS ${native}/linked)

install(TARGETS sonopack_python LIBRARY DESTINATION ${SONOPACK_PYTHON_DIR}/sonopack)
install(FILES ${linked} DESTINATION ${SONOPACK_PYTHON_DIR}/sonopack)
# of the Debian package (cmake/package.cmake)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3, python3-cffi-backend, python3-numpy")
