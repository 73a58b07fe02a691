# manual.cmake: what is read by people and by the init system: pages, completion, the configuration with every option
# explained, the unit. Included by install.cmake.

# install_compressed(PATTERN DIRECTORY COMPONENT): as Debian wants its pages and changelogs; each time the same bytes.
function(install_compressed pattern directory component)
  install(CODE "
    file(GLOB files \"${pattern}\")
    if(NOT files)
      message(FATAL_ERROR \"${pattern}: there is no such file; build all first\")
    endif()
    set(directory \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${directory}\")
    file(MAKE_DIRECTORY \"\${directory}\")
    foreach(file IN LISTS files)
      cmake_path(GET file FILENAME name)
      message(STATUS \"Installing: \${directory}/\${name}.gz\")
      execute_process(COMMAND gzip -9nc \"\${file}\" OUTPUT_FILE \"\${directory}/\${name}.gz\" COMMAND_ERROR_IS_FATAL ANY)
    endforeach()" COMPONENT ${component})
endfunction()

install_compressed(${PROJECT_SOURCE_DIR}/client/examples/collided-demo.1 ${CMAKE_INSTALL_MANDIR}/man1 collided)
install_compressed(${PROJECT_SOURCE_DIR}/client/web/collided-web.1 ${CMAKE_INSTALL_MANDIR}/man1 collided-web)
foreach(section 1 5 8)
  install_compressed(${manual}/man${section}/* ${CMAKE_INSTALL_MANDIR}/man${section} collided)
endforeach()
install_compressed(${manual}/man3/* ${CMAKE_INSTALL_MANDIR}/man3 libcollided-dev)
install_compressed(${manual}/man3load/* ${CMAKE_INSTALL_MANDIR}/man3 libcollided-load-dev)
install(FILES ${manual}/bash-completion/collided ${manual}/bash-completion/collidectl
  DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions COMPONENT collided)

# The unit names /usr/bin/collided and /etc/collided, so it comes with these only. Debian 12 keeps its units in /lib.
if(CMAKE_INSTALL_PREFIX STREQUAL "/usr")
  install(FILES ${PROJECT_SOURCE_DIR}/daemon/systemd/collided.service DESTINATION /lib/systemd/system COMPONENT collided)
  install(FILES ${PROJECT_SOURCE_DIR}/client/web/collided-web.service DESTINATION /lib/systemd/system
    COMPONENT collided-web)
  install(FILES ${manual}/collided.conf DESTINATION /etc/collided COMPONENT collided)
endif()
