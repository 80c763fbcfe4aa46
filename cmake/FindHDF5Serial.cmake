# CMake's own FindHDF5 would link all that Debian's static library needs: take the shared one alone.
# Defines HDF5Serial::HDF5Serial, the C interface.
find_path(HDF5_INCLUDE_DIR hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(HDF5_LIBRARY NAMES hdf5_serial hdf5)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(HDF5Serial REQUIRED_VARS HDF5_LIBRARY HDF5_INCLUDE_DIR)

if(HDF5Serial_FOUND AND NOT TARGET HDF5Serial::HDF5Serial)
    add_library(HDF5Serial::HDF5Serial UNKNOWN IMPORTED)
    set_target_properties(HDF5Serial::HDF5Serial PROPERTIES
        IMPORTED_LOCATION "${HDF5_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${HDF5_INCLUDE_DIR}")
endif()
