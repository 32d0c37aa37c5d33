# `reference`: the HTML pages of the public headers, in reference/html of the build folder. Not made unless asked for.
find_program(DOXYGEN_COMMAND doxygen)
if(DOXYGEN_COMMAND)
  configure_file(${PROJECT_SOURCE_DIR}/docs/api/Doxyfile.in ${PROJECT_BINARY_DIR}/Doxyfile @ONLY)
  add_custom_target(reference
    COMMAND ${DOXYGEN_COMMAND} ${PROJECT_BINARY_DIR}/Doxyfile
    WORKING_DIRECTORY ${PROJECT_BINARY_DIR}
    COMMENT "Reference of the library: ${PROJECT_BINARY_DIR}/reference/html/index.html")
endif()
