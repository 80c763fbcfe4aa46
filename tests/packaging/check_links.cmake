# cmake -DROOT=<source> -P check_links.cmake
#
# Fails on a relative link in README.md or docs/ to a file that does not exist, and on a page of
# docs/ that README.md does not link to.
cmake_minimum_required(VERSION 3.25)
set(failures "")
set(linked "")

file(GLOB pages RELATIVE ${ROOT} ${ROOT}/README.md ${ROOT}/docs/*.md ${ROOT}/datasets/*.md)
foreach(page IN LISTS pages)
    get_filename_component(folder ${ROOT}/${page} DIRECTORY)
    file(READ ${ROOT}/${page} text)
    string(REPLACE "](" "link:" text "${text}")
    string(REGEX REPLACE "[][;]" " " text "${text}") # which would upset lists
    string(REGEX MATCHALL "link:[^)# ]+|src=\"[^\"]+" links "${text}")
    foreach(link IN LISTS links)
        string(REGEX REPLACE "^(link:|src=\")" "" link "${link}")
        if(link MATCHES "^(https?|mailto):")
            continue()
        endif()
        get_filename_component(target ${link} ABSOLUTE BASE_DIR ${folder})
        if(NOT EXISTS ${target})
            list(APPEND failures "${page}: ${link} does not exist")
        elseif(page STREQUAL "README.md")
            list(APPEND linked ${target})
        endif()
    endforeach()
endforeach()
foreach(page IN LISTS pages)
    if(page MATCHES "^docs/" AND NOT ${ROOT}/${page} IN_LIST linked)
        list(APPEND failures "README.md: does not link to ${page}")
    endif()
endforeach()

if(failures)
    list(JOIN failures "\n  " text)
    message(FATAL_ERROR "Links:\n  ${text}")
endif()
