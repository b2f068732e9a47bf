#pragma once
// The system calls that this port may use: only calls that Windows CE documents, by their names there. This room
// includes none of the system's own headers, because they would let in calls that CE lacks (condition variables,
// WaitOnAddress, waitable timers, VirtualLock, thread pools, SRW locks).
// On CE all of these are in coredll.dll and ws2.dll, on desktop Windows in kernel32.dll and ws2_32.dll.
// Source:  Windows Embedded Compact 7 reference: "Core OS Services" and "Winsock". Calls that desktop Windows lacks, or
//          has in another form (256 priorities: CeSetThreadPriority; LockPages), are left out.
#include <cstddef>
#include <cstdint>

namespace sinew::hal::ce {

#define SINEW_CE_CALL __declspec(dllimport)
#define SINEW_CE_STD __stdcall

using Handle = void*;  // HANDLE
using Bool = int;      // BOOL
using Dword = std::uint32_t;
using Word = std::uint16_t;
using Char = wchar_t;  // 16 bits; for names of events and mappings, which we do not use
static_assert(sizeof(Char) == 2);

inline const Handle kInvalidHandle = reinterpret_cast<Handle>(std::intptr_t{-1});
inline constexpr Dword kInfinite = 0xFFFFFFFF;

// ---- threads

inline constexpr Dword kCreateSuspended = 0x00000004;               // CREATE_SUSPENDED
inline constexpr Dword kStackSizeParamIsAReservation = 0x00010000;  // STACK_SIZE_PARAM_IS_A_RESERVATION
inline constexpr Dword kTlsOutOfIndexes = 0xFFFFFFFF;               // TLS_OUT_OF_INDEXES
#ifdef UNDER_CE
enum Priority : int { time_critical = 0, highest, above_normal, normal, below_normal, lowest, above_idle, idle };
#else
enum Priority : int { idle = -15, lowest = -2, below_normal, normal, above_normal, highest, time_critical = 15 };
#endif

struct FileTime {  // FILETIME: 100 ns
  Dword low, high;
};

extern "C" {
using ThreadStart = Dword(SINEW_CE_STD*)(void*);
SINEW_CE_CALL Handle SINEW_CE_STD CreateThread(void* security, std::size_t stack, ThreadStart start, void* argument,
                                               Dword flags, Dword* id);
SINEW_CE_CALL Dword SINEW_CE_STD ResumeThread(Handle thread);
SINEW_CE_CALL Bool SINEW_CE_STD SetThreadPriority(Handle thread, int priority);
SINEW_CE_CALL Handle SINEW_CE_STD GetCurrentThread();  // a constant on CE, where it is an inline function
SINEW_CE_CALL Bool SINEW_CE_STD GetThreadTimes(Handle thread, FileTime* created, FileTime* ended, FileTime* kernel,
                                               FileTime* user);
SINEW_CE_CALL Dword SINEW_CE_STD TlsAlloc();
SINEW_CE_CALL void* SINEW_CE_STD TlsGetValue(Dword index);
SINEW_CE_CALL Bool SINEW_CE_STD TlsSetValue(Dword index, void* value);
SINEW_CE_CALL void SINEW_CE_STD Sleep(Dword ms);
SINEW_CE_CALL Dword SINEW_CE_STD GetLastError();
SINEW_CE_CALL Bool SINEW_CE_STD CloseHandle(Handle handle);

// ---- waiting

SINEW_CE_CALL Dword SINEW_CE_STD WaitForSingleObject(Handle handle, Dword ms);
SINEW_CE_CALL Handle SINEW_CE_STD CreateEventW(void* security, Bool manual_reset, Bool set, const Char* name);
SINEW_CE_CALL Bool SINEW_CE_STD SetEvent(Handle event);  // SetEvent and ResetEvent are inline on CE (EventModify)
SINEW_CE_CALL Bool SINEW_CE_STD ResetEvent(Handle event);

/// CRITICAL_SECTION, opaque: as large as the largest of them (40 bytes where pointers have 8).
struct CriticalSection {
  void* opaque[6];
};
SINEW_CE_CALL void SINEW_CE_STD InitializeCriticalSection(CriticalSection* section);
SINEW_CE_CALL void SINEW_CE_STD EnterCriticalSection(CriticalSection* section);
SINEW_CE_CALL void SINEW_CE_STD LeaveCriticalSection(CriticalSection* section);
SINEW_CE_CALL void SINEW_CE_STD DeleteCriticalSection(CriticalSection* section);

// ---- time

SINEW_CE_CALL Bool SINEW_CE_STD QueryPerformanceCounter(std::int64_t* count);
SINEW_CE_CALL Bool SINEW_CE_STD QueryPerformanceFrequency(std::int64_t* per_second);

// ---- memory

inline constexpr Dword kPageReadWrite = 0x04;                          // PAGE_READWRITE
inline constexpr Dword kFileMapWrite = 0x0002, kFileMapRead = 0x0004;  // FILE_MAP_WRITE, FILE_MAP_READ

SINEW_CE_CALL Handle SINEW_CE_STD CreateFileMappingW(Handle file, void* security, Dword protection, Dword size_high,
                                                     Dword size_low, const Char* name);
SINEW_CE_CALL void* SINEW_CE_STD MapViewOfFile(Handle mapping, Dword access, Dword offset_high, Dword offset_low,
                                               std::size_t bytes);
SINEW_CE_CALL Bool SINEW_CE_STD UnmapViewOfFile(const void* address);
}

// ---- Winsock

using Socket = std::uintptr_t;  // SOCKET
inline constexpr Socket kInvalidSocket = ~Socket{0};
inline constexpr int kSocketError = -1;
inline constexpr int kUnspecified = 0, kStreamSocket = 1, kProtocolTcp = 6;  // AF_UNSPEC, SOCK_STREAM, IPPROTO_TCP
inline constexpr int kTcpNoDelay = 0x0001, kSocketLevel = 0xFFFF,
                     kKeepAlive = 0x0008;          // TCP_NODELAY, SOL_SOCKET, SO_KEEPALIVE
inline constexpr int kExclusiveAddress = ~0x0004;  // SO_EXCLUSIVEADDRUSE
inline constexpr int kSocketErrorOption = 0x1007;  // SO_ERROR
inline constexpr int kShutdownBoth = 2;            // SD_BOTH
inline constexpr std::int32_t kFionbio = static_cast<std::int32_t>(0x8004667E);  // FIONBIO
inline constexpr int kPassive = 0x1;                                             // AI_PASSIVE
// WSAGetLastError()
inline constexpr int kWouldBlock = 10035, kAccess = 10013, kAddressInUse = 10048, kConnectionAborted = 10053,
                     kConnectionReset = 10054, kNoBuffers = 10055, kNotConnected = 10057, kShutDown = 10058,
                     kTimedOut = 10060, kConnectionRefused = 10061, kHostUnreachable = 10065, kHostNotFound = 11001;

struct SocketAddress {  // SOCKADDR_STORAGE
  std::uint16_t family;
  std::uint8_t rest[126];
};
struct AddressInfo {  // ADDRINFO
  int flags, family, type, protocol;
  std::size_t address_bytes;
  char* canonical_name;
  SocketAddress* address;
  AddressInfo* next;
};
inline constexpr std::uint32_t kSetSize = 64;  // FD_SETSIZE
struct SocketSet {                             // fd_set
  std::uint32_t count;
  Socket sockets[kSetSize];
};
struct TimeVal {  // timeval: `long` has 32 bits here
  std::int32_t s, us;
};
struct Buffer {  // WSABUF
  std::uint32_t bytes;
  char* at;
};
struct WinsockData {  // WSADATA, opaque: as large as the largest of them
  std::uint64_t opaque[52];
};

extern "C" {
SINEW_CE_CALL int SINEW_CE_STD WSAStartup(Word version, WinsockData* data);
SINEW_CE_CALL int SINEW_CE_STD WSAGetLastError();
SINEW_CE_CALL int SINEW_CE_STD getaddrinfo(const char* host, const char* port, const AddressInfo* hints,
                                           AddressInfo** found);
SINEW_CE_CALL void SINEW_CE_STD freeaddrinfo(AddressInfo* found);
SINEW_CE_CALL int SINEW_CE_STD getnameinfo(const SocketAddress* address, int address_bytes, char* host, Dword host_room,
                                           char* port, Dword port_room, int flags);
SINEW_CE_CALL Socket SINEW_CE_STD socket(int family, int type, int protocol);
SINEW_CE_CALL int SINEW_CE_STD connect(Socket s, const SocketAddress* address, int bytes);
SINEW_CE_CALL int SINEW_CE_STD bind(Socket s, const SocketAddress* address, int bytes);
SINEW_CE_CALL int SINEW_CE_STD listen(Socket s, int backlog);
SINEW_CE_CALL Socket SINEW_CE_STD accept(Socket s, SocketAddress* address, int* bytes);
SINEW_CE_CALL int SINEW_CE_STD getsockname(Socket s, SocketAddress* address, int* bytes);
SINEW_CE_CALL int SINEW_CE_STD setsockopt(Socket s, int level, int name, const char* value, int bytes);
SINEW_CE_CALL int SINEW_CE_STD getsockopt(Socket s, int level, int name, char* value, int* bytes);
SINEW_CE_CALL int SINEW_CE_STD ioctlsocket(Socket s, std::int32_t command, std::uint32_t* argument);
SINEW_CE_CALL int SINEW_CE_STD recv(Socket s, char* into, int bytes, int flags);
SINEW_CE_CALL int SINEW_CE_STD send(Socket s, const char* from, int bytes, int flags);
SINEW_CE_CALL int SINEW_CE_STD WSASend(Socket s, Buffer* buffers, Dword count, Dword* sent, Dword flags,
                                       void* overlapped, void* completion);
SINEW_CE_CALL int SINEW_CE_STD select(int ignored, SocketSet* read, SocketSet* write, SocketSet* failed,
                                      const TimeVal* patience);
SINEW_CE_CALL int SINEW_CE_STD shutdown(Socket s, int how);
SINEW_CE_CALL int SINEW_CE_STD closesocket(Socket s);
}
inline constexpr int kNumericHost = 0x2, kNumericService = 0x8;  // NI_NUMERICHOST, NI_NUMERICSERV

#undef SINEW_CE_CALL
#undef SINEW_CE_STD

}  // namespace sinew::hal::ce
