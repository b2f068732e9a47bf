// The declarations of hal/wince_stub are those of the system's own headers. The size of a function's arguments needs no
// test: in 32 bits it is part of the name, and another one does not link.
#include "hal/wince_stub/coredll.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>

#include "win32_facts.hpp"

namespace sinew::hal::wince_coredll_test {
namespace {

using namespace ce;

std::int64_t of_system(const std::string& name) {
  const auto facts = system_facts();
  const auto found = std::find_if(facts.begin(), facts.end(), [&](const Win32Fact& f) { return f.name == name; });
  EXPECT_NE(found, facts.end()) << name;
  return found == facts.end() ? -1 : found->value;
}

TEST(Coredll, ConstantsAreTheSystems) {
  const std::vector<Win32Fact> ours = {
      {"INFINITE", kInfinite},
      {"CREATE_SUSPENDED", kCreateSuspended},
      {"STACK_SIZE_PARAM_IS_A_RESERVATION", kStackSizeParamIsAReservation},
      {"TLS_OUT_OF_INDEXES", kTlsOutOfIndexes},
      {"THREAD_PRIORITY_IDLE", idle},
      {"THREAD_PRIORITY_LOWEST", lowest},
      {"THREAD_PRIORITY_BELOW_NORMAL", below_normal},
      {"THREAD_PRIORITY_NORMAL", normal},
      {"THREAD_PRIORITY_ABOVE_NORMAL", above_normal},
      {"THREAD_PRIORITY_HIGHEST", highest},
      {"THREAD_PRIORITY_TIME_CRITICAL", time_critical},
      {"PAGE_READWRITE", kPageReadWrite},
      {"FILE_MAP_WRITE", kFileMapWrite},
      {"FILE_MAP_READ", kFileMapRead},
      {"AF_UNSPEC", kUnspecified},
      {"SOCK_STREAM", kStreamSocket},
      {"IPPROTO_TCP", kProtocolTcp},
      {"TCP_NODELAY", kTcpNoDelay},
      {"SOL_SOCKET", kSocketLevel},
      {"SO_KEEPALIVE", kKeepAlive},
      {"SO_EXCLUSIVEADDRUSE", kExclusiveAddress},
      {"SO_ERROR", kSocketErrorOption},
      {"SD_BOTH", kShutdownBoth},
      {"FIONBIO", kFionbio},
      {"AI_PASSIVE", kPassive},
      {"FD_SETSIZE", kSetSize},
      {"NI_NUMERICHOST", kNumericHost},
      {"NI_NUMERICSERV", kNumericService},
      {"WSAEWOULDBLOCK", kWouldBlock},
      {"WSAEACCES", kAccess},
      {"WSAEADDRINUSE", kAddressInUse},
      {"WSAECONNABORTED", kConnectionAborted},
      {"WSAECONNRESET", kConnectionReset},
      {"WSAENOBUFS", kNoBuffers},
      {"WSAENOTCONN", kNotConnected},
      {"WSAESHUTDOWN", kShutDown},
      {"WSAETIMEDOUT", kTimedOut},
      {"WSAECONNREFUSED", kConnectionRefused},
      {"WSAEHOSTUNREACH", kHostUnreachable},
      {"WSAHOST_NOT_FOUND", kHostNotFound},
  };
  for (const Win32Fact& fact : ours) EXPECT_EQ(fact.value, of_system(fact.name)) << fact.name;
}

TEST(Coredll, StructuresHaveTheSystemsSizesAndPlaces) {
  const std::vector<Win32Fact> ours = {
      {"HANDLE", sizeof(Handle)},
      {"BOOL", sizeof(Bool)},
      {"DWORD", sizeof(Dword)},
      {"WORD", sizeof(Word)},
      {"FILETIME", sizeof(FileTime)},
      {"FILETIME::dwHighDateTime", offsetof(FileTime, high)},
      {"LARGE_INTEGER", sizeof(std::int64_t)},
      {"SOCKET", sizeof(Socket)},
      {"SOCKADDR_STORAGE", sizeof(SocketAddress)},
      {"SOCKADDR_STORAGE::ss_family", offsetof(SocketAddress, family)},
      {"ADDRINFO", sizeof(AddressInfo)},
      {"ADDRINFO::ai_addrlen", offsetof(AddressInfo, address_bytes)},
      {"ADDRINFO::ai_canonname", offsetof(AddressInfo, canonical_name)},
      {"ADDRINFO::ai_addr", offsetof(AddressInfo, address)},
      {"ADDRINFO::ai_next", offsetof(AddressInfo, next)},
      {"fd_set", sizeof(SocketSet)},
      {"fd_set::fd_array", offsetof(SocketSet, sockets)},
      {"timeval", sizeof(TimeVal)},
      {"timeval::tv_usec", offsetof(TimeVal, us)},
      {"WSABUF", sizeof(Buffer)},
      {"WSABUF::buf", offsetof(Buffer, at)},
  };
  for (const Win32Fact& fact : ours) EXPECT_EQ(fact.value, of_system(fact.name)) << fact.name;
}

TEST(Coredll, WhatIsOpaqueIsLargeEnough) {
  EXPECT_GE(std::int64_t{sizeof(CriticalSection)}, of_system("CRITICAL_SECTION"));
  EXPECT_GE(std::int64_t{sizeof(WinsockData)}, of_system("WSADATA"));
}

}  // namespace
}  // namespace sinew::hal::wince_coredll_test
