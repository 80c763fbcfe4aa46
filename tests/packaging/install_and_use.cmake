# cmake -DBUILD=<build> -DSOURCE=<source> -DVERSION=<version>
#       -DGENERATOR=... -DCOMPILER=... -DFLAGS=... -P install_and_use.cmake
#
# Installs into a fresh prefix, builds the project in consumer/ against it and runs that.
cmake_minimum_required(VERSION 3.25)
set(work ${BUILD}/packaging)
file(REMOVE_RECURSE ${work})

function(run)
    execute_process(COMMAND ${ARGV} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE code)
    if(NOT code EQUAL 0)
        list(JOIN ARGV " " command)
        message(FATAL_ERROR "${command}\nended with ${code}:\n${output}")
    endif()
    set(output "${output}" PARENT_SCOPE)
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${work}/prefix)
file(GLOB_RECURSE configuration ${work}/prefix/*.cmake)
foreach(file IN LISTS configuration)
    file(READ ${file} text)
    if(text MATCHES "${SOURCE}")
        message(FATAL_ERROR "${file} points back into the source folder")
    endif()
endforeach()

run(${CMAKE_COMMAND} -S ${SOURCE}/tests/packaging/consumer -B ${work}/build -G ${GENERATOR}
    -DCMAKE_PREFIX_PATH=${work}/prefix -DWANTED_VERSION=${VERSION}
    -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS})
run(${CMAKE_COMMAND} --build ${work}/build)
run(${work}/build/consumer)
if(NOT output STREQUAL "shape ${VERSION}, 48\n")
    message(FATAL_ERROR "the program printed: ${output}")
endif()
