# wheatstone_embed_shader(<target> <file> <constant>): makes the shader <file> of the current folder
# the C++ string wheatstone::<constant> in the generated header "<folder>/<file with _>.h", and
# checks it with glslangValidator where that is installed. A .glsl file holds functions to paste into
# shaders; it is checked within an empty fragment shader.
find_program(WHEATSTONE_GLSLANG glslangValidator)

function(wheatstone_embed_shader target file constant)
  set(source "${CMAKE_CURRENT_SOURCE_DIR}/${file}")
  file(RELATIVE_PATH folder "${PROJECT_SOURCE_DIR}" "${CMAKE_CURRENT_SOURCE_DIR}")
  string(REPLACE "." "_" stem "${file}")
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${source}")
  file(READ "${source}" text)
  file(CONFIGURE OUTPUT "${PROJECT_BINARY_DIR}/generated/${folder}/${stem}.h" @ONLY
    CONTENT [=[#pragma once
// Made from @file@ when CMake configures.
namespace wheatstone {
inline constexpr const char* @constant@ = R"GLSL(@text@)GLSL";
}  // namespace wheatstone
]=])
  target_include_directories(${target} PRIVATE "${PROJECT_BINARY_DIR}/generated")
  if(WHEATSTONE_GLSLANG)
    set(stamp "${CMAKE_CURRENT_BINARY_DIR}/${stem}.valid")
    set(checked "${source}")
    if(file MATCHES "\\.glsl$")
      set(checked "${CMAKE_CURRENT_BINARY_DIR}/${stem}.frag")
      file(CONFIGURE OUTPUT "${checked}" @ONLY
        CONTENT "#version 450 core\n@text@\nvoid main() {}\n")
    endif()
    add_custom_command(OUTPUT "${stamp}"
      COMMAND "${WHEATSTONE_GLSLANG}" "${checked}"
      COMMAND "${CMAKE_COMMAND}" -E touch "${stamp}"
      DEPENDS "${source}" COMMENT "Validating ${folder}/${file}" VERBATIM)
    add_custom_target(${target}_${stem} DEPENDS "${stamp}")
    add_dependencies(${target} ${target}_${stem})
  endif()
endfunction()
