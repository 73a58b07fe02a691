# packages.cmake: the packages, for `cpack -G DEB` in a build with CMAKE_INSTALL_PREFIX=/usr; script/package does all
# of it. Dependencies are what dpkg-shlibdeps finds in the programs. Included by install.cmake.
set(COLLIDED_MAINTAINER "the collided authors <authors@collided.invalid>" CACHE STRING
  "Maintainer of the packages: set it to who answers for those that you publish")
file(STRINGS ${debian}/changelog newest LIMIT_COUNT 1)
if(NOT newest MATCHES "^collided \\(${PROJECT_VERSION}\\) ")
  message(FATAL_ERROR "script/debian/changelog begins with '${newest}', the project's version is ${PROJECT_VERSION}")
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME collided)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT ${COLLIDED_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON) # no packages with debug information: whoever debugs, builds
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL collided collided-web libcollided0 libcollided-dev
  libcollided-load0 libcollided-load-dev)
if(COLLIDED_PYTHON_BUILT)
  list(APPEND CPACK_COMPONENTS_ALL python3-collided)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON) # of libcollided.so.0, for packages that are built with it
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")

foreach(name ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${name} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  install(FILES ${debian}/copyright DESTINATION ${doc}/${name} COMPONENT ${name})
  install_compressed(${debian}/changelog ${doc}/${name} ${name})
endforeach()

set(CPACK_DEBIAN_COLLIDED_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COLLIDED_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COLLIDED_PACKAGE_RECOMMENDS "iproute2, openssl") # make_site; routes of multicast: collided-demo, doctor
set(CPACK_DEBIAN_COLLIDED_PACKAGE_SUGGESTS gnuplot-nox) # pictures of collidectl trade
set(CPACK_DEBIAN_COLLIDED_PACKAGE_CONTROL_EXTRA
  ${debian}/postinst ${debian}/prerm ${debian}/postrm ${debian}/conffiles)
set(CPACK_DEBIAN_COLLIDED_DESCRIPTION "collision daemon for robots and simulators
collided keeps one persistent 3D world. Robot controllers, simulators in
several processes and dashboards publish the poses of their bodies over
Cyclone DDS or LCM, and are told what touches, what is near, and how sure
that is: every distance is an interval that carries its proof.

This package has the daemon, its command line collidectl, and collided-demo,
which shows a robot cell at work. It is not safety-rated.")

set(CPACK_DEBIAN_COLLIDED-WEB_PACKAGE_SECTION science)
set(CPACK_DEBIAN_COLLIDED-WEB_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COLLIDED-WEB_PACKAGE_RECOMMENDS collided)
set(CPACK_DEBIAN_COLLIDED-WEB_DESCRIPTION "world of the collision daemon collided in a browser
collided-web serves a page on which a browser sees the world of the daemon
collided(8) live: bodies, contacts with their intervals, what is near,
unknown, or about to meet, and the daemon's health. It is an ordinary client
of the daemon, read-only, on loopback, with a token.")

set(CPACK_DEBIAN_LIBCOLLIDED0_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBCOLLIDED0_PACKAGE_SHLIBDEPS ON)
# A trigger refreshes the linker's cache. cpack's own way, scripts that call ldconfig, is no longer Debian's: it leaves them
# out when others are named, and others that do not exist are left out, too.
set(CPACK_DEBIAN_LIBCOLLIDED0_PACKAGE_CONTROL_EXTRA ${debian}/triggers ${debian}/none/postinst ${debian}/none/postrm)
set(CPACK_DEBIAN_LIBCOLLIDED0_DESCRIPTION "client library of the collision daemon collided
Programs publish bodies and their poses to the daemon collided(8), over
Cyclone DDS or LCM, and receive events and distances, each with its proof.")

set(CPACK_DEBIAN_LIBCOLLIDED-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBCOLLIDED-DEV_PACKAGE_DEPENDS "libcollided0 (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LIBCOLLIDED-DEV_DESCRIPTION "client library of the collision daemon collided (development)
Programs publish bodies and their poses to the daemon collided(8), over
Cyclone DDS or LCM, and receive events and distances, each with its proof.

This package has the header, files for pkg-config and CMake, the manual and
examples.")

# It is linked to libcollided.so.0, which is in the folder of the build.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/client)
set(CPACK_DEBIAN_LIBCOLLIDED-LOAD0_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_LIBCOLLIDED-LOAD0_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_LIBCOLLIDED-LOAD0_PACKAGE_DEPENDS "libcollided0 (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LIBCOLLIDED-LOAD0_PACKAGE_CONTROL_EXTRA
  ${debian}/triggers ${debian}/none/postinst ${debian}/none/postrm)
set(CPACK_DEBIAN_LIBCOLLIDED-LOAD0_DESCRIPTION "robots and scenes for clients of the collision daemon collided
Reads URDF, SRDF, their meshes, and scenes in YAML, and makes bodies of them
for the daemon collided(8), by way of its client library libcollided.")

set(CPACK_DEBIAN_LIBCOLLIDED-LOAD-DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBCOLLIDED-LOAD-DEV_PACKAGE_DEPENDS
  "libcollided-load0 (= ${PROJECT_VERSION}), libcollided-dev (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_LIBCOLLIDED-LOAD-DEV_DESCRIPTION
  "robots and scenes for clients of the collision daemon collided (development)
Reads URDF, SRDF, their meshes, and scenes in YAML, and makes bodies of them
for the daemon collided(8), by way of its client library libcollided.

This package has the header, files for pkg-config and CMake, the manual, and
an example, the controller of a robot arm.")

# The library is in the folder of the build, not yet where dpkg-shlibdeps would look for it.
set(CPACK_DEBIAN_PYTHON3-COLLIDED_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON3-COLLIDED_PACKAGE_DEPENDS "libcollided0 (= ${PROJECT_VERSION}), libc6 (>= 2.36), python3 (>= 3.11),\
 python3-cffi-backend (>= 1.15), python3-numpy (>= 1:1.24)")
set(CPACK_DEBIAN_PYTHON3-COLLIDED_PACKAGE_CONTROL_EXTRA ${debian}/python3/postinst ${debian}/python3/prerm)
set(CPACK_DEBIAN_PYTHON3-COLLIDED_DESCRIPTION "Python client of the collision daemon collided
Programs publish bodies and their poses to the daemon collided(8), as numpy
arrays that are not copied, and receive events and distances as structured
arrays, each with its proof, by iteration or in asyncio.")

include(CPack)
