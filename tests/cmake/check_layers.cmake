# Configures layers/ with one CASE and checks that it succeeds or is refused with a reason.
file(REMOVE_RECURSE "${WORK}")
execute_process(
  COMMAND ${CMAKE_COMMAND} -S "${ROOT}/tests/cmake/layers" -B "${WORK}" -DCASE=${CASE} -DROOT=${ROOT}
  RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
string(REGEX REPLACE "[ \n]+" " " output "${output}")
if(CASE STREQUAL "allowed")
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "an allowed use was refused: ${output}")
  endif()
elseif(status EQUAL 0)
  message(FATAL_ERROR "${CASE} was not refused")
elseif(NOT output MATCHES "must not use")
  message(FATAL_ERROR "${CASE} was refused without the reason: ${output}")
endif()
