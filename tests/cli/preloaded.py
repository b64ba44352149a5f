# SPDX-License-Identifier: MIT
"""Functions of the C library that behave as on a bad day, loaded before the program's own."""

import os
import shutil
import subprocess
import unittest

COMPILER = shutil.which("cc")


def library(folder, name, source):
    """The environment in which programs use the functions of a C source; the test is skipped without a compiler."""
    if COMPILER is None:
        raise unittest.SkipTest("there is no C compiler")
    code, built = folder / f"{name}.c", folder / f"{name}.so"
    code.write_text("#define _GNU_SOURCE\n" + source, encoding="utf-8")
    subprocess.run([COMPILER, "-shared", "-fPIC", "-O1", "-o", str(built), str(code), "-ldl"], check=True)
    return os.environ | {"LD_PRELOAD": str(built)}


# Every process has the same number, as in containers that share a folder.
ONE_NUMBER = """
#include <unistd.h>
pid_t getpid(void) { return 7; }
"""

# The FAIL_AT-th call (from 1) of write, fsync, rename and close of a written file together fails: no space is left. FAIL_LOG
# lists the calls.
FAILING_DISK = r"""
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
static int calls = 0;
static int fails(const char* name, const char* detail) {
  static ssize_t (*real)(int, const void*, size_t) = NULL;
  if (real == NULL) real = (ssize_t (*)(int, const void*, size_t))dlsym(RTLD_NEXT, "write");
  const char* log = getenv("FAIL_LOG");
  const char* at = getenv("FAIL_AT");
  int number = __atomic_add_fetch(&calls, 1, __ATOMIC_SEQ_CST);
  if (log != NULL) {
    char line[600];
    int length = snprintf(line, sizeof(line), "%s %s\n", name, detail);
    int file = open(log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    real(file, line, length);
    ((int (*)(int))dlsym(RTLD_NEXT, "close"))(file);
  }
  if (at == NULL || atoi(at) != number) return 0;
  errno = ENOSPC;
  return 1;
}
static int is_file(int descriptor) {
  struct stat status;
  return descriptor > 2 && fstat(descriptor, &status) == 0 && (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode));
}
static const char* kind(int descriptor) {
  struct stat status;
  fstat(descriptor, &status);
  return S_ISDIR(status.st_mode) ? "folder" : "file";
}
ssize_t write(int descriptor, const void* bytes, size_t count) {
  static ssize_t (*real)(int, const void*, size_t) = NULL;
  if (real == NULL) real = (ssize_t (*)(int, const void*, size_t))dlsym(RTLD_NEXT, "write");
  if (is_file(descriptor) && fails("write", kind(descriptor))) return -1;
  return real(descriptor, bytes, count);
}
int fsync(int descriptor) {
  static int (*real)(int) = NULL;
  if (real == NULL) real = (int (*)(int))dlsym(RTLD_NEXT, "fsync");
  if (fails("fsync", kind(descriptor))) return -1;
  return real(descriptor);
}
/* Networked file systems report a full disk when the file is closed; the descriptor is gone all the same. */
int close(int descriptor) {
  static int (*real)(int) = NULL;
  if (real == NULL) real = (int (*)(int))dlsym(RTLD_NEXT, "close");
  int is_written = is_file(descriptor) && (fcntl(descriptor, F_GETFL) & O_ACCMODE) != O_RDONLY;
  int failed = is_written && fails("close", "file");
  int error = errno;
  int result = real(descriptor);
  errno = failed ? error : errno;
  return failed ? -1 : result;
}
int rename(const char* from, const char* to) {
  static int (*real)(const char*, const char*) = NULL;
  if (real == NULL) real = (int (*)(const char*, const char*))dlsym(RTLD_NEXT, "rename");
  if (fails("rename", to)) return -1;
  return real(from, to);
}
"""

# There is no /proc.
NO_PROC = """
#include <dlfcn.h>
#include <errno.h>
#include <stdarg.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
static int is_hidden(const char* path) {
  if (strncmp(path, "/proc", 5) != 0) return 0;
  errno = ENOENT;
  return 1;
}
int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  mode_t mode = va_arg(more, mode_t);
  va_end(more);
  int (*real)(const char*, int, ...) = (int (*)(const char*, int, ...))dlsym(RTLD_NEXT, "open");
  return is_hidden(path) ? -1 : real(path, flags, mode);
}
ssize_t readlink(const char* path, char* target, size_t size) {
  ssize_t (*real)(const char*, char*, size_t) = (ssize_t (*)(const char*, char*, size_t))dlsym(RTLD_NEXT, "readlink");
  return is_hidden(path) ? -1 : real(path, target, size);
}
int stat(const char* path, struct stat* status) {
  int (*real)(const char*, struct stat*) = (int (*)(const char*, struct stat*))dlsym(RTLD_NEXT, "stat");
  return is_hidden(path) ? -1 : real(path, status);
}
"""

# No thread can be started.
NO_THREADS = """
#include <errno.h>
#include <pthread.h>
int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*function)(void*), void* argument) {
  (void)thread; (void)attributes; (void)function; (void)argument;
  return EAGAIN;
}
"""
