# SPDX-License-Identifier: MIT
# cmake -DSOURCE=... -DTARGET=... -DNPM=... -P install.cmake: the npm packages of a folder, installed into
# another one, unless the same ones are there.
file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json ${SOURCE}/validate.mjs DESTINATION ${TARGET})
set(installed ${TARGET}/installed.json)
file(READ ${SOURCE}/package-lock.json wanted)
if(EXISTS ${installed})
  file(READ ${installed} present)
  if(present STREQUAL wanted)
    return()
  endif()
endif()
execute_process(COMMAND ${NPM} ci --no-audit --no-fund --ignore-scripts
                WORKING_DIRECTORY ${TARGET} RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "npm ci failed in ${TARGET}")
endif()
file(COPY_FILE ${SOURCE}/package-lock.json ${installed})
