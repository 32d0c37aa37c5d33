# The Python package: `import sonopack` from python/ of the build folder, and from SONOPACK_PYTHON_DIR of an
# installation.
if(NOT Python3_FOUND)
  message(FATAL_ERROR "SONOPACK_PYTHON needs libpython3-dev, python3-cffi and python3-numpy for ${Python3_EXECUTABLE}")
endif()
set(SONOPACK_PYTHON_DIR lib/python3/dist-packages CACHE STRING "Folder of the Python package below the prefix")

set(package ${PROJECT_BINARY_DIR}/python/sonopack)
set(python_source ${PROJECT_SOURCE_DIR}/python)
file(GLOB_RECURSE python_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/*.h ${PROJECT_SOURCE_DIR}/include/*.inc)
file(GLOB_RECURSE python_files RELATIVE ${python_source}/sonopack CONFIGURE_DEPENDS ${python_source}/sonopack/*)
list(FILTER python_files EXCLUDE REGEX "__pycache__")
set(native ${PROJECT_BINARY_DIR}/python-source)
add_custom_command(OUTPUT ${native}/_native.c ${native}/_records.py ${native}/_fields.py
    ${native}/_reference.py
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
file(MAKE_DIRECTORY ${package})
foreach(file _records.py _fields.py _reference.py)
  file(CREATE_LINK ${native}/${file} ${package}/${file} SYMBOLIC)
endforeach()
foreach(file ${python_files})
  get_filename_component(folder ${package}/${file} DIRECTORY)
  file(MAKE_DIRECTORY ${folder})
  file(CREATE_LINK ${python_source}/sonopack/${file} ${package}/${file} SYMBOLIC)
endforeach()
# Compiled once: the commands do not write into the package (-B), and would compile it at each start.
add_custom_command(OUTPUT ${native}/compiled
  COMMAND ${Python3_EXECUTABLE} -m compileall -q ${package}
  COMMAND ${CMAKE_COMMAND} -E touch ${native}/compiled
  DEPENDS ${native}/_records.py ${CMAKE_CURRENT_LIST_FILE} VERBATIM)
add_custom_target(sonopack_python_modules ALL DEPENDS ${native}/compiled)

# The commands that the package runs: beside the command in the build folder, in libexec of an installation.
set(SONOPACK_PROGRAMS plot view convert reproduce trace bench demo pack-lammps modes-slepc moduli-petsc signal-petsc save-table)
set(libexec ${CMAKE_INSTALL_LIBEXECDIR}/sonopack)
foreach(program ${SONOPACK_PROGRAMS})
  set(program_to_package python)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/program.py.in ${PROJECT_BINARY_DIR}/sonopack-${program} @ONLY
    FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  file(RELATIVE_PATH program_to_package /${libexec} /${SONOPACK_PYTHON_DIR})
  configure_file(${CMAKE_CURRENT_LIST_DIR}/program.py.in ${native}/sonopack-${program} @ONLY)
  install(PROGRAMS ${native}/sonopack-${program} DESTINATION ${libexec})
endforeach()

install(TARGETS sonopack_python LIBRARY DESTINATION ${SONOPACK_PYTHON_DIR}/sonopack)
install(FILES ${native}/_records.py ${native}/_fields.py ${native}/_reference.py
  DESTINATION ${SONOPACK_PYTHON_DIR}/sonopack)
install(DIRECTORY ${python_source}/sonopack DESTINATION ${SONOPACK_PYTHON_DIR} PATTERN __pycache__ EXCLUDE)
# of the Debian package (cmake/package.cmake)
string(CONCAT CPACK_DEBIAN_PACKAGE_RECOMMENDS "python3, python3-cffi-backend, python3-numpy, python3-matplotlib, "
  "python3-scipy, python3-pandas, python3-h5py")
