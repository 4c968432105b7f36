# cpack -G DEB: stylet with the program, libstylet-dev with the library.
set(CPACK_PACKAGE_NAME stylet)
set(CPACK_PACKAGE_VENDOR "Stylet developers")
# Who makes a package is its maintainer, by the names that Debian's own tools take; else whoever has made
# most of the sources' commits. -DCPACK_PACKAGE_CONTACT="NAME <ADDRESS>" says otherwise.
if(NOT CPACK_PACKAGE_CONTACT)
  if(DEFINED ENV{DEBFULLNAME} AND DEFINED ENV{DEBEMAIL})
    set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
  else()
    execute_process(COMMAND git -C ${PROJECT_SOURCE_DIR} shortlog --summary --numbered --email HEAD
                    OUTPUT_VARIABLE makers ERROR_QUIET RESULT_VARIABLE no_git)
    string(REGEX MATCH "\t([^\n]*)" _ "${makers}")
    set(CPACK_PACKAGE_CONTACT "${CMAKE_MATCH_1}")
  endif()
endif()
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/jobs/cmake/debian.cmake)
file(STRINGS jobs/cmake/changelog last_change LIMIT_COUNT 1)
if(NOT last_change MATCHES "^stylet \\(${PROJECT_VERSION}\\) ")
  message(WARNING "jobs/cmake/changelog does not say what version ${PROJECT_VERSION} changes")
endif()
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_COMPONENTS_ALL program development)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME stylet)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS python3)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS
    "openmpi-bin, python3-numpy, python3-h5py, python3-matplotlib, python3-pil")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "python3-openturns, paraview, libgl1-mesa-dri, fonts-dejavu-core")
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "needle insertion into soft tissue
Stylet simulates how a needle deforms and cuts soft tissue and where the seeds
that it leaves there end up: finite elements in the plane, on one or many
ranks.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libstylet-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "petsc-dev, slepc-dev, libopenmpi-dev, libsuitesparse-dev, libmetis-dev, libhdf5-openmpi-dev, libyaml-cpp-dev, libudunits2-dev, libssl-dev, libpng-dev, libturbojpeg0-dev, nlohmann-json3-dev, pkg-config")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "needle insertion into soft tissue, library
Headers, libraries and CMake files of Stylet, for programs that build a scene,
step it and read its fields: find_package(stylet).")
include(CPack)
