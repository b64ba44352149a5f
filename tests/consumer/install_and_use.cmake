# SPDX-License-Identifier: MIT
# cmake -DBUILD=... -DWORK=... -DCOMPILER=... -DVERSION=... [-DVIEWER=ON] [-DFLAGS=...] -P install_and_use.cmake
#   Installs a build into WORK/installed, looks at what is there, runs the program from there, and builds
#   and runs the project beside this script, and the example's, with it.
set(installed ${WORK}/installed)
set(consumer ${WORK}/consumer)

function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${what} failed (${status}):\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

function(expect_file path)
  if(NOT EXISTS ${installed}/${path})
    message(FATAL_ERROR "not installed: ${path}")
  endif()
endfunction()

# Installed anew each time: a file that is no longer installed must be missed.
file(REMOVE_RECURSE ${installed})
run("installing" ${CMAKE_COMMAND} --install ${BUILD} --prefix ${installed})

file(GLOB public_headers RELATIVE ${CMAKE_CURRENT_LIST_DIR}/../..
     ${CMAKE_CURRENT_LIST_DIR}/../../lib*/include/silvafit/*/*.hpp)
if(NOT public_headers)
  message(FATAL_ERROR "no public headers beside this script")
endif()
foreach(header ${public_headers})
  string(REGEX REPLACE "^lib[a-z]+/" "" header ${header})
  expect_file(${header})
endforeach()
expect_file(share/silvafit/models/base.schema.json)
expect_file(share/silvafit/models/taper/zeng.json)
if(VIEWER)
  expect_file(share/silvafit/viewer/report.html)
  expect_file(share/silvafit/viewer/scene.html)
endif()

# Whatever the program reads, and what it says of itself to shells and to man.
if(EXISTS ${installed}/bin/silvafit)
  file(GLOB pages ${installed}/share/man/man1/silvafit.1*)
  if(NOT pages)
    message(FATAL_ERROR "no manual page is installed")
  endif()
  expect_file(share/bash-completion/completions/silvafit)
  expect_file(share/zsh/vendor-completions/_silvafit)
  expect_file(share/fish/vendor_completions.d/silvafit.fish)
endif()
expect_file(share/doc/silvafit/copyright)
expect_file(share/doc/silvafit/examples/fir-mixed/inventory.csv)

# From a folder that is not the checkout's, without the variable that tests set.
unset(ENV{SILVAFIT_DATA_DIR})
set(program ${installed}/bin/silvafit)
if(EXISTS ${program})
  run("silvafit --version" ${program} --version)
  if(NOT output MATCHES "^silvafit ${VERSION}\n")
    message(FATAL_ERROR "silvafit --version says ${output}")
  endif()
  run("silvafit models" ${program} models --json)
  file(GLOB entries ${installed}/share/silvafit/models/base/*.json)
  list(LENGTH entries expected)
  string(REGEX MATCHALL "\"id\": *\"M[0-9]+\"" listed "${output}")
  list(LENGTH listed count)
  if(expected EQUAL 0 OR NOT count EQUAL expected)
    message(FATAL_ERROR "silvafit models lists ${count} of ${expected} installed models:\n${output}")
  endif()

  # The example that came along, from a study to trees: presets, report page and schemas are found.
  set(example_inventory ${installed}/share/doc/silvafit/examples/fir-mixed/inventory.csv)
  file(REMOVE_RECURSE ${WORK}/study)
  run("silvafit grow" ${program} grow ${example_inventory} --plot 1 --lod 3 --scene ${WORK}/plot.glb)
  if(VIEWER)
    run("silvafit study" ${program} study ${example_inventory} --species SM --responses h --out ${WORK}/study)
    if(NOT EXISTS ${WORK}/study/report.html)
      message(FATAL_ERROR "silvafit study wrote no report:\n${output}")
    endif()
  endif()
endif()

run("configuring the consumer" ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR} -B ${consumer} -G Ninja
    -DCMAKE_PREFIX_PATH=${installed} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS})
run("building the consumer" ${CMAKE_COMMAND} --build ${consumer})
run("running the consumer" ${consumer}/consumer)
message("${output}")

# The example is a project of its own, too. The log-likelihood is TMB 1.9.2's Laplace approximation of the
# same model, -2679.25375144.
set(root ${CMAKE_CURRENT_LIST_DIR}/../..)
set(example ${WORK}/height_curve)
run("configuring the example" ${CMAKE_COMMAND} -S ${root}/examples/fit-a-height-curve -B ${example} -G Ninja
    -DCMAKE_PREFIX_PATH=${installed} -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_FLAGS=${FLAGS})
run("building the example" ${CMAKE_COMMAND} --build ${example})
run("running the example" ${example}/height_curve ${root}/examples/fir-mixed/inventory.csv)
message("${output}")
if(NOT output MATCHES "log-likelihood -2679\\.25375")
  message(FATAL_ERROR "the example's log-likelihood is not TMB's, -2679.25375:\n${output}")
endif()

# What is ours alone stays in our build: no path of the checkout or of the build tree is installed.
file(GLOB package_files ${installed}/lib*/cmake/silvafit/*.cmake ${installed}/lib*/*/cmake/silvafit/*.cmake)
if(NOT package_files)
  message(FATAL_ERROR "no package files are installed")
endif()
foreach(file ${package_files})
  file(READ ${file} text)
  foreach(word ${BUILD}/ silvafit_build_options kainjow)
    string(FIND "${text}" "${word}" at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${file} mentions ${word}")
    endif()
  endforeach()
endforeach()
