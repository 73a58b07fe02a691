# Compiles one include a header, with the include path PATHS: those of ALLOWED must compile, those of FORBIDDEN must fail
# because they are not found, and for no other reason. All three are divided by commas.
string(REPLACE "," ";" PATHS "${PATHS}")
string(REPLACE "," ";" ALLOWED "${ALLOWED}")
string(REPLACE "," ";" FORBIDDEN "${FORBIDDEN}")
list(TRANSFORM PATHS PREPEND -I)

function(compile header)
  execute_process(COMMAND ${CC} -std=c17 -D_GNU_SOURCE -fsyntax-only ${PATHS} -include ${header} -x c /dev/null
    RESULT_VARIABLE status ERROR_VARIABLE text)
  set(status ${status} PARENT_SCOPE)
  set(text "${text}" PARENT_SCOPE)
endfunction()

foreach(header ${ALLOWED})
  compile(${header})
  if(NOT status EQUAL 0)
    message(SEND_ERROR "${header} must be visible here:\n${text}")
  endif()
endforeach()
foreach(header ${FORBIDDEN})
  compile(${header})
  if(status EQUAL 0)
    message(SEND_ERROR "${header} is visible here, and must not be")
  elseif(NOT text MATCHES "${header}: No such file|'${header}' file not found")
    message(SEND_ERROR "${header} fails for another reason:\n${text}")
  endif()
endforeach()
