// Faults of a machine, for a program that knows nothing of them: LD_PRELOAD, with these in its environment.
//
//   FAULT_ON     part of the name of a file; only what is done to such files counts
//   FAULT_FULL   after so many bytes there is no room for more on the disk
//   FAULT_RESERVE  room can be reserved all the same
//   FAULT_KILL   the call of this number, from 1, that changes a file is its last: a write is done in part
//   FAULT_COUNT  a file that gets the number of these calls
//   FAULT_SLOW   microseconds that every 4 kB of a write take
//   FAULT_CLOCK  seconds by which the clock of the day is put back, once such a file was changed
//   FAULT_NAN    the factor of this number, from 1, has a NaN in it
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/cholmod.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static const char* text(const char* name) { return getenv(name); }
static long number(const char* name) { return text(name) ? atol(text(name)) : 0; }

static long calls = 0;
static long bytes = 0;

static int is_meant(const char* path) {
  return text("FAULT_ON") != NULL && path != NULL && strstr(path, text("FAULT_ON")) != NULL;
}

static int is_meant_open(int descriptor) {
  char link[64];
  char path[4096];
  snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t n = readlink(link, path, sizeof path - 1);
  if (n < 0) return 0;
  path[n] = '\0';
  return is_meant(path);
}

// Whether it was the call to die after; told before the call is made.
static int counted(void) {
  ++calls;
  if (text("FAULT_COUNT")) {
    char line[32];
    const int n = snprintf(line, sizeof line, "%ld\n", calls);
    const int file = REAL(open)(text("FAULT_COUNT"), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    (void)!REAL(write)(file, line, n);
    close(file);
  }
  return calls == number("FAULT_KILL");
}

// Half of them before, half after the call.
static void die_before(int last) {
  if (last && calls % 2 == 0) kill(getpid(), SIGKILL);
}
static void die_after(int last) {
  if (last) kill(getpid(), SIGKILL);
}

static int has_no_room(long size) {
  return text("FAULT_FULL") && !text("FAULT_RESERVE") && bytes + size > number("FAULT_FULL");
}

static int is_full(long more) {
  if (!text("FAULT_FULL")) return 0;
  bytes += more;
  return bytes > number("FAULT_FULL");
}

static ssize_t put(int descriptor, const char* data, size_t size, off_t at, int has_place) {
  const int is_here = is_meant_open(descriptor);
  if (!is_here && has_place) return REAL(pwrite)(descriptor, data, size, at);
  if (!is_here) return REAL(write)(descriptor, data, size);
  const int last = counted();
  if (is_full((long)size)) {
    errno = ENOSPC;
    return -1;
  }
  const long pause = number("FAULT_SLOW");
  size_t done = 0;
  while (pause > 0 && size - done > 4096) {
    usleep((useconds_t)pause);
    if (has_place) {
      (void)!REAL(pwrite)(descriptor, data + done, 4096, at + (off_t)done);
    } else {
      (void)!REAL(write)(descriptor, data + done, 4096);
    }
    done += 4096;
  }
  const size_t rest = last ? (size - done) / 2 : size - done;
  const ssize_t n = has_place ? REAL(pwrite)(descriptor, data + done, rest, at + (off_t)done)
                              : REAL(write)(descriptor, data + done, rest);
  die_after(last);
  return n < 0 ? n : n + (ssize_t)done;
}

ssize_t write(int descriptor, const void* data, size_t size) { return put(descriptor, data, size, 0, 0); }
ssize_t pwrite(int descriptor, const void* data, size_t size, off_t at) {
  return put(descriptor, data, size, at, 1);
}

#define CHANGES(name, is_here, ...)         \
  if (!(is_here)) return REAL(name)(__VA_ARGS__); \
  const int last = counted();               \
  die_before(last);                         \
  const int outcome = REAL(name)(__VA_ARGS__); \
  const int reason = errno;                 \
  die_after(last);                          \
  errno = reason;                           \
  return outcome

int rename(const char* from, const char* to) { CHANGES(rename, is_meant(from) || is_meant(to), from, to); }
int unlink(const char* path) { CHANGES(unlink, is_meant(path), path); }
int truncate(const char* path, off_t size) { CHANGES(truncate, is_meant(path), path, size); }
int ftruncate(int descriptor, off_t size) { CHANGES(ftruncate, is_meant_open(descriptor), descriptor, size); }
int fallocate(int descriptor, int mode, off_t at, off_t size) {
  if (is_meant_open(descriptor) && has_no_room(size)) {
    errno = ENOSPC;
    return -1;
  }
  CHANGES(fallocate, is_meant_open(descriptor), descriptor, mode, at, size);
}
int posix_fallocate(int descriptor, off_t at, off_t size) {
  if (is_meant_open(descriptor) && has_no_room(size)) return ENOSPC;
  CHANGES(posix_fallocate, is_meant_open(descriptor), descriptor, at, size);
}

time_t time(time_t* out) {
  struct timespec now;
  REAL(clock_gettime)(CLOCK_REALTIME, &now);
  const time_t t = now.tv_sec - (calls > 0 ? number("FAULT_CLOCK") : 0);
  if (out) *out = t;
  return t;
}
int clock_gettime(clockid_t clock, struct timespec* now) {
  const int outcome = REAL(clock_gettime)(clock, now);
  if (clock == CLOCK_REALTIME && calls > 0) now->tv_sec -= number("FAULT_CLOCK");
  return outcome;
}

int cholmod_l_factorize(cholmod_sparse* a, cholmod_factor* l, cholmod_common* common) {
  static long n = 0;
  const int outcome = REAL(cholmod_l_factorize)(a, l, common);
  if (++n == number("FAULT_NAN")) {
    const uint64_t nan = UINT64_C(0x7ff8000000000000);
    memcpy((double*)l->x + l->xsize / 2, &nan, sizeof nan);
  }
  return outcome;
}
