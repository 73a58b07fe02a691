# page.cmake: the built page of collided-web, its checker in WebAssembly, and the package @collided/client, in the build's
# web/ folder: page/ is what `collided-web --root` serves, npm/ what `npm pack` packs. COLLIDED_WEB_PAGE: ON, OFF, or AUTO:
# where Node 18 or newer, npm, and Debian's clang-14, lld-14, wasi-libc and libclang-rt-dev-wasm32 are installed. npm fetches
# what package-lock.json names. Without the page collided-web serves one that needs no build.
set(COLLIDED_WEB_PAGE AUTO CACHE STRING "Build the page of collided-web: ON, OFF or AUTO")
set(COLLIDED_WEB_PAGE_BUILT OFF CACHE INTERNAL "The page of collided-web is built")
if(NOT COLLIDED_WEB_PAGE OR COLLIDED_SANITIZE OR COLLIDED_FUZZ) # the same page as the release build's
  return()
endif()
find_program(COLLIDED_NODE node)
find_program(COLLIDED_NPM npm)
find_program(COLLIDED_WASM_CLANG clang-14)
find_program(COLLIDED_WASM_LD wasm-ld-14)
find_path(COLLIDED_WASI_INCLUDE stdlib.h PATHS /usr/include/wasm32-wasi NO_DEFAULT_PATH)
find_file(COLLIDED_WASM_BUILTINS libclang_rt.builtins-wasm32.a PATHS /usr/lib/llvm-14/lib/clang/14.0.6/lib/wasi
  /usr/lib/llvm-14/lib/clang/14/lib/wasi /usr/lib/clang/14.0.6/lib/wasi NO_DEFAULT_PATH)
set(missing)
foreach(tool NODE NPM WASM_CLANG WASM_LD WASI_INCLUDE WASM_BUILTINS)
  if(NOT COLLIDED_${tool})
    string(APPEND missing " ${tool}")
  endif()
endforeach()
if(COLLIDED_NODE)
  execute_process(COMMAND ${COLLIDED_NODE} --version OUTPUT_VARIABLE node_version OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(node_version MATCHES "^v([0-9]+)" AND CMAKE_MATCH_1 LESS 18)
    string(APPEND missing " NODE>=18")
  endif()
endif()
if(missing)
  if(NOT COLLIDED_WEB_PAGE STREQUAL AUTO)
    message(FATAL_ERROR "COLLIDED_WEB_PAGE: not found:${missing}. apt-get install nodejs npm clang-14 lld-14 wasi-libc libclang-rt-dev-wasm32")
  endif()
  message(STATUS "No page of collided-web but the plain one: not found:${missing}")
  return()
endif()
set(COLLIDED_WEB_PAGE_BUILT ON CACHE INTERNAL "The page of collided-web is built")

# verify.wasm: the checkers. No contraction, no vector units: the bits of the library. Stripped, so that no path is in it.
set(web ${PROJECT_BINARY_DIR}/web)
set(wasm ${web}/verify.wasm)
set(checked verify.c verify_hull.c verify_scan.c verify_shape.c)
list(TRANSFORM checked PREPEND ${PROJECT_SOURCE_DIR}/client/)
list(APPEND checked ${PROJECT_SOURCE_DIR}/client/check/check.c ${PROJECT_SOURCE_DIR}/client/check/propose.c
  ${PROJECT_SOURCE_DIR}/client/check/machine.c)
list(APPEND checked ${CMAKE_CURRENT_SOURCE_DIR}/checker/checker.c ${CMAKE_CURRENT_SOURCE_DIR}/checker/kernel.c)
set(objects)
foreach(source ${checked})
  get_filename_component(name ${source} NAME_WE)
  set(object ${web}/objects/${name}.o)
  add_custom_command(OUTPUT ${object}
    COMMAND ${COLLIDED_WASM_CLANG} --target=wasm32-wasi --sysroot=/usr -isystem ${COLLIDED_WASI_INCLUDE} -std=c17 -O2
      -ffp-contract=off -Wall -Wextra -Werror -I${PROJECT_SOURCE_DIR}/client -MD -MF ${object}.d -c ${source} -o ${object}
    DEPENDS ${source} DEPFILE ${object}.d VERBATIM)
  list(APPEND objects ${object})
endforeach()
file(MAKE_DIRECTORY ${web}/objects)
add_custom_command(OUTPUT ${wasm}
  COMMAND ${COLLIDED_WASM_LD} --no-entry --strip-all --export=checker_room --export=checker_check --export=checker_kernel
    --export=checker_kernel_proven --export=checker_kernel_machine -L/usr/lib/wasm32-wasi
    ${objects} -lc -lm ${COLLIDED_WASM_BUILTINS} -o ${wasm}
  DEPENDS ${objects} VERBATIM)

file(GLOB_RECURSE page_sources CONFIGURE_DEPENDS client/* page/*)
set(page_arguments ${web}/work ${web} ${wasm} ${PROJECT_VERSION})
if(COLLIDED_WEB_PAGE STREQUAL AUTO)
  list(APPEND page_arguments --lenient)
endif()
if(BUILD_TESTING)
  file(GLOB web_tests CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/web/*.mjs)
  list(APPEND page_arguments --tests)
endif()
add_custom_command(OUTPUT ${web}/page/page.js
  COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/make ${page_arguments}
  DEPENDS ${wasm} ${page_sources} ${web_tests} make build.mjs tsconfig.json package.json package-lock.json VERBATIM)
add_custom_target(web_page ALL DEPENDS ${web}/page/page.js)
