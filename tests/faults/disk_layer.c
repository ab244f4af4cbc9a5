// SPDX-License-Identifier: Apache-2.0
// A disk that fails on purpose, and one that tells what it was asked: loaded before a program (LD_PRELOAD), it stands
// between the program and the C library for everything that changes files below $SOAK_DISK_FOLDER.
//
//   SOAK_DISK_LOG         file that gets a line for each change: "write PATH", "sync PATH", "rename FROM TO", ...
//   SOAK_DISK_FAIL_AT     the change with this number (1, 2, ...) fails
//   SOAK_DISK_ERROR       with this error number (default 5, EIO)
//   SOAK_DISK_FROM_THERE  set: and all after it
//   SOAK_DISK_RECORD      file that gets each change with its bytes, in the order in which they were carried out:
//                         power_cut.py makes of it what a loss of power leaves
//
// Failed changes are logged as "failed WHAT PATH". The -shm file of SQLite is memory, not storage, and is left alone.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
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

// Path of an open file; 0 where it has none.
static int path_of(int file, char* path) {
  char name[64];
  const int saved = errno;
  snprintf(name, sizeof name, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(name, path, PATH_MAX - 1);
  errno = saved;
  if (length <= 0) return 0;
  path[length] = '\0';
  return 1;
}

static int refuse_descriptor(const char* what, int file) {
  char path[PATH_MAX];
  return path_of(file, path) && refuse(what, path, NULL);
}

// --- the record --------------------------------------------------------------------------------------------------

// As it stands before the bytes of each change; power_cut.py reads the same.
struct Entry {
  char what;  // Create, Directory, Move, Remove (names); Write, Truncate, Sync (of the file or folder `inode`)
  char pad[7];
  uint64_t inode;
  uint64_t at;  // place of a write, new size
  uint32_t length;
  uint32_t second_length;
};

static pthread_mutex_t order = PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP;

// What is carried out between the two stands in the record in the same order, whichever threads ask.
static void begin_change(void) {
  if (getenv("SOAK_DISK_RECORD") != NULL) pthread_mutex_lock(&order);
}
static void end_change(void) {
  if (getenv("SOAK_DISK_RECORD") != NULL) pthread_mutex_unlock(&order);
}

static void keep(struct Entry entry, const void* bytes, const void* second) {
  static int record = -1;
  const int saved = errno;
  if (record < 0) record = NEXT(open)(getenv("SOAK_DISK_RECORD"), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  const struct iovec parts[] = {
      {&entry, sizeof entry}, {(void*)bytes, entry.length}, {(void*)second, entry.second_length}};
  const ssize_t whole = (ssize_t)sizeof entry + entry.length + entry.second_length;
  if (record < 0 || writev(record, parts, 3) != whole) abort();
  errno = saved;
}

static void keep_change(char what, int file, const void* data, size_t size, uint64_t at) {
  char path[PATH_MAX];
  struct stat state;
  if (getenv("SOAK_DISK_RECORD") == NULL || !path_of(file, path) || !is_watched(path) || fstat(file, &state) != 0)
    return;
  keep((struct Entry){what, {0}, state.st_ino, at, (uint32_t)size, 0}, data, NULL);
}

static void keep_name(char what, const char* path, const char* second) {
  char buffer[PATH_MAX];
  char second_buffer[PATH_MAX];
  struct stat state;
  path = absolute(path, buffer);
  if (getenv("SOAK_DISK_RECORD") == NULL || !is_watched(path)) return;
  if (second != NULL) second = absolute(second, second_buffer);
  const uint64_t inode = stat(second == NULL ? path : second, &state) == 0 ? state.st_ino : 0;
  const uint32_t second_length = second == NULL ? 0 : (uint32_t)strlen(second);
  keep((struct Entry){what, {0}, inode, 0, (uint32_t)strlen(path), second_length}, path, second);
}

// --- what stands before the C library -----------------------------------------------------------------------------

static ssize_t kept_write(int file, const void* data, ssize_t written, off64_t at) {
  if (written > 0) keep_change('W', file, data, (size_t)written, (uint64_t)at);
  end_change();
  return written;
}

ssize_t write(int file, const void* data, size_t size) {
  if (refuse_descriptor("write", file)) return -1;
  begin_change();
  const ssize_t written = NEXT(write)(file, data, size);
  return kept_write(file, data, written, written > 0 ? lseek64(file, 0, SEEK_CUR) - written : 0);
}
ssize_t pwrite(int file, const void* data, size_t size, off_t at) {
  if (refuse_descriptor("write", file)) return -1;
  begin_change();
  return kept_write(file, data, NEXT(pwrite)(file, data, size, at), at);
}
ssize_t pwrite64(int file, const void* data, size_t size, off64_t at) {
  if (refuse_descriptor("write", file)) return -1;
  begin_change();
  return kept_write(file, data, NEXT(pwrite64)(file, data, size, at), at);
}

#define CHANGER(what, letter, name, parameters, arguments, at)         \
  int name parameters {                                                \
    if (refuse_descriptor(what, file)) return -1;                      \
    begin_change();                                                    \
    const int status = NEXT(name) arguments;                           \
    if (status == 0) keep_change(letter, file, NULL, 0, (uint64_t)at); \
    end_change();                                                      \
    return status;                                                     \
  }
CHANGER("sync", 'S', fsync, (int file), (file), 0)
CHANGER("sync", 'S', fdatasync, (int file), (file), 0)
CHANGER("truncate", 'T', ftruncate, (int file, off_t size), (file, size), size)
CHANGER("truncate", 'T', ftruncate64, (int file, off64_t size), (file, size), size)

static int kept_name(int status, char what, const char* path, const char* second) {
  if (status == 0) keep_name(what, path, second);
  end_change();
  return status;
}

int rename(const char* from, const char* to) {
  if (refuse("rename", from, to)) return -1;
  begin_change();
  return kept_name(NEXT(rename)(from, to), 'M', from, to);
}
int mkdir(const char* path, mode_t mode) {
  if (refuse("mkdir", path, NULL)) return -1;
  begin_change();
  return kept_name(NEXT(mkdir)(path, mode), 'D', path, NULL);
}

// Removal is logged and never fails: it is how what failed is cleared away.
int unlink(const char* path) {
  char buffer[PATH_MAX];
  if (is_watched(absolute(path, buffer))) note("remove", absolute(path, buffer), NULL);
  begin_change();
  return kept_name(NEXT(unlink)(path), 'R', path, NULL);
}

static int kept_open(int file, const char* path, int flags, int is_new) {
  if (file >= 0 && is_new) keep_name('C', path, NULL);
  if (file >= 0 && !is_new && (flags & O_TRUNC) != 0) keep_change('T', file, NULL, 0, 0);
  end_change();
  return file;
}

#define OPENER(name)                                                                     \
  int name(const char* path, int flags, ...) {                                           \
    mode_t mode = 0;                                                                     \
    if ((flags & (O_CREAT | O_TMPFILE)) != 0) {                                          \
      va_list rest;                                                                      \
      va_start(rest, flags);                                                             \
      mode = (mode_t)va_arg(rest, int);                                                  \
      va_end(rest);                                                                      \
    }                                                                                    \
    begin_change();                                                                      \
    const int is_new = (flags & O_CREAT) != 0 && access(path, F_OK) != 0;                \
    const int refused = is_new && refuse("create", path, NULL);                          \
    return kept_open(refused ? -1 : NEXT(name)(path, flags, mode), path, flags, is_new); \
  }
OPENER(open)
OPENER(open64)
