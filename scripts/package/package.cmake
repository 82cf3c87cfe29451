# What `cmake --install` and `cpack` give: the programs with their pages, and the libraries with find_package(cairn).
include(CMakePackageConfigHelpers)

# 1. Programs, and what they load from ../LIBDIR/cairn.
set(programs cairn-lab cairn-stats)
if(CAIRN_BUILDER)
  list(PREPEND programs cairn)
endif()
if(CAIRN_VIEWER)
  list(APPEND programs cairn-view)
endif()
install(TARGETS ${programs} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
install(PROGRAMS ${PROJECT_SOURCE_DIR}/scripts/chart_lab DESTINATION ${CMAKE_INSTALL_BINDIR} RENAME cairn-lab-charts COMPONENT programs)
foreach(module cairn_gdal cairn_oiio cairn_proj)
  if(TARGET ${module})
    install(TARGETS ${module} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/cairn COMPONENT programs)
  endif()
endforeach()
if(TARGET cairn_gdal_driver)
  install(TARGETS cairn_gdal_driver LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/gdalplugins COMPONENT programs)
endif()

# 2. Man pages and completions, made from what the programs print on --help.
find_package(Python3 COMPONENTS Interpreter)
if(Python3_FOUND AND CAIRN_BUILDER AND CAIRN_VIEWER)
  set(pages ${CMAKE_BINARY_DIR}/pages)
  set(maker ${PROJECT_SOURCE_DIR}/scripts/make_cli_pages)
  set(program_files "")
  foreach(program ${programs})
    list(APPEND program_files $<TARGET_FILE:${program}>)
  endforeach()
  add_custom_command(OUTPUT ${pages}/stamp
    COMMAND ${Python3_EXECUTABLE} ${maker} --programs ${CMAKE_RUNTIME_OUTPUT_DIRECTORY} --out ${pages}
    COMMAND ${CMAKE_COMMAND} -E touch ${pages}/stamp
    DEPENDS ${maker} ${programs} ${program_files}
    COMMENT "Making man pages and completions from --help")
  add_custom_target(cairn_pages ALL DEPENDS ${pages}/stamp)
  install(DIRECTORY ${pages}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT programs)
  install(FILES ${pages}/cairn.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME cairn COMPONENT programs)
  install(FILES ${pages}/_cairn DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT programs)
  install(FILES ${pages}/cairn.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT programs)
else()
  message(STATUS "Python 3, the builder or the viewer: absent or off; no man pages and no completions")
endif()

# 3. The desktop: packs have a type and an icon, and open in the viewer.
if(CAIRN_VIEWER)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/cairn-view.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications COMPONENT programs)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/cairn-mime.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/mime/packages RENAME cairn.xml COMPONENT programs)
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/cairn.svg DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps COMPONENT programs)
endif()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/cairn RENAME copyright COMPONENT programs)

# 4. Libraries: cairn::format and cairn::runtime, and with the component `builder` cairn::builder.
function(cairn_install_library name set)
  set_target_properties(cairn_${name} PROPERTIES EXPORT_NAME ${name} VERSION ${PROJECT_VERSION}
                        SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_include_directories(cairn_${name} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  install(TARGETS cairn_${name} EXPORT ${set}
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
          LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT programs NAMELINK_COMPONENT development)
  if(EXISTS ${PROJECT_SOURCE_DIR}/${name}/include)
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/${name}/include/cairn DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
  endif()
endfunction()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/cairn)
cairn_install_library(format cairn-targets)
cairn_install_library(runtime cairn-targets)
install(EXPORT cairn-targets NAMESPACE cairn:: DESTINATION ${package_dir} COMPONENT development)
if(CAIRN_BUILDER)
  cairn_install_library(builder cairn-builder-targets)
  if(NOT BUILD_SHARED_LIBS)
    cairn_install_library(texture_encode cairn-builder-targets)
  endif()
  install(EXPORT cairn-builder-targets NAMESPACE cairn:: DESTINATION ${package_dir} COMPONENT development)
endif()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/cairn-config.cmake.in cairn-config.cmake
                              INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(cairn-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/cairn-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/cairn-config-version.cmake
        DESTINATION ${package_dir} COMPONENT development)

# 5. The Debian package: `cpack -G DEB` in the build folder.
set(CPACK_PACKAGE_NAME cairn)
set(CPACK_PACKAGE_VENDOR cairn)
set(CPACK_PACKAGE_CONTACT "the cairn developers <cairn@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "terrain packs from elevation rasters, and a viewer that flies over them")
set(CPACK_PACKAGE_DESCRIPTION "cairn bakes DEMs and orthoimagery of any size into one file with a measured
error bound, and streams it: as a viewer, and as C++ and C libraries.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_COMPONENTS_ALL programs development)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME cairn)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_RECOMMENDS "libgl1-mesa-dri, python3-matplotlib, ffmpeg")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libcairn-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libglm-dev, libgeographiclib-dev, libzstd-dev, libxxhash-dev, pkg-config")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_RECOMMENDS "libtiff-dev, libpng-dev, libjpeg-dev, zlib1g-dev, libzip-dev, libfmt-dev, libtbb-dev")
if(BUILD_SHARED_LIBS)
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", cairn (= ${PROJECT_VERSION})")
endif()
set(CPACK_COMPONENT_PROGRAMS_DESCRIPTION "The programs: bake, check, sample and view packs.")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "Headers and libraries for programs that read, fly over or bake packs.")
include(CPack)
