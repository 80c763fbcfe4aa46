// SPDX-License-Identifier: MIT
//
// Preloaded into a run, fails the n-th call of one function: FAIL_CALL=write FAIL_AT=3. If it did,
// the file FAIL_MARK exists afterwards. For glibc.

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

static const char* call;
static long at;
static atomic_long calls;

__attribute__((constructor)) static void start(void)
{
    const char* number = getenv("FAIL_AT");
    at = number ? atol(number) : 0;
    call = getenv("FAIL_CALL");
}

static int fails(const char* name)
{
    if (!call || at == 0 || strcmp(call, name) != 0 || atomic_fetch_add(&calls, 1) + 1 != at)
        return 0;
    const char* mark = getenv("FAIL_MARK");
    if (mark)
        syscall(SYS_close, syscall(SYS_openat, AT_FDCWD, mark, O_CREAT | O_WRONLY, 0666));
    return 1;
}

#define NEXT(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int file, const void* bytes, size_t size)
{
    if (file > 2 && fails("write")) {
        errno = ENOSPC;
        return -1;
    }
    return syscall(SYS_write, file, bytes, size);
}

// HDF5's files are written by it; to a run both are writing.
ssize_t pwrite64(int file, const void* bytes, size_t size, off_t offset)
{
    if (file > 2 && fails("write")) {
        errno = ENOSPC;
        return -1;
    }
    return syscall(SYS_pwrite64, file, bytes, size, offset);
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset)
{
    return pwrite64(file, bytes, size, offset);
}

int fsync(int file)
{
    if (fails("fsync")) {
        errno = EIO;
        return -1;
    }
    return (int)syscall(SYS_fsync, file);
}

int rename(const char* from, const char* to)
{
    if (fails("rename")) {
        errno = EIO;
        return -1;
    }
    return (int)syscall(SYS_rename, from, to);
}

int renameat(int from_place, const char* from, int to_place, const char* to)
{
    if (fails("rename")) {
        errno = EIO;
        return -1;
    }
    return (int)syscall(SYS_renameat, from_place, from, to_place, to);
}

int renameat2(int from_place, const char* from, int to_place, const char* to, unsigned int flags)
{
    if (fails("rename")) {
        errno = EIO;
        return -1;
    }
    return (int)syscall(SYS_renameat2, from_place, from, to_place, to, flags);
}

pid_t fork(void)
{
    if (fails("fork")) {
        errno = EAGAIN;
        return -1;
    }
    return NEXT(fork)();
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* data)
{
    if (fails("thread"))
        return EAGAIN;
    return NEXT(pthread_create)(thread, attributes, run, data);
}

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

void* malloc(size_t size)
{
    if (fails("malloc")) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_malloc(size);
}

void* calloc(size_t count, size_t size)
{
    if (fails("malloc")) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_calloc(count, size);
}

void* realloc(void* old, size_t size)
{
    if (fails("malloc")) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_realloc(old, size);
}

void* aligned_alloc(size_t alignment, size_t size)
{
    if (fails("malloc")) {
        errno = ENOMEM;
        return NULL;
    }
    return __libc_memalign(alignment, size);
}
