# cmake -DBUILD=<build> -DSOURCE=<source> -DVERSION=<version>
#       -DGENERATOR=... -DCOMPILER=... -DFLAGS=... -P install_and_use.cmake
#
# Installs into a fresh prefix, builds the project in consumer/ and docs/examples/ against it, by CMake
# and, the former, by pkg-config, and runs them all.
cmake_minimum_required(VERSION 3.25)
set(work ${BUILD}/packaging)
file(REMOVE_RECURSE ${work})
file(MAKE_DIRECTORY ${work}/run)

function(run)
    execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${work}/run
                    OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE code)
    if(NOT code EQUAL 0)
        list(JOIN ARGV " " command)
        message(FATAL_ERROR "${command}\nended with ${code}:\n${output}")
    endif()
    set(output "${output}" PARENT_SCOPE)
endfunction()

function(expect_files)
    foreach(file IN LISTS ARGN)
        if(NOT EXISTS ${work}/run/${file})
            message(FATAL_ERROR "${file} was not written")
        endif()
        file(REMOVE ${work}/run/${file})
    endforeach()
endfunction()

# README shows what is compiled and run below.
file(READ ${SOURCE}/README.md readme)
file(READ ${SOURCE}/tests/packaging/consumer/main.cpp consumer)
string(REGEX MATCH "{(\n.*\n)}" body "${consumer}")
string(REPLACE "\n    " "\n" body "${CMAKE_MATCH_1}")
string(FIND "${readme}" "```cpp${body}```" found)
if(found EQUAL -1)
    message(FATAL_ERROR "README.md does not show tests/packaging/consumer/main.cpp:\n${body}")
endif()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${work}/prefix)
file(GLOB_RECURSE configuration ${work}/prefix/*.cmake)
foreach(file IN LISTS configuration)
    file(READ ${file} text)
    if(text MATCHES "${SOURCE}")
        message(FATAL_ERROR "${file} points back into the source folder")
    endif()
endforeach()

# So are manual pages and completions, with the program.
if(EXISTS ${work}/prefix/bin/shape)
    foreach(file man/man1/shape.1 man/man1/shape-stats.1 bash-completion/completions/shape
            zsh/site-functions/_shape fish/vendor_completions.d/shape.fish)
        if(NOT EXISTS ${work}/prefix/share/${file})
            message(FATAL_ERROR "share/${file} was not installed")
        endif()
    endforeach()
endif()

# Public headers are installed, and no others.
include(${SOURCE}/cmake/public_headers.cmake)
file(GLOB_RECURSE installed RELATIVE ${work}/prefix/include ${work}/prefix/include/*)
list(APPEND public_headers ${public_picture_headers})
list(SORT public_headers)
list(SORT installed)
if(NOT installed STREQUAL public_headers)
    message(FATAL_ERROR "installed are: ${installed}\nmust be: ${public_headers}")
endif()

run(${CMAKE_COMMAND} -S ${SOURCE}/tests/packaging/consumer -B ${work}/build -G ${GENERATOR}
    -DCMAKE_PREFIX_PATH=${work}/prefix -DWANTED_VERSION=${VERSION}
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS}
    -DEXAMPLES=${SOURCE}/docs/examples)
run(${CMAKE_COMMAND} --build ${work}/build)

run(${work}/build/difference)
if(NOT output MATCHES "^6 pairs")
    message(FATAL_ERROR "difference printed: ${output}")
endif()
expect_files(happy.ply)
run(${work}/build/interpolation)
expect_files(morph.glb)
run(${work}/build/procrustes)
expect_files(procrustes_mean.ply)
run(${work}/build/groups)
if(NOT output STREQUAL "p = 0.001\n") # the least that 999 permutations can give
    message(FATAL_ERROR "groups printed: ${output}")
endif()
file(GLOB faces ${work}/run/*.ply)
run(${work}/build/conformal)
if(NOT output MATCHES "^certificate: (exact|repaired)")
    message(FATAL_ERROR "conformal printed: ${output}")
endif()
expect_files(sphere.ply)

# The main job, on the faces that `groups` wrote.
run(${work}/build/consumer ${faces})
expect_files(mode1.ply)

find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
    file(GLOB_RECURSE pc ${work}/prefix/shape.pc)
    get_filename_component(folder "${pc}" DIRECTORY)
    set(ENV{PKG_CONFIG_PATH} ${folder})
    run(${PKG_CONFIG} --cflags --libs shape)
    separate_arguments(flags UNIX_COMMAND "${output}")
    separate_arguments(own_flags UNIX_COMMAND "${FLAGS}")
    run(${COMPILER} ${own_flags} ${SOURCE}/tests/packaging/consumer/main.cpp -o ${work}/consumer ${flags})
    set(ENV{LD_LIBRARY_PATH} ${folder}/..)
    run(${work}/consumer ${faces})
    expect_files(mode1.ply)
endif()
