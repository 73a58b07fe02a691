# Writes a C file with the octets of the page that needs no build: cmake -DOUT=plain.c -DFOLDER=plain -P embed.cmake
set(text "#include <stddef.h>\n")
foreach(pair "plain_html index.html" "plain_js plain.js" "plain_css plain.css")
  separate_arguments(parts UNIX_COMMAND "${pair}")
  list(GET parts 0 name)
  list(GET parts 1 file)
  file(READ ${FOLDER}/${file} octets HEX)
  string(LENGTH "${octets}" digits)
  math(EXPR size "${digits} / 2")
  string(REGEX REPLACE "(..)" "0x\\1," octets "${octets}")
  string(APPEND text "extern const unsigned char ${name}[];\nextern const size_t ${name}_size;\n"
    "const unsigned char ${name}[] = {${octets}0};\nconst size_t ${name}_size = ${size};\n")
endforeach()
file(WRITE ${OUT} "${text}")
