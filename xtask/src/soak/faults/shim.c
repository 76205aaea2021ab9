/* Loaded before the program (LD_PRELOAD): the n-th of its calls to the file system fails, or ends
 * the process.
 *
 * Only files and folders below FAULTS_ROOT count, apart by what a call needs. FAULTS_KIND is one of
 *   full   a disk without room from the n-th call on that needs some; what is there can be removed
 *   once   the n-th call fails with EIO, those after it work
 *   broken the n-th call that changes something fails with EIO, and every such call after it
 *   kill   SIGKILL at the n-th call that changes something; of a write, half is done
 * FAULTS_AT is n, from 1. FAULTS_MARK names a file that is made when the fault has come.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

enum kind { NONE, FULL, ONCE, BROKEN, KILL };
/* What a call needs: it only reads, changes what is there, or needs room besides. */
enum need { READS, CHANGES, GROWS };

static enum kind kind;
static const char *root, *mark;
static size_t root_length;
static long at;
static long count;
/* Which open files are below the root, and which of those were written to since they last had room. */
static char ours[1 << 16], written[1 << 16];

__attribute__((constructor)) static void begin(void) {
    const char *name = getenv("FAULTS_KIND"), *number = getenv("FAULTS_AT");
    root = getenv("FAULTS_ROOT");
    mark = getenv("FAULTS_MARK");
    if (!name || !number || !root || !mark) return;
    root_length = strlen(root);
    at = atol(number);
    kind = !strcmp(name, "full")     ? FULL
           : !strcmp(name, "once")   ? ONCE
           : !strcmp(name, "broken") ? BROKEN
           : !strcmp(name, "kill")   ? KILL
                                     : NONE;
}

static int below(const char *path) {
    return kind != NONE && path && !strncmp(path, root, root_length);
}

static int is_ours(int file) {
    return kind != NONE && file >= 0 && file < (int)sizeof ours && ours[file];
}

static void keep(int file, int is_below) {
    if (file < 0 || file >= (int)sizeof ours) return;
    ours[file] = (char)is_below;
    written[file] = 0;
}

/* Whether this call is the one, or one after it that fails too. */
static int is_due(enum need need) {
    if (kind == FULL && need != GROWS) return 0;
    if ((kind == BROKEN || kind == KILL) && need == READS) return 0;
    long number = __atomic_add_fetch(&count, 1, __ATOMIC_SEQ_CST);
    int due = kind == FULL || kind == BROKEN ? number >= at : number == at;
    if (due) {
        int file = (int)syscall(SYS_openat, AT_FDCWD, mark, O_CREAT | O_WRONLY, 0600);
        if (file >= 0) syscall(SYS_close, file);
    }
    return due;
}

/* The fault has come: the process ends, or the call fails. */
static int fail(void) {
    if (kind == KILL) {
        kill(getpid(), SIGKILL);
        for (;;) pause();
    }
    errno = kind == FULL ? ENOSPC : EIO;
    return -1;
}

#define REAL(name) \
    static __typeof__(name) *real; \
    if (!real) real = (__typeof__(name) *)dlsym(RTLD_NEXT, #name)

static enum need need_to_open(const char *path, int flags) {
    if (flags & O_CREAT && faccessat(AT_FDCWD, path, F_OK, 0)) return GROWS;
    return flags & O_TRUNC ? CHANGES : READS;
}

#define OPENING(name, parameters, call) \
    int name parameters { \
        REAL(name); \
        mode_t mode = 0; \
        if (flags & (O_CREAT | O_TMPFILE)) { \
            va_list rest; \
            va_start(rest, flags); \
            mode = va_arg(rest, mode_t); \
            va_end(rest); \
        } \
        int is_below = below(path); \
        if (is_below && is_due(need_to_open(path, flags))) return fail(); \
        int file = real call; \
        keep(file, is_below); \
        return file; \
    }
OPENING(open, (const char *path, int flags, ...), (path, flags, mode))
OPENING(open64, (const char *path, int flags, ...), (path, flags, mode))
OPENING(openat, (int folder, const char *path, int flags, ...), (folder, path, flags, mode))
OPENING(openat64, (int folder, const char *path, int flags, ...), (folder, path, flags, mode))

int close(int file) {
    REAL(close);
    keep(file, 0);
    return real(file);
}

ssize_t write(int file, const void *bytes, size_t length) {
    REAL(write);
    if (is_ours(file) && is_due(GROWS)) {
        if (length > 1) real(file, bytes, length / 2);
        return fail();
    }
    if (is_ours(file)) written[file] = 1;
    return real(file, bytes, length);
}

ssize_t read(int file, void *bytes, size_t length) {
    REAL(read);
    return is_ours(file) && is_due(READS) ? fail() : real(file, bytes, length);
}

ssize_t pread64(int file, void *bytes, size_t length, off64_t from) {
    REAL(pread64);
    return is_ours(file) && is_due(READS) ? fail() : real(file, bytes, length, from);
}

#define ON_FILE(name, need, parameters, call) \
    int name parameters { \
        REAL(name); \
        return is_ours(file) && is_due(need) ? fail() : call; \
    }
/* What was written may find no room as late as this; what was cut off needs none. */
#define SYNCS (written[file] ? GROWS : CHANGES)
ON_FILE(fsync, SYNCS, (int file), real(file))
ON_FILE(fdatasync, SYNCS, (int file), real(file))

static int cut(int file, int done) {
    if (!done && is_ours(file)) written[file] = 0;
    return done;
}
ON_FILE(ftruncate, CHANGES, (int file, off_t length), cut(file, real(file, length)))
ON_FILE(ftruncate64, CHANGES, (int file, off64_t length), cut(file, real(file, length)))
ON_FILE(fchmod, CHANGES, (int file, mode_t mode), real(file, mode))

#define ON_PATH(name, need, parameters, call) \
    int name parameters { \
        REAL(name); \
        return below(path) && is_due(need) ? fail() : call; \
    }
ON_PATH(mkdir, GROWS, (const char *path, mode_t mode), real(path, mode))
ON_PATH(rmdir, CHANGES, (const char *path), real(path))
ON_PATH(unlink, CHANGES, (const char *path), real(path))
ON_PATH(chmod, CHANGES, (const char *path, mode_t mode), real(path, mode))
ON_PATH(rename, CHANGES, (const char *path, const char *to), real(path, to))
