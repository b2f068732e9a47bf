#pragma once
// Put before each file of hal/linux that claims to be POSIX (hal/linux/posix.cmake) when it is compiled as such: with
// nothing of Linux' or GNU's in sight but what is declared here, which today's BSDs have as well.
// Source:  POSIX.1-2008 with XSI; the manual pages pipe(2), accept(2), poll(2), mmap(2) of FreeBSD 14 and OpenBSD 7.4.
#include <bits/c++config.h>
// What libstdc++ would else build from calls of this system for itself.
#undef _GLIBCXX_HAVE_LINUX_FUTEX
#undef _GLIBCXX_USE_PTHREAD_COND_CLOCKWAIT
#undef _GLIBCXX_USE_PTHREAD_MUTEX_CLOCKLOCK
#undef _GLIBCXX_USE_PTHREAD_RWLOCK_CLOCKLOCK
#include <poll.h>
#include <sys/socket.h>

extern "C" {
int pipe2(int pipe[2], int flags) noexcept;
int accept4(int listener, sockaddr* address, socklen_t* bytes, int flags);
int ppoll(pollfd* fds, nfds_t count, const timespec* patience, const sigset_t* mask);
}
