# SPDX-License-Identifier: MIT
# cmake -DSOURCE=... -DTARGET=... -DNPM=... -P npm_ci.cmake
#   The npm packages that SOURCE locks, installed into TARGET, unless the same ones are there.
file(COPY ${SOURCE}/package.json ${SOURCE}/package-lock.json DESTINATION ${TARGET})
set(installed ${TARGET}/installed.json)
file(READ ${SOURCE}/package-lock.json wanted)
if(EXISTS ${installed})
  file(READ ${installed} present)
  if(present STREQUAL wanted)
    file(TOUCH ${installed})
    return()
  endif()
endif()
execute_process(COMMAND ${NPM} ci --no-audit --no-fund --ignore-scripts --loglevel=error
                WORKING_DIRECTORY ${TARGET} RESULT_VARIABLE status)
if(NOT status EQUAL 0)
  message(FATAL_ERROR
    "npm could not install what ${SOURCE}/package-lock.json names; its own message stands above.\n"
    "Where the network is missing: connect, then run make again.\n"
    "Where npm needs a proxy or a mirror: `npm config set proxy URL` or `npm config set registry URL`.\n"
    "Without the report page: cmake --preset release -DSILVAFIT_BUILD_VIEWER=OFF")
endif()
file(COPY_FILE ${SOURCE}/package-lock.json ${installed})
file(TOUCH ${installed})
