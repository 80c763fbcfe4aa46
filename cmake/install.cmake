# `cmake --install build`: the library, its headers and what find_package(shape) reads.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/shape)
configure_package_config_file(cmake/shapeConfig.cmake.in shapeConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may break what used the one before it.
write_basic_package_version_file(shapeConfigVersion.cmake COMPATIBILITY SameMinorVersion)

install(TARGETS shape EXPORT shapeTargets FILE_SET HEADERS)
install(EXPORT shapeTargets NAMESPACE shape:: DESTINATION ${package_dir})
install(FILES
    ${CMAKE_CURRENT_BINARY_DIR}/shapeConfig.cmake
    ${CMAKE_CURRENT_BINARY_DIR}/shapeConfigVersion.cmake
    cmake/FindHDF5Serial.cmake
    cmake/FindLBFGS.cmake
    cmake/FindSuiteSparse.cmake
    DESTINATION ${package_dir})
