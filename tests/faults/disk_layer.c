// SPDX-License-Identifier: Apache-2.0
// A disk that fails on purpose, and one that tells what it was asked: loaded before a program (LD_PRELOAD), it stands
// between the program and the C library for everything that changes files below $SOAK_DISK_FOLDER.
//
//   SOAK_DISK_LOG       file that gets a line for each change: "write PATH", "sync PATH", "rename FROM TO", "remove
//   PATH"... SOAK_DISK_FAIL_AT   the change with this number (1, 2, ...) fails SOAK_DISK_ERROR     with this error
//   number (default 5, EIO) SOAK_DISK_FROM_THERE set: and all after it
//
// Failed changes are logged as "failed WHAT PATH". The -shm file of SQLite is memory, not storage, and is left alone.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static atomic_long changes;

// Absolute form of a path, without looking at links: PATH_MAX bytes in `buffer`.
static const char* absolute(const char* path, char* buffer) {
  if (path[0] == '/') return path;
  if (getcwd(buffer, PATH_MAX) == NULL) return path;
  const size_t used = strlen(buffer);
  snprintf(buffer + used, PATH_MAX - used, "/%s", path);
  return buffer;
}

static int is_watched(const char* path) {
  const char* folder = getenv("SOAK_DISK_FOLDER");
  if (folder == NULL || strncmp(path, folder, strlen(folder)) != 0) return 0;
  const size_t length = strlen(path);
  return length < 4 || strcmp(path + length - 4, "-shm") != 0;
}

static void note(const char* what, const char* path, const char* second) {
  const char* log = getenv("SOAK_DISK_LOG");
  if (log == NULL) return;
  char line[3 * PATH_MAX];
  const int length =
      snprintf(line, sizeof line, "%s %s%s%s\n", what, path, second == NULL ? "" : " ", second == NULL ? "" : second);
  const int file = NEXT(open)(log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) return;
  if (NEXT(write)(file, line, (size_t)length) < 0) abort();
  close(file);
}

// Counts a change. Returns 0 where it may be carried out; else it fails with errno.
static int refuse(const char* what, const char* path, const char* second) {
  char buffer[PATH_MAX];
  path = absolute(path, buffer);
  if (!is_watched(path)) return 0;
  const char* at = getenv("SOAK_DISK_FAIL_AT");
  const long number = atomic_fetch_add(&changes, 1) + 1;
  const long first = at == NULL ? 0 : atol(at);
  if (first > 0 && (number == first || (number > first && getenv("SOAK_DISK_FROM_THERE") != NULL))) {
    char failed[64];
    snprintf(failed, sizeof failed, "failed %s", what);
    note(failed, path, second);
    const char* error = getenv("SOAK_DISK_ERROR");
    errno = error == NULL ? EIO : atoi(error);
    return 1;
  }
  note(what, path, second);
  return 0;
}

static int refuse_descriptor(const char* what, int file) {
  char name[64];
  char path[PATH_MAX];
  const int saved = errno;
  snprintf(name, sizeof name, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(name, path, sizeof path - 1);
  errno = saved;
  if (length <= 0) return 0;
  path[length] = '\0';
  return refuse(what, path, NULL);
}

#define WRITER(name, parameters, arguments) \
  ssize_t name parameters { return refuse_descriptor("write", file) ? -1 : NEXT(name) arguments; }
WRITER(write, (int file, const void* data, size_t size), (file, data, size))
WRITER(pwrite, (int file, const void* data, size_t size, off_t at), (file, data, size, at))
WRITER(pwrite64, (int file, const void* data, size_t size, off64_t at), (file, data, size, at))

#define CHANGER(what, name, parameters, arguments) \
  int name parameters { return refuse_descriptor(what, file) ? -1 : NEXT(name) arguments; }
CHANGER("sync", fsync, (int file), (file))
CHANGER("sync", fdatasync, (int file), (file))
CHANGER("truncate", ftruncate, (int file, off_t size), (file, size))
CHANGER("truncate", ftruncate64, (int file, off64_t size), (file, size))

int rename(const char* from, const char* to) { return refuse("rename", from, to) ? -1 : NEXT(rename)(from, to); }
int mkdir(const char* path, mode_t mode) { return refuse("mkdir", path, NULL) ? -1 : NEXT(mkdir)(path, mode); }

// Removal is logged and never fails: it is how what failed is cleared away.
int unlink(const char* path) {
  char buffer[PATH_MAX];
  if (is_watched(absolute(path, buffer))) note("remove", absolute(path, buffer), NULL);
  return NEXT(unlink)(path);
}

#define OPENER(name)                                                                                  \
  int name(const char* path, int flags, ...) {                                                        \
    mode_t mode = 0;                                                                                  \
    if ((flags & (O_CREAT | O_TMPFILE)) != 0) {                                                       \
      va_list rest;                                                                                   \
      va_start(rest, flags);                                                                          \
      mode = (mode_t)va_arg(rest, int);                                                               \
      va_end(rest);                                                                                   \
    }                                                                                                 \
    if ((flags & O_CREAT) != 0 && access(path, F_OK) != 0 && refuse("create", path, NULL)) return -1; \
    return NEXT(name)(path, flags, mode);                                                             \
  }
OPENER(open)
OPENER(open64)
