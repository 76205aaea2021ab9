// A disk whose every tenth sync takes 5 s, for zwidth alone: cc -shared -fPIC -o slow_sync.so slow_sync.c -ldl, then
// LD_PRELOAD=…/slow_sync.so cargo xtask soak live 3. How many syncs were slow, it says at the program's end.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

static const int SLOW_S = 5, ONE_IN = 10;
static atomic_int syncs;

static void stall(void) {
    if (strcmp(program_invocation_short_name, "zwidth")) return;
    if (atomic_fetch_add(&syncs, 1) % ONE_IN == ONE_IN - 1) nanosleep(&(struct timespec){.tv_sec = SLOW_S}, NULL);
}

static int then(const char *name, int file) {
    stall();
    return ((int (*)(int))dlsym(RTLD_NEXT, name))(file);
}

int fsync(int file) { return then("fsync", file); }
int fdatasync(int file) { return then("fdatasync", file); }

__attribute__((destructor)) static void told(void) {
    int slow = syncs / ONE_IN;
    if (slow) fprintf(stderr, "%d of %d syncs took %d s each\n", slow, syncs, SLOW_S);
}
