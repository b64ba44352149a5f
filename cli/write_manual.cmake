# SPDX-License-Identifier: MIT
# cmake -DPROGRAM=... -DSHARE=... -P write_manual.cmake
#   Manual pages and completions, written by the program itself, where a prefix's share/ has them.
function(run)
  execute_process(COMMAND ${PROGRAM} ${ARGN} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "silvafit ${ARGN} failed (${status})")
  endif()
endfunction()

file(REMOVE_RECURSE ${SHARE})
file(MAKE_DIRECTORY ${SHARE}/bash-completion/completions ${SHARE}/zsh/vendor-completions
     ${SHARE}/fish/vendor_completions.d)
run(completion bash OUTPUT_FILE ${SHARE}/bash-completion/completions/silvafit)
run(completion zsh OUTPUT_FILE ${SHARE}/zsh/vendor-completions/_silvafit)
run(completion fish OUTPUT_FILE ${SHARE}/fish/vendor_completions.d/silvafit.fish)
run(manual --out ${SHARE}/man/man1)

# Without the time in its head the compressed page is the same in every build.
find_program(GZIP gzip)
if(GZIP)
  file(GLOB pages ${SHARE}/man/man1/*.1)
  execute_process(COMMAND ${GZIP} -9n ${pages} COMMAND_ERROR_IS_FATAL ANY)
endif()
