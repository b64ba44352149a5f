# SPDX-License-Identifier: MIT
# How every library, test and program of the project is declared.

# Warnings, sanitizers and reproducible arithmetic for our own code only.
add_library(silvafit_build_options INTERFACE)
target_compile_options(silvafit_build_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion
  -ffp-contract=off
  # g++ 12 warns falsely when strings are added (its bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  # A larger heap before g++ collects garbage: a seventh less time, 90 MB more memory a compiler.
  "$<$<CXX_COMPILER_ID:GNU>:SHELL:--param ggc-min-heapsize=524288>"
  $<$<BOOL:${SILVAFIT_WERROR}>:-Werror>
  $<$<BOOL:${SILVAFIT_COVERAGE}>:--coverage>)
target_link_options(silvafit_build_options INTERFACE
  $<$<BOOL:${SILVAFIT_COVERAGE}>:--coverage>)
if(SILVAFIT_FUZZ)
  target_compile_options(silvafit_build_options INTERFACE -fsanitize=fuzzer-no-link)
  target_link_options(silvafit_build_options INTERFACE -fsanitize=fuzzer-no-link)
endif()
if(SILVAFIT_SANITIZE)
  target_compile_options(silvafit_build_options INTERFACE
    -fsanitize=${SILVAFIT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer
    # What the sanitizers add confuses g++ 12's analysis of the flow: false warnings inside Eigen and the
    # standard library. Builds without sanitizers keep these warnings.
    $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized -Wno-stringop-overflow>)
  target_link_options(silvafit_build_options INTERFACE -fsanitize=${SILVAFIT_SANITIZE})
endif()

# silvafit_compile_together(target sources...)
#   Sources of a folder are compiled several at a time, as one: what they include is read, and the templates that they
#   share are compiled, once for all. Names in the unnamed namespaces of a folder must therefore differ. The parts of a
#   folder are of about equal size, so that a changed source costs a few seconds. Sources that cannot stand beside others
#   have the property SKIP_UNITY_BUILD_INCLUSION or options of their own.
function(silvafit_compile_together target)
  if(NOT SILVAFIT_UNITY)
    return()
  endif()
  set(most 12)
  set(folders "")
  foreach(source IN LISTS ARGN)
    cmake_path(GET source PARENT_PATH folder)
    list(APPEND folders ${folder})
  endforeach()
  list(REMOVE_DUPLICATES folders)
  list(SORT ARGN)
  foreach(folder IN LISTS folders)
    set(members "")
    foreach(source IN LISTS ARGN)
      cmake_path(GET source PARENT_PATH own)
      if(own STREQUAL folder)
        list(APPEND members ${source})
      endif()
    endforeach()
    list(LENGTH members count)
    math(EXPR parts "(${count} + ${most} - 1) / ${most}")
    cmake_path(GET folder STEM name)
    set(place 0)
    foreach(source IN LISTS members)
      math(EXPR part "${place} * ${parts} / ${count}")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${name}_${part})
      math(EXPR place "${place} + 1")
    endforeach()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # g++ takes an included source for a header and warns of its unnamed namespaces.
  target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endfunction()

# silvafit_add_library(fit)
#   Headers below include/, sources below src/ except *_test.cpp, which become the program silvafit_fit_tests.
#   Private headers sit beside the sources and are included by their path below src/.
function(silvafit_add_library name)
  set(target silvafit_${name})
  file(GLOB_RECURSE headers CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/include/*.hpp)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/src/*.cpp)
  file(GLOB_RECURSE tests CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/src/*_test.cpp)
  if(tests)
    list(REMOVE_ITEM sources ${tests})
  endif()
  add_library(${target} STATIC ${sources})
  silvafit_compile_together(${target} ${sources})
  add_library(silvafit::${name} ALIAS ${target})
  target_sources(${target} PUBLIC FILE_SET HEADERS BASE_DIRS include FILES ${headers})
  # The libraries become part of R's and Python's modules, which are shared objects.
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE -fno-semantic-interposition)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PRIVATE src)
  target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:silvafit_build_options>)
  install(TARGETS ${target} EXPORT silvafitTargets
          ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
          FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
  if(SILVAFIT_BUILD_TESTS AND tests)
    silvafit_add_tests(${target}_tests LABEL ${name} SOURCES ${tests} LIBRARIES silvafit::${name})
    target_include_directories(${target}_tests PRIVATE src)
  endif()
endfunction()

# silvafit_add_tests(target LABEL name SOURCES ... LIBRARIES ...)
#   A Catch2 program, built by the target `tests`, whose test cases each become a CTest test with the label. A case that cannot
#   run says WARN("skipped: reason") and returns, which CTest reports as skipped.
function(silvafit_add_tests target)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "LABEL" "SOURCES;LIBRARIES")
  add_executable(${target} EXCLUDE_FROM_ALL ${ARG_SOURCES})
  add_dependencies(tests ${target})
  silvafit_compile_together(${target} ${ARG_SOURCES})
  # Their sources compile in about four fifths of the time. The libraries are optimized as always.
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  target_link_libraries(${target} PRIVATE
    ${ARG_LIBRARIES} silvafit_build_options silvafit_test_files Catch2::Catch2WithMain fmt::fmt)
  catch_discover_tests(${target} TEST_PREFIX "${ARG_LABEL}: "
    PROPERTIES LABELS ${ARG_LABEL} TIMEOUT 300 SKIP_REGULAR_EXPRESSION "  skipped: "
    # A name that Catch2 does not find, for example one with a semicolon, has run no test.
    FAIL_REGULAR_EXPRESSION "No tests ran")
endfunction()

# Where tests find files. The paths stand in one object, so that ccache knows the others in any checkout.
if(SILVAFIT_BUILD_TESTS)
  add_library(silvafit_test_files OBJECT EXCLUDE_FROM_ALL ${PROJECT_SOURCE_DIR}/tests/support/reference.cpp)
  target_link_libraries(silvafit_test_files PRIVATE silvafit_build_options)
  target_include_directories(silvafit_test_files INTERFACE ${PROJECT_SOURCE_DIR}/tests/support)
  target_compile_features(silvafit_test_files PUBLIC cxx_std_20)
  target_compile_definitions(silvafit_test_files PRIVATE
    SILVAFIT_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
    SILVAFIT_DATA_DIR="${PROJECT_BINARY_DIR}/share/silvafit")
endif()
