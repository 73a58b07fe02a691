# install.cmake: what is installed where, and the packages that cpack makes of it: collided (the daemon, the command line
# and the demo), collided-web, libcollided0, libcollided-dev, libcollided-load0, libcollided-load-dev, and python3-collided
# where Python's half is built. Included last: it names targets of all folders.
# Programs lie together in lib/collided, as in the build folder's bin: each finds what belongs to it beside itself. Links
# in bin lead to those that people call.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(debian ${CMAKE_CURRENT_LIST_DIR})
set(prepared ${PROJECT_BINARY_DIR}/debian)
set(manual ${PROJECT_BINARY_DIR}/manual) # made by the target of that name
set(doc ${CMAKE_INSTALL_DATAROOTDIR}/doc)
set(programs lib/collided)

# ---- collided ----

install(TARGETS collided collided-lcm collidectl arm_controller vehicle_simulator cell_watcher impact_simulator
  RUNTIME DESTINATION ${programs} COMPONENT collided)
install(FILES ${PROJECT_SOURCE_DIR}/client/examples/arm.urdf ${PROJECT_SOURCE_DIR}/client/examples/arm.srdf
  DESTINATION ${programs} COMPONENT collided)
install(PROGRAMS ${PROJECT_SOURCE_DIR}/client/examples/collided-demo DESTINATION ${programs} COMPONENT collided)
install(PROGRAMS ${PROJECT_SOURCE_DIR}/script/make_site DESTINATION ${programs} COMPONENT collided)
install(FILES ${PROJECT_SOURCE_DIR}/daemon/systemd/security.conf DESTINATION ${programs} COMPONENT collided)
file(MAKE_DIRECTORY ${prepared}/bin)
foreach(name collided collidectl collided-demo)
  file(CREATE_LINK ../${programs}/${name} ${prepared}/bin/${name} SYMBOLIC)
  install(FILES ${prepared}/bin/${name} DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT collided)
endforeach()

# ---- collided-web ----

install(TARGETS collided-web RUNTIME DESTINATION ${programs} COMPONENT collided-web)
file(CREATE_LINK ../${programs}/collided-web ${prepared}/bin/collided-web SYMBOLIC)
install(FILES ${prepared}/bin/collided-web DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT collided-web)
install(FILES ${PROJECT_SOURCE_DIR}/client/web/README.md ${PROJECT_SOURCE_DIR}/client/web/PROTOCOL.md
  DESTINATION ${doc}/collided-web COMPONENT collided-web)
if(COLLIDED_WEB_PAGE_BUILT) # otherwise it has the page of tables, which is in the program
  install(DIRECTORY ${PROJECT_BINARY_DIR}/web/page/ DESTINATION ${CMAKE_INSTALL_DATADIR}/collided/web OPTIONAL
    COMPONENT collided-web)
endif()

# ---- libcollided0, libcollided-dev ----

# No static library: it would need the wire's and the DDS half's, which are internal.
install(TARGETS collided_client_shared
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libcollided0 NAMELINK_COMPONENT libcollided-dev)
install(FILES ${PROJECT_SOURCE_DIR}/client/collided.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT libcollided-dev)

configure_file(${debian}/collided.pc.in ${prepared}/collided.pc @ONLY)
install(FILES ${prepared}/collided.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT libcollided-dev)

# The checker of certificates: static, so that a program needs nothing of it where it runs.
install(FILES ${PROJECT_BINARY_DIR}/client/check/stripped/libcollided_check.a DESTINATION ${CMAKE_INSTALL_LIBDIR}
  COMPONENT libcollided-dev)
install(FILES ${PROJECT_SOURCE_DIR}/client/check/collided_check.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT libcollided-dev)
install(FILES ${PROJECT_SOURCE_DIR}/client/check/CERTIFICATE.md DESTINATION ${doc}/libcollided-dev COMPONENT libcollided-dev)
configure_file(${debian}/collided_check.pc.in ${prepared}/collided_check.pc @ONLY)
install(FILES ${prepared}/collided_check.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT libcollided-dev)

set(config ${CMAKE_INSTALL_LIBDIR}/cmake/collided)
configure_package_config_file(${debian}/collidedConfig.cmake.in ${prepared}/collidedConfig.cmake
  INSTALL_DESTINATION ${config} PATH_VARS CMAKE_INSTALL_LIBDIR CMAKE_INSTALL_INCLUDEDIR)
write_basic_package_version_file(${prepared}/collidedConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${prepared}/collidedConfig.cmake ${prepared}/collidedConfigVersion.cmake
  DESTINATION ${config} COMPONENT libcollided-dev)

# The pages that collided.h names, and the protocol for clients that are written without this library.
install(FILES ${PROJECT_SOURCE_DIR}/client/README.md DESTINATION ${doc}/libcollided-dev COMPONENT libcollided-dev)
install(FILES ${PROJECT_SOURCE_DIR}/idl/README.md DESTINATION ${doc}/libcollided-dev RENAME protocol.md
  COMPONENT libcollided-dev)
install(FILES ${PROJECT_SOURCE_DIR}/idl/collided.idl ${PROJECT_SOURCE_DIR}/idl/collided.lcm
  ${PROJECT_SOURCE_DIR}/idl/profiles/fastdds.xml
  DESTINATION ${CMAKE_INSTALL_DATADIR}/collided/idl COMPONENT libcollided-dev)
install(PROGRAMS ${PROJECT_SOURCE_DIR}/idl/examples/plain_client.py ${PROJECT_SOURCE_DIR}/idl/examples/plain_client.mjs
  DESTINATION ${doc}/libcollided-dev/examples COMPONENT libcollided-dev)

# ---- libcollided-load0, libcollided-load-dev: URDF, SRDF and scenes, with what they need of other libraries ----

install(TARGETS collided_load_shared
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libcollided-load0 NAMELINK_COMPONENT libcollided-load-dev)
install(FILES ${PROJECT_SOURCE_DIR}/client/load/collided_load.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
  COMPONENT libcollided-load-dev)
install(FILES ${PROJECT_SOURCE_DIR}/client/load/SCENES.md DESTINATION ${doc}/libcollided-load-dev
  COMPONENT libcollided-load-dev)
configure_file(${debian}/collided-load.pc.in ${prepared}/collided-load.pc @ONLY)
install(FILES ${prepared}/collided-load.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT libcollided-load-dev)
set(load_config ${CMAKE_INSTALL_LIBDIR}/cmake/collided_load)
configure_package_config_file(${debian}/collided_loadConfig.cmake.in ${prepared}/collided_loadConfig.cmake
  INSTALL_DESTINATION ${load_config} PATH_VARS CMAKE_INSTALL_LIBDIR CMAKE_INSTALL_INCLUDEDIR)
write_basic_package_version_file(${prepared}/collided_loadConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${prepared}/collided_loadConfig.cmake ${prepared}/collided_loadConfigVersion.cmake
  DESTINATION ${load_config} COMPONENT libcollided-load-dev)
foreach(file arm_controller.c arm.urdf arm.srdf)
  install(FILES ${PROJECT_SOURCE_DIR}/client/examples/${file}
    DESTINATION ${doc}/libcollided-load-dev/examples COMPONENT libcollided-load-dev)
endforeach()

# ---- examples of libcollided-dev ----

foreach(file hello.c example.c example.h example_shapes.c vehicle_simulator.c cell_watcher.c impact_simulator.c
    impact_scene.c impact_scene.h billiards.c billiards_picture.c box_stack.c lockstep.c lockstep.h impact_heap.c
    impact_heap.h dynamics.c dynamics.h)
  install(FILES ${PROJECT_SOURCE_DIR}/client/examples/${file}
    DESTINATION ${doc}/libcollided-dev/examples COMPONENT libcollided-dev)
endforeach()

# ---- python3-collided ----

if(COLLIDED_PYTHON_BUILT)
  set(python lib/python3/dist-packages/collided)
  install(TARGETS collided_python LIBRARY DESTINATION ${python} COMPONENT python3-collided)
  install(FILES ${COLLIDED_PYTHON_FILES} DESTINATION ${python} COMPONENT python3-collided)
  foreach(file first_client swarm)
    install(FILES ${PROJECT_SOURCE_DIR}/client/python/examples/${file}.py
      DESTINATION ${doc}/python3-collided/examples COMPONENT python3-collided)
  endforeach()
  install(FILES ${PROJECT_SOURCE_DIR}/client/python/README.md DESTINATION ${doc}/python3-collided COMPONENT python3-collided)
endif()

include(${debian}/manual.cmake)
include(${debian}/packages.cmake)
