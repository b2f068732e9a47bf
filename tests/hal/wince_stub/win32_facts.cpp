#include "win32_facts.hpp"

// The order matters: after windows.h alone there is the Winsock of 1995, and no other.
// clang-format off
#include <winsock2.h>
#include <ws2tcpip.h>
#include <windows.h>
// clang-format on

#include <cstddef>

namespace sinew::hal {
namespace {

template <class T>
std::int64_t value(T t) {
  return static_cast<std::int64_t>(t);
}

}  // namespace

#define VALUE(name) \
  { #name, value(name) }
#define SIZE(type) \
  { #type, value(sizeof(type)) }
#define PLACE(type, member) \
  { #type "::" #member, value(offsetof(type, member)) }

std::vector<Win32Fact> system_facts() {
  return {
      VALUE(INFINITE),
      VALUE(CREATE_SUSPENDED),
      VALUE(STACK_SIZE_PARAM_IS_A_RESERVATION),
      VALUE(TLS_OUT_OF_INDEXES),
      VALUE(THREAD_PRIORITY_IDLE),
      VALUE(THREAD_PRIORITY_LOWEST),
      VALUE(THREAD_PRIORITY_BELOW_NORMAL),
      VALUE(THREAD_PRIORITY_NORMAL),
      VALUE(THREAD_PRIORITY_ABOVE_NORMAL),
      VALUE(THREAD_PRIORITY_HIGHEST),
      VALUE(THREAD_PRIORITY_TIME_CRITICAL),
      VALUE(PAGE_READWRITE),
      VALUE(FILE_MAP_WRITE),
      VALUE(FILE_MAP_READ),
      VALUE(AF_UNSPEC),
      VALUE(SOCK_STREAM),
      VALUE(IPPROTO_TCP),
      VALUE(TCP_NODELAY),
      VALUE(SOL_SOCKET),
      VALUE(SO_KEEPALIVE),
      VALUE(SO_EXCLUSIVEADDRUSE),
      VALUE(SO_ERROR),
      VALUE(SD_BOTH),
      {"FIONBIO", static_cast<std::int32_t>(FIONBIO)},
      VALUE(AI_PASSIVE),
      VALUE(FD_SETSIZE),
      VALUE(NI_NUMERICHOST),
      VALUE(NI_NUMERICSERV),
      VALUE(WSAEWOULDBLOCK),
      VALUE(WSAEACCES),
      VALUE(WSAEADDRINUSE),
      VALUE(WSAECONNABORTED),
      VALUE(WSAECONNRESET),
      VALUE(WSAENOBUFS),
      VALUE(WSAENOTCONN),
      VALUE(WSAESHUTDOWN),
      VALUE(WSAETIMEDOUT),
      VALUE(WSAECONNREFUSED),
      VALUE(WSAEHOSTUNREACH),
      VALUE(WSAHOST_NOT_FOUND),
      SIZE(HANDLE),
      SIZE(BOOL),
      SIZE(DWORD),
      SIZE(WORD),
      SIZE(FILETIME),
      PLACE(FILETIME, dwHighDateTime),
      SIZE(LARGE_INTEGER),
      SIZE(SOCKET),
      SIZE(SOCKADDR_STORAGE),
      PLACE(SOCKADDR_STORAGE, ss_family),
      SIZE(ADDRINFO),
      PLACE(ADDRINFO, ai_addrlen),
      PLACE(ADDRINFO, ai_canonname),
      PLACE(ADDRINFO, ai_addr),
      PLACE(ADDRINFO, ai_next),
      SIZE(fd_set),
      PLACE(fd_set, fd_array),
      SIZE(timeval),
      PLACE(timeval, tv_usec),
      SIZE(WSABUF),
      PLACE(WSABUF, buf),
      SIZE(CRITICAL_SECTION),
      SIZE(WSADATA),
  };
}

}  // namespace sinew::hal
