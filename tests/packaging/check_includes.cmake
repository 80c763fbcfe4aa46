# cmake -DROOT=<source> -P check_includes.cmake
#
# Reads the table of modules in ROOT/docs/architecture.md and fails on every include outside it:
# a module its row does not name, a third party library that it does not own, and anything but
# Eigen and the standard library in a public header; also on a row that allows what no file does. A module is a folder, so the rooms of a
# module have rows of their own. Checks the licence line as well, and that X.cpp includes X.h first,
# so that a header with a source is compiled alone.
cmake_minimum_required(VERSION 3.25)
set(failures "")
include(${ROOT}/cmake/public_headers.cmake OPTIONAL) # without it all headers are public

file(STRINGS ${ROOT}/docs/architecture.md rows REGEX "^\\| [0-9] \\|")
set(modules "")
foreach(row IN LISTS rows)
    string(REGEX REPLACE "^\\| ([0-9]) \\| `([a-z0-9_/]+)` \\|[^|]*\\|([^|]*)\\|([^|]*)\\|$"
           "\\1;\\2;\\3;\\4" cells "${row}")
    list(GET cells 0 level)
    list(GET cells 1 module)
    list(GET cells 2 includes)
    list(GET cells 3 third_party)
    string(REGEX MATCHALL "[a-z0-9_/]+" may_include_${module} "${includes}")
    string(REGEX MATCHALL "[A-Za-z0-9_.]+" third_party_${module} "${third_party}")
    set(level_${module} ${level})
    foreach(other IN LISTS may_include_${module})
        # Within a floor the table runs from the bottom up, so rows above are already known.
        if(NOT other IN_LIST modules)
            list(APPEND failures "docs/architecture.md: ${module} may not stand on ${other}")
        endif()
    endforeach()
    list(APPEND modules ${module})
endforeach()
if(NOT modules)
    message(FATAL_ERROR "${ROOT}/docs/architecture.md has no table of modules")
endif()

# What the compiler and the operating system bring: <vector>, <sys/stat.h>, <unistd.h>.
set(system "^([a-z_]+|sys/[a-z]+\\.h|(unistd|fcntl|signal|stdlib|malloc|sched|spawn|pthread|immintrin)\\.h)$")

file(GLOB_RECURSE files RELATIVE ${ROOT}
     ${ROOT}/libshape/*.h ${ROOT}/libshape/*.cpp ${ROOT}/tools/*.h ${ROOT}/tools/*.cpp)
foreach(path IN LISTS files)
    string(REGEX REPLACE "^(libshape/)?(.+)/[^/]+$" "\\2" module ${path})
    if(path STREQUAL "libshape/shape.h")
        continue() # all public headers: check_public_headers.cmake
    endif()
    if(NOT module IN_LIST modules)
        list(APPEND failures "${path}: docs/architecture.md has no row for ${module}")
    endif()
    file(STRINGS ${ROOT}/${path} licence LIMIT_COUNT 1)
    if(NOT licence STREQUAL "// SPDX-License-Identifier: MIT")
        list(APPEND failures "${path}: the first line does not state the licence")
    endif()
    file(STRINGS ${ROOT}/${path} includes REGEX "^ *# *include")
    string(REGEX REPLACE "\\.cpp$" ".h" own_header ${path})
    list(SUBLIST includes 0 1 first)
    if(path MATCHES "\\.cpp$" AND EXISTS ${ROOT}/${own_header} AND NOT first MATCHES "\"${own_header}\"")
        list(APPEND failures "${path}: does not include ${own_header} first")
    endif()
    foreach(line IN LISTS includes)
        if(line MATCHES "\"(libshape/)?([a-z0-9_/]+)/[^\"/]*\"")
            set(other ${CMAKE_MATCH_2})
            list(APPEND used_${module} ${other})
            if(NOT other STREQUAL module AND NOT other IN_LIST may_include_${module})
                list(APPEND failures "${path}: ${module} may not include ${other}: ${line}")
            endif()
        elseif(line MATCHES "<([^>]+)>")
            set(name ${CMAKE_MATCH_1})
            string(REGEX REPLACE "/.*" "" library ${name})
            set(is_public FALSE)
            if(path MATCHES "^libshape/.*\\.h$" AND
               (NOT DEFINED public_headers OR path IN_LIST public_headers OR
                path IN_LIST public_picture_headers))
                set(is_public TRUE)
            endif()
            if(library STREQUAL "Eigen" OR name MATCHES "^[a-z_]+$")
                continue()
            elseif(is_public)
                list(APPEND failures "${path}: a public header needs Eigen alone: ${line}")
            elseif(NOT name MATCHES "${system}" AND NOT library IN_LIST third_party_${module})
                list(APPEND failures "${path}: ${library} is not in the row of ${module}: ${line}")
            endif()
            list(APPEND used_${module} ${library})
        else()
            list(APPEND failures "${path}: not an include of a module or a library: ${line}")
        endif()
    endforeach()
endforeach()

foreach(module IN LISTS modules)
    foreach(allowed IN LISTS may_include_${module} third_party_${module})
        if(NOT allowed IN_LIST used_${module})
            list(APPEND failures "docs/architecture.md: ${module} does not include ${allowed}")
        endif()
    endforeach()
endforeach()

if(failures)
    list(JOIN failures "\n  " text)
    message(FATAL_ERROR "Includes outside docs/architecture.md:\n  ${text}")
endif()
list(LENGTH files count)
message(STATUS "${count} files include what docs/architecture.md allows")
