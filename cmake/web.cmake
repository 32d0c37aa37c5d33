# cmake -D WEB=FOLDER -D THREE=FOLDER -D VERSION=V -D OUT=FILE.c -P web.cmake
#
# Makes the page of `sonopack view' one text, as an array in C: markup, style, three.js, and the modules of the page one
# after another in the order in which they stand on each other. One module in the page cannot import another, so that
# `import' lines and the word `export' are taken out; names are unique in all of them.
set(modules data units colours shaders motion signal stage colouring legend picture address panel main)

file(READ ${WEB}/page.html page)
file(READ ${WEB}/style.css style)
file(READ ${THREE}/three.bundle.min.js three)
file(READ ${THREE}/LICENSE license)
file(READ ${THREE}/REVISION revision)
string(STRIP "${revision}" revision)
string(STRIP "${license}" license)
string(STRIP "${style}" style)
string(STRIP "${three}" three)

set(code "")
foreach(module ${modules})
  file(READ ${WEB}/${module}.js text)
  string(REGEX REPLACE "\nimport [^\n]*" "" text "\n${text}")
  string(REGEX REPLACE "\nexport " "\n" text "${text}")
  string(APPEND code "/* ---- ${module}.js */${text}")
endforeach()
string(STRIP "${code}" code)

foreach(pair VERSION=VERSION STYLE=style THREE_REVISION=revision THREE_LICENSE=license CODE=code THREE=three)
  string(REPLACE "=" ";" pair ${pair})
  list(GET pair 0 marker)
  list(GET pair 1 name)
  string(FIND "${page}" "@${marker}@" found)
  if(found EQUAL -1)
    message(FATAL_ERROR "page.html has no @${marker}@")
  endif()
  string(REPLACE "@${marker}@" "${${name}}" page "${page}")
endforeach()
foreach(marker VIEW_TITLE VIEW_DATA)
  string(REGEX MATCHALL "@${marker}@" found "${page}")
  list(LENGTH found times)
  if(NOT times EQUAL 1)
    message(FATAL_ERROR "the page has @${marker}@ ${times} times, must have it once")
  endif()
endforeach()

file(WRITE ${OUT}.html "${page}")
file(READ ${OUT}.html bytes HEX)
string(REGEX REPLACE "(................................)" "\\1\n" bytes "${bytes}")
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
file(WRITE ${OUT} "/* Made by cmake/web.cmake. */\n#include \"view/web.h\"\n\n"
  "const unsigned char view_web_page[] = {\n${bytes}0x00};\n")
