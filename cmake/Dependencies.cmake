find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Ceres 2.1 REQUIRED)
find_package(OpenEXR 3.1 REQUIRED)
find_package(OpenSSL 3 REQUIRED COMPONENTS Crypto)
find_package(embree 3 REQUIRED)
find_package(TBB REQUIRED)
find_package(fmt 9 REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(CLI11 2.1 REQUIRED)
find_package(glm REQUIRED)
find_package(PkgConfig REQUIRED)
pkg_check_modules(tomlplusplus REQUIRED IMPORTED_TARGET tomlplusplus)
pkg_check_modules(epoxy REQUIRED IMPORTED_TARGET epoxy egl)
if(WHEATSTONE_TESTS)
  find_package(GTest 1.12 REQUIRED)
endif()
if(WHEATSTONE_BENCH)
  find_package(benchmark REQUIRED)
endif()

# The thread-safe LibRaw. Its pkg-config file would add OpenMP to every link.
find_path(LIBRAW_INCLUDE_DIR libraw/libraw.h REQUIRED)
find_library(LIBRAW_LIBRARY raw_r REQUIRED)
add_library(third_party::libraw UNKNOWN IMPORTED)
set_target_properties(third_party::libraw PROPERTIES
  IMPORTED_LOCATION "${LIBRAW_LIBRARY}"
  INTERFACE_INCLUDE_DIRECTORIES "${LIBRAW_INCLUDE_DIR}")

# Debian's single OpenCV modules come without OpenCV's CMake package (only libopencv-dev, which
# pulls in all of it, has one), so each module used is declared here.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
foreach(module core imgproc imgcodecs calib3d aruco)
  find_library(OPENCV_${module}_LIBRARY opencv_${module} REQUIRED)
  add_library(third_party::opencv_${module} UNKNOWN IMPORTED)
  set_target_properties(third_party::opencv_${module} PROPERTIES
    IMPORTED_LOCATION "${OPENCV_${module}_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${OPENCV_INCLUDE_DIR}")
endforeach()
add_library(third_party::opencv INTERFACE IMPORTED)
target_link_libraries(third_party::opencv INTERFACE
  third_party::opencv_core third_party::opencv_imgproc third_party::opencv_imgcodecs)
