# SPDX-License-Identifier: MIT
# cmake -DSOURCE=... -DHEADER=... -P revision.cmake
#   Writes the git revision of a checkout into a header, and an empty text where SOURCE is not the top of one
#   (a tarball, also one unpacked inside of somebody else's checkout). The header is touched only if it changes.
set(revision "")
find_program(GIT git)
if(GIT)
  # Variables of a git hook that runs the build speak of its repository, not of SOURCE.
  set(git ${CMAKE_COMMAND} -E env --unset=GIT_DIR --unset=GIT_WORK_TREE --unset=GIT_INDEX_FILE ${GIT} -C ${SOURCE})
  execute_process(COMMAND ${git} rev-parse --show-toplevel
                  OUTPUT_VARIABLE top OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  file(REAL_PATH ${SOURCE} source)
  if(top STREQUAL source)
    execute_process(COMMAND ${git} rev-parse --short=12 HEAD
                    OUTPUT_VARIABLE revision OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    execute_process(COMMAND ${git} diff --quiet HEAD RESULT_VARIABLE changed ERROR_QUIET)
    if(revision AND changed)
      string(APPEND revision " with changes")
    endif()
  endif()
endif()
file(CONFIGURE OUTPUT ${HEADER} CONTENT [[
#pragma once
#define SILVAFIT_REVISION "@revision@"
]] @ONLY)
