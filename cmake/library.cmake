# How a library of the project is put together.
#
#   shape_add_library(NAME HEADER...)
#
# Adds NAME, static or shared as BUILD_SHARED_LIBS says, with its public headers, and NAME_objects,
# which holds the compiled sources. A shared library shows the namespace `shape` and hides
# `shape::internal`, so what needs internals, the program and the tests, links the objects.
#
#   shape_link_libraries(NAME PUBLIC|PRIVATE LIBRARY...)
#
# As target_link_libraries(), for both.

function(shape_add_library name)
    add_library(${name}_objects OBJECT)
    target_compile_features(${name}_objects PUBLIC cxx_std_20)
    # Same input, same bits: no contraction of a*b+c, which the compiler would choose.
    target_compile_options(${name}_objects PRIVATE -ffp-contract=off
        -fno-math-errno -fno-trapping-math) # libshape needs neither, and loops with roots vectorise
    # Eigen's own threads would split sums by their number; threads.h does not.
    target_compile_definitions(${name}_objects PRIVATE EIGEN_DONT_PARALLELIZE)
    target_include_directories(${name}_objects PUBLIC ${PROJECT_SOURCE_DIR})
    # A Python module is linked from the objects, and is a shared library like the others.
    set(is_shared OFF)
    if(BUILD_SHARED_LIBS OR SHAPE_BUILD_PYTHON)
        set(is_shared ON)
    endif()
    set_target_properties(${name}_objects PROPERTIES
        POSITION_INDEPENDENT_CODE ${is_shared}
        VISIBILITY_INLINES_HIDDEN ON)

    add_library(${name})
    string(REGEX REPLACE "^shape_" "" alias ${name})
    add_library(shape::${alias} ALIAS ${name})
    target_sources(${name}
        PRIVATE $<TARGET_OBJECTS:${name}_objects>
        # Gives users their include path, is installed folder by folder, and makes the target
        # all_verify_interface_header_sets, which compiles every header alone.
        PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${ARGN})
    target_compile_features(${name} PUBLIC cxx_std_20)
    # Before 1.0 a minor version may break what used the one before it.
    set_target_properties(${name} PROPERTIES
        EXPORT_NAME ${alias}
        LINKER_LANGUAGE CXX
        VERSION ${PROJECT_VERSION}
        SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
        VERIFY_INTERFACE_HEADER_SETS ${SHAPE_BUILD_TESTS})
    if(BUILD_SHARED_LIBS AND UNIX AND NOT APPLE) # a script of GNU ld, which LLVM's reads too
        set(symbols ${PROJECT_SOURCE_DIR}/cmake/exported_symbols.map)
        target_link_options(${name} PRIVATE LINKER:--version-script=${symbols})
        set_property(TARGET ${name} APPEND PROPERTY LINK_DEPENDS ${symbols})
    endif()
endfunction()

function(shape_link_libraries name)
    target_link_libraries(${name} ${ARGN})
    target_link_libraries(${name}_objects ${ARGN})
endfunction()
