# Finds the headers of Eigen, version 3.3 or later, and sets GENUS_EIGEN_INCLUDE_DIR. Looks for an
# installed package first, then where the PyPI package cmeel-eigen puts it: below `cmeel.prefix`
# in the site-packages of the build.
set(GENUS_EIGEN_INCLUDE_DIR "" CACHE PATH "Directory that holds Eigen/Core")
if(NOT GENUS_EIGEN_INCLUDE_DIR)
  set(genus_eigen_prefixes "")
  foreach(prefix ${CMAKE_PREFIX_PATH} ${SKBUILD_PLATLIB_DIR} $ENV{CMAKE_PREFIX_PATH})
    list(APPEND genus_eigen_prefixes ${prefix} ${prefix}/cmeel.prefix)
  endforeach()
  if(Python_SITEARCH)
    list(APPEND genus_eigen_prefixes ${Python_SITEARCH}/cmeel.prefix)
  endif()
  find_path(genus_eigen_found Eigen/Core NO_CACHE
            HINTS ${genus_eigen_prefixes} PATH_SUFFIXES include/eigen3 include eigen3)
  if(NOT genus_eigen_found)
    message(FATAL_ERROR "Eigen not found: install libeigen3-dev or cmeel-eigen, or set "
                        "GENUS_EIGEN_INCLUDE_DIR")
  endif()
  set(GENUS_EIGEN_INCLUDE_DIR ${genus_eigen_found} CACHE PATH "" FORCE)
endif()
