# `cmake --install build`: the libraries, their public headers, and what find_package(shape) and
# pkg-config read.
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/shape)
configure_package_config_file(cmake/shapeConfig.cmake.in shapeConfig.cmake
                              INSTALL_DESTINATION ${package_dir})
# Before 1.0 a minor version may break what used the one before it.
write_basic_package_version_file(shapeConfigVersion.cmake COMPATIBILITY SameMinorVersion)

install(TARGETS shape EXPORT shapeTargets FILE_SET HEADERS)
install(EXPORT shapeTargets NAMESPACE shape:: DESTINATION ${package_dir})
if(SHAPE_BUILD_PICTURES)
    # An export of its own: only who asks for the component needs libpng.
    install(TARGETS shape_pictures EXPORT shapePicturesTargets FILE_SET HEADERS)
    install(EXPORT shapePicturesTargets NAMESPACE shape:: DESTINATION ${package_dir})
endif()
install(FILES
    ${CMAKE_CURRENT_BINARY_DIR}/shapeConfig.cmake
    ${CMAKE_CURRENT_BINARY_DIR}/shapeConfigVersion.cmake
    cmake/FindHDF5Serial.cmake
    cmake/FindLBFGS.cmake
    cmake/FindSuiteSparse.cmake
    cmake/FindUtf8proc.cmake
    DESTINATION ${package_dir})

# pkg-config: a static library needs to be linked with all that it is made from.
set(third_party -lOpenMeshTools -lOpenMeshCore -lpthread)
foreach(library ${CHOLMOD_LIBRARY} ${OPENBLAS_LIBRARY} ${HDF5_LIBRARY} ${LBFGS_LIBRARY} ${UTF8PROC_LIBRARY}
        ${ZLIB_LIBRARIES} ${OpenMP_CXX_LIBRARIES})
    get_filename_component(name ${library} NAME_WE)
    string(REGEX REPLACE "^lib" "-l" name ${name})
    list(APPEND third_party ${name})
endforeach()
if(SHAPE_READS_VTP)
    list(APPEND third_party -lpugixml)
endif()
list(REMOVE_DUPLICATES third_party)
list(JOIN third_party " " third_party)
if(BUILD_SHARED_LIBS)
    set(pc_private_libraries ${third_party})
else()
    set(pc_libraries ${third_party})
endif()
# From where the file lies, so that `cmake --install --prefix` may put all anywhere.
file(RELATIVE_PATH pc_to_include /${CMAKE_INSTALL_LIBDIR}/pkgconfig /${CMAKE_INSTALL_INCLUDEDIR})
configure_file(cmake/shape.pc.in shape.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/shape.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
