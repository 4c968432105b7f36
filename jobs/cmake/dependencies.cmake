# What the library needs, as `stylet_need` says: REQUIRED or QUIET. Read by the build and, installed, by
# find_package(stylet). The names are Stylet's own, so that a project may look for the same differently.
find_package(PkgConfig ${stylet_need})
find_package(MPI ${stylet_need} COMPONENTS CXX)
find_package(LAPACK ${stylet_need})
find_package(OpenMP ${stylet_need} COMPONENTS CXX)
find_package(nlohmann_json ${stylet_need})
pkg_check_modules(STYLET_PETSC ${stylet_need} IMPORTED_TARGET PETSc SLEPc)
pkg_check_modules(STYLET_YAML ${stylet_need} IMPORTED_TARGET yaml-cpp)
pkg_check_modules(STYLET_HDF5 ${stylet_need} IMPORTED_TARGET hdf5-openmpi)
pkg_check_modules(STYLET_PNG ${stylet_need} IMPORTED_TARGET libpng)
pkg_check_modules(STYLET_JPEG ${stylet_need} IMPORTED_TARGET libturbojpeg)
pkg_check_modules(STYLET_UDUNITS ${stylet_need} IMPORTED_TARGET udunits)
pkg_check_modules(STYLET_CRYPTO ${stylet_need} IMPORTED_TARGET libcrypto)
# These two have no pkg-config file in Debian 12.
foreach(library metis cholmod)
  find_library(STYLET_${library} ${library} ${stylet_need})
  find_path(STYLET_${library}_INCLUDE ${library}.h PATH_SUFFIXES suitesparse ${stylet_need})
  if(NOT TARGET stylet::${library})
    add_library(stylet::${library} UNKNOWN IMPORTED)
    set_target_properties(stylet::${library} PROPERTIES
      IMPORTED_LOCATION "${STYLET_${library}}"
      INTERFACE_INCLUDE_DIRECTORIES "${STYLET_${library}_INCLUDE}")
  endif()
endforeach()
