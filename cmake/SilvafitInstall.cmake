# SPDX-License-Identifier: MIT
# `cmake --install` and `find_package(silvafit)`.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/silvafit)
set(SILVAFIT_INSTALL_DATADIR ${CMAKE_INSTALL_DATADIR}/silvafit)
install(EXPORT silvafitTargets NAMESPACE silvafit:: DESTINATION ${package_dir} COMPONENT development)
configure_package_config_file(cmake/silvafitConfig.cmake.in
  ${PROJECT_BINARY_DIR}/silvafitConfig.cmake INSTALL_DESTINATION ${package_dir}
  PATH_VARS SILVAFIT_INSTALL_DATADIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/silvafitConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/silvafitConfig.cmake
              ${PROJECT_BINARY_DIR}/silvafitConfigVersion.cmake
              cmake/FindLibZip.cmake
        DESTINATION ${package_dir} COMPONENT development)
file(RELATIVE_PATH SILVAFIT_PREFIX_OF_PC /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(cmake/silvafit.pc.in ${PROJECT_BINARY_DIR}/silvafit.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/silvafit.pc
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

# What comes with the program to read and to try.
set(documentation ${CMAKE_INSTALL_DATADIR}/doc/silvafit)
install(FILES README.md CHANGELOG.md CITATION.cff CONTRIBUTING.md DESTINATION ${documentation})
install(DIRECTORY examples DESTINATION ${documentation})
install(DIRECTORY docs DESTINATION ${documentation}
        FILES_MATCHING PATTERN "*.md" PATTERN "*.png")
