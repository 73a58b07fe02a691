# launched(NAME SOURCES ... LIBRARIES ...): the program bin/NAME, which is a launcher, and beside it NAME.so, the program
# proper (target NAME_program). The libraries of the module stay inside it: nothing but main is called from outside.
function(launched name)
  cmake_parse_arguments(L "" "" "SOURCES;LIBRARIES" ${ARGN})
  add_library(${name}_program MODULE ${L_SOURCES})
  target_link_libraries(${name}_program PRIVATE ${L_LIBRARIES} collided_flags)
  target_link_options(${name}_program PRIVATE -Wl,--exclude-libs,ALL)
  if(NOT COLLIDED_SANITIZE) # a sanitizer's own symbols are the launcher's
    target_link_options(${name}_program PRIVATE -Wl,--no-undefined)
  endif()
  set_target_properties(${name}_program PROPERTIES PREFIX "" OUTPUT_NAME ${name}
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)

  add_executable(${name} ${CMAKE_CURRENT_FUNCTION_LIST_DIR}/launch.c)
  target_compile_definitions(${name} PRIVATE LAUNCHED="${name}")
  target_link_libraries(${name} PRIVATE collided_flags ${CMAKE_DL_LIBS})
  add_dependencies(${name} ${name}_program)
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
  # The launcher itself is installed where its package says; the module must lie beside it.
  install(TARGETS ${name}_program LIBRARY DESTINATION lib/collided COMPONENT collided)
endfunction()
