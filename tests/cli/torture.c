// Shared library for LD_PRELOAD that fails an operation on the files of one folder, or kills the process in its place.
//
// TORTURE_FOLDER is the folder, by its absolute path without links, in which the process runs. TORTURE_AT is the number of the operation, counted from 1. TORTURE_DEED is
// `once` (it fails with EIO), `on` (it and all later ones fail with ENOSPC) or `kill`. TORTURE_LOG is a file, outside of the folder,
// that gets a line for each operation. The deed `hold` disturbs nothing, but the opening of scene.xml waits until there is a file
// TORTURE_RELEASE.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/uio.h>
#include <unistd.h>

static atomic_int count;

#define REAL(name) \
    static __typeof__(&name) real; \
    if (!real) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)

static int is_below(const char *path) {
    const char *folder = getenv("TORTURE_FOLDER");
    if (!folder) return 0;
    if (path[0] != '/') return 1; // The process runs in the folder.
    size_t length = strlen(folder);
    return strncmp(path, folder, length) == 0 && (path[length] == '/' || path[length] == 0);
}

static int is_file_below(int file) {
    char link[64], path[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return path[0] == '/' && is_below(path);
}

// Counts an operation. Returns whether it must fail, with errno set.
static int fails(const char *what) {
    int number = atomic_fetch_add(&count, 1) + 1;
    const char *log = getenv("TORTURE_LOG"), *at = getenv("TORTURE_AT"), *deed = getenv("TORTURE_DEED");
    if (log) {
        FILE *file = fopen(log, "a");
        if (file) {
            fprintf(file, "%d %s\n", number, what);
            fclose(file);
        }
    }
    if (!at || !deed) return 0;
    int wanted = atoi(at);
    if (strcmp(deed, "on") == 0 ? number < wanted : number != wanted) return 0;
    if (strcmp(deed, "kill") == 0) kill(getpid(), SIGKILL);
    errno = strcmp(deed, "on") == 0 ? ENOSPC : EIO;
    return 1;
}

static void hold(const char *path) {
    const char *deed = getenv("TORTURE_DEED"), *release = getenv("TORTURE_RELEASE");
    if (!deed || !release || strcmp(deed, "hold") != 0 || !strstr(path, "scene.xml")) return;
    fails("hold");
    while (access(release, F_OK) != 0) usleep(10000);
}

static int mode_of(int flags, va_list rest) { return flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, int) : 0; }

#define OPEN(name) \
    int name(const char *path, int flags, ...) { \
        REAL(name); \
        va_list rest; \
        va_start(rest, flags); \
        int mode = mode_of(flags, rest); \
        va_end(rest); \
        if (is_below(path)) hold(path); \
        if (is_below(path) && fails(#name)) return -1; \
        return real(path, flags, mode); \
    }
OPEN(open)
OPEN(open64)

ssize_t write(int file, const void *bytes, size_t length) {
    REAL(write);
    if (is_file_below(file) && fails("write")) return -1;
    return real(file, bytes, length);
}

ssize_t writev(int file, const struct iovec *parts, int length) {
    REAL(writev);
    if (is_file_below(file) && fails("writev")) return -1;
    return real(file, parts, length);
}

int fsync(int file) {
    REAL(fsync);
    if (is_file_below(file) && fails("fsync")) return -1;
    return real(file);
}

int fdatasync(int file) {
    REAL(fdatasync);
    if (is_file_below(file) && fails("fdatasync")) return -1;
    return real(file);
}

int flock(int file, int operation) {
    REAL(flock);
    if (is_file_below(file) && fails("flock")) return -1;
    return real(file, operation);
}

int rename(const char *from, const char *to) {
    REAL(rename);
    if (is_below(to) && fails("rename")) return -1;
    return real(from, to);
}

int unlink(const char *path) {
    REAL(unlink);
    if (is_below(path) && fails("unlink")) return -1;
    return real(path);
}
