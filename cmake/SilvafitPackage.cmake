# SPDX-License-Identifier: MIT
# `cpack` in the build folder: silvafit_*.deb (the program), libsilvafit-dev_*.deb (libraries and headers), and a
# .tar.gz of both that runs wherever it is unpacked.
set(SILVAFIT_PACKAGE_MAINTAINER "The silvafit authors <maintainers@silvafit.invalid>"
    CACHE STRING "Who answers for the packages, as Name <address>")

set(CPACK_GENERATOR DEB TGZ)
set(CPACK_PACKAGE_NAME silvafit)
set(CPACK_PACKAGE_CONTACT ${SILVAFIT_PACKAGE_MAINTAINER})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGE_FILE_NAME silvafit-${PROJECT_VERSION}-${CMAKE_SYSTEM_PROCESSOR})
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_STRIP_FILES ON)

# ---------------------------------------------------------------- Debian
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME silvafit)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "A forest inventory as CSV goes in; morphology models and 3D trees come out.
silvafit computes each tree's structural unit, fits height, height to crown
base and crown width by least squares and by nonlinear mixed effects, writes
a model library, predictions and a report, and grows the trees as meshes.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libsilvafit-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
# What silvafitConfig.cmake looks for.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libeigen3-dev, libboost-dev, libfmt-dev, libhwy-dev, nlohmann-json3-dev, libtbb-dev, libnanoflann-dev, \
libmeshoptimizer-dev, libpng-dev, libexpat1-dev, libzip-dev, libceres-dev")
if(SILVAFIT_HAS_RENDER)
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libembree-dev")
endif()
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "The C++ libraries that silvafit is made of: statistics of mixed models,
structure of stands, geometry of trees. find_package(silvafit) finds them.")

# ---------------------------------------------------------------- copyright and changes
# Debian's rules ask for both in each package. Where Python or gzip is missing, packages lack them.
find_package(Python3 COMPONENTS Interpreter)
find_program(GZIP gzip)
set(papers ${PROJECT_BINARY_DIR}/papers)
set(copyright "${Python3_EXECUTABLE}" ${PROJECT_SOURCE_DIR}/scripts/package-copyright ${PROJECT_SOURCE_DIR}/LICENSE)
if(EXISTS ${PROJECT_SOURCE_DIR}/viewer/pages/copyright)
  set(copyright ${CMAKE_COMMAND} -E cat ${PROJECT_SOURCE_DIR}/viewer/pages/copyright)
elseif(SILVAFIT_BUILD_VIEWER)
  list(APPEND copyright ${PROJECT_BINARY_DIR}/viewer/workshop)
endif()
list(JOIN copyright "\" \"" copyright)

# silvafit_install_papers(package component)
function(silvafit_install_papers package component)
  set(folder ${CMAKE_INSTALL_DATADIR}/doc/${package})
  install(CODE "
    file(MAKE_DIRECTORY \"${papers}\")
    execute_process(COMMAND \"${GZIP}\" -9nc \"${PROJECT_SOURCE_DIR}/debian/changelog\"
                    OUTPUT_FILE \"${papers}/changelog.gz\" COMMAND_ERROR_IS_FATAL ANY)
    execute_process(COMMAND \"${copyright}\"
                    OUTPUT_FILE \"${papers}/copyright\" COMMAND_ERROR_IS_FATAL ANY)" COMPONENT ${component})
  install(FILES ${papers}/changelog.gz ${papers}/copyright
          DESTINATION ${folder} COMPONENT ${component})
endfunction()

if(GZIP AND Python3_FOUND)
  silvafit_install_papers(silvafit program)
  silvafit_install_papers(libsilvafit-dev development)
endif()

include(CPack)
