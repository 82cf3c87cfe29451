# What `cmake --install` gives to programs: find_package(cairn) with cairn::format and cairn::runtime.
include(CMakePackageConfigHelpers)

set_target_properties(cairn_format PROPERTIES EXPORT_NAME format)
set_target_properties(cairn_runtime PROPERTIES EXPORT_NAME runtime)
install(TARGETS cairn_format cairn_runtime EXPORT cairn-targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cairn)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/format DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cairn
        FILES_MATCHING PATTERN "*.h" PATTERN codecs EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/runtime DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cairn
        FILES_MATCHING PATTERN "*.h" PATTERN gl EXCLUDE PATTERN viewer EXCLUDE PATTERN stats EXCLUDE
        PATTERN lab EXCLUDE PATTERN lod EXCLUDE PATTERN flight EXCLUDE PATTERN surface EXCLUDE)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/cairn)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/cairn-config.cmake.in cairn-config.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(cairn-config-version.cmake COMPATIBILITY SameMinorVersion)
install(EXPORT cairn-targets NAMESPACE cairn:: DESTINATION ${package_dir})
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/cairn-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/cairn-config-version.cmake
        DESTINATION ${package_dir})
