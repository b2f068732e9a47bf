#pragma once
// Included before each file of hal/linux that says it is POSIX (posix.txt): only POSIX and the declarations here are
// visible, which FreeBSD and NetBSD have as well; nothing of Linux or GNU.
// Source:  POSIX.1-2008 with XSI; pipe(2), accept(2), poll(2), ptsname(3) of FreeBSD and NetBSD. The first two and
//          ptsname_r() are in POSIX.1-2024.
#include <bits/c++config.h>
// Without this, libstdc++ would use calls of this system for itself.
#undef _GLIBCXX_HAVE_LINUX_FUTEX
#undef _GLIBCXX_USE_PTHREAD_COND_CLOCKWAIT
#undef _GLIBCXX_USE_PTHREAD_MUTEX_CLOCKLOCK
#undef _GLIBCXX_USE_PTHREAD_RWLOCK_CLOCKLOCK
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <time.h>

extern "C" {
int pipe2(int* pipe, int flags) noexcept;
int accept4(int listener, sockaddr* address, socklen_t* bytes, int flags);
int ppoll(pollfd* fds, nfds_t count, const timespec* patience, const sigset_t* mask);
int ptsname_r(int line, char* name, size_t room) noexcept;
}
