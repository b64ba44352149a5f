# SPDX-License-Identifier: MIT
# Toolchain for programs of 64-bit Windows on Debian (make windows).
cmake_path(GET CMAKE_CURRENT_LIST_DIR PARENT_PATH libraries)
string(APPEND libraries /build-windows/libraries)
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_ASM_COMPILER ${CMAKE_C_COMPILER})
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
# g++ stores vector registers on a stack that Windows aligns to 16 bytes only (its bug 54412), so that no store may need more.
# Templates have more sections than the usual form of object files allows.
set(CMAKE_C_FLAGS_INIT "-Wa,-muse-unaligned-vector-move")
set(CMAKE_CXX_FLAGS_INIT "-Wa,-muse-unaligned-vector-move,-mbig-obj")
set(CMAKE_EXE_LINKER_FLAGS_INIT -static)
set(CMAKE_FIND_ROOT_PATH /usr/x86_64-w64-mingw32 ${libraries})
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
# Libraries of headers alone are Debian's; scripts/static-libraries links those of /usr/include, which has those of Linux, too.
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE BOTH)
set(CMAKE_CXX_STANDARD_INCLUDE_DIRECTORIES ${libraries}/include)
