# Debian 12 ships SuiteSparse without a CMake configuration. Defines SuiteSparse::CHOLMOD, with
# OpenBLAS as its BLAS and the runtime of OpenMP, which CHOLMOD is built with.
find_path(SUITESPARSE_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse)
find_library(CHOLMOD_LIBRARY cholmod)
find_library(OPENBLAS_LIBRARY openblas)

find_package(OpenMP COMPONENTS CXX)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(SuiteSparse
    REQUIRED_VARS CHOLMOD_LIBRARY OPENBLAS_LIBRARY SUITESPARSE_INCLUDE_DIR
    OpenMP_CXX_FOUND)

if(SuiteSparse_FOUND AND NOT TARGET SuiteSparse::CHOLMOD)
    add_library(SuiteSparse::CHOLMOD UNKNOWN IMPORTED)
    set_target_properties(SuiteSparse::CHOLMOD PROPERTIES
        IMPORTED_LOCATION "${CHOLMOD_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${SUITESPARSE_INCLUDE_DIR}"
        INTERFACE_LINK_LIBRARIES "${OPENBLAS_LIBRARY};${OpenMP_CXX_LIBRARIES}")
endif()
