# The one way a module is declared. A module lives in one folder of the tree and may use only
# the folders its layer names (docs/architecture.md); anything else stops the configuration,
# whether it comes as a link or as an #include.

set(WHEATSTONE_MAY_USE_core "")
set(WHEATSTONE_MAY_USE_hardware core)
set(WHEATSTONE_MAY_USE_sim core hardware)
set(WHEATSTONE_MAY_USE_calib core hardware)
set(WHEATSTONE_MAY_USE_capture core hardware calib)
set(WHEATSTONE_MAY_USE_rendering core)
set(WHEATSTONE_MAY_USE_display core hardware calib rendering)
set(WHEATSTONE_MAY_USE_apps core hardware sim calib capture rendering display)
set(WHEATSTONE_MODULES core hardware sim calib capture rendering display apps)

# wheatstone_check_use(<target> <folder> <used folder> <why>)
function(wheatstone_check_use target folder used why)
  if(NOT used STREQUAL folder AND NOT used IN_LIST WHEATSTONE_MAY_USE_${folder})
    list(JOIN WHEATSTONE_MAY_USE_${folder} ", " allowed)
    message(FATAL_ERROR
      "module '${target}' in ${folder}/ must not use ${used}/ (${why}); "
      "${folder}/ may use only: ${allowed}")
  endif()
endfunction()

# wheatstone_add_module(<path> SOURCES a.cpp ... [PUBLIC target ...] [PRIVATE target ...])
#
# <path> is the folder below the root, e.g. rendering/light_field; the target is named
# wheatstone_rendering_light_field with the alias wheatstone::rendering_light_field.
function(wheatstone_add_module path)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;PUBLIC;PRIVATE")
  string(REPLACE "/" "_" name "${path}")
  string(REGEX REPLACE "/.*" "" folder "${path}")
  if(NOT folder IN_LIST WHEATSTONE_MODULES)
    message(FATAL_ERROR "'${path}' is in no layer: add ${folder} to cmake/Modules.cmake")
  endif()

  foreach(link IN LISTS arg_PUBLIC arg_PRIVATE)
    if(link MATCHES "^wheatstone::([a-z]+)")
      wheatstone_check_use(${name} ${folder} ${CMAKE_MATCH_1} "it links ${link}")
    endif()
  endforeach()
  file(GLOB headers CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.h")
  foreach(source IN LISTS arg_SOURCES headers)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}")
    file(STRINGS "${source}" includes REGEX "^#include \"[a-z_]+/")
    foreach(line IN LISTS includes)
      string(REGEX REPLACE "^#include \"([a-z_]+)/.*" "\\1" used "${line}")
      if(used IN_LIST WHEATSTONE_MODULES)
        wheatstone_check_use(${name} ${folder} ${used} "${source} has ${line}")
      endif()
    endforeach()
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
  endforeach()

  add_library(wheatstone_${name} STATIC ${arg_SOURCES})
  add_library(wheatstone::${name} ALIAS wheatstone_${name})
  target_link_libraries(wheatstone_${name}
    PUBLIC ${arg_PUBLIC}
    PRIVATE ${arg_PRIVATE} wheatstone_options)
  target_include_directories(wheatstone_${name} PUBLIC "${PROJECT_SOURCE_DIR}")
endfunction()

# wheatstone_add_test(<name> SOURCES a.cpp ... LINKS target ... [LABELS label ...]): one GoogleTest
# program, each of its tests known to ctest by its own name.
function(wheatstone_add_test name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "SOURCES;LINKS;LABELS")
  add_executable(${name} ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE
    ${arg_LINKS} wheatstone_options GTest::gmock GTest::gtest_main)
  target_compile_definitions(${name} PRIVATE
    WHEATSTONE_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    WHEATSTONE_DEFAULT_SHARED="${PROJECT_SOURCE_DIR}/../shared")
  # gtest_discover_tests keeps one label only; `ctest -L` looks for a part of it.
  list(JOIN arg_LABELS "-" label)
  gtest_discover_tests(${name}
    PROPERTIES TIMEOUT 300 LABELS "${label}" DISCOVERY_TIMEOUT 120)
endfunction()
