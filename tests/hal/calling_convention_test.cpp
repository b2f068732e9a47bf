// In 32-bit Windows a member function removes its arguments from the stack itself; a plain function leaves that to its
// caller. A compiler that merges two such functions with equal bodies (gcc 12: -fipa-icf) sends plain calls to the
// wrong convention: toolchains/windows.cmake forbids it. On other machines all functions have one convention.
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>

namespace sinew::hal::calling_convention_test {
namespace {

struct Part {
  virtual ~Part() = default;
  virtual void declare(int& about) = 0;
};

// The twins: each gets two addresses that are not null, and does nothing.
struct Silent final : Part {
  void declare(int&) override {}
};
struct Other {
  static void call(int&, int&) {}
};

using Plain = void (*)(int&, int&);

/// Calls it with two arguments. How many bytes of them it has left on the stack.
std::intptr_t left_by(Plain function) {
#if defined(__i386__)
  std::intptr_t left = 0;
  asm volatile(
      "movl %%esp, %%esi\n\t"
      "pushl $0\n\t"
      "pushl $0\n\t"
      "call *%1\n\t"
      "movl %%esi, %0\n\t"
      "subl %%esp, %0\n\t"
      "movl %%esi, %%esp"
      : "=&b"(left)
      : "D"(function)
      : "eax", "ecx", "edx", "esi", "memory", "cc");
  return left;
#else
  int a = 0, b = 0;
  function(a, b);
  return 2 * sizeof(void*);
#endif
}

TEST(CallingConvention, APlainFunctionLeavesItsArgumentsAlsoWhereAMemberFunctionDoesTheSame) {
  const std::unique_ptr<Part> part = std::make_unique<Silent>();
  int about = 0;
  part->declare(about);
  const Plain volatile function = &Other::call;  // nobody may know at once which it is
  EXPECT_EQ(left_by(function), std::intptr_t{2 * sizeof(void*)});
}

}  // namespace
}  // namespace sinew::hal::calling_convention_test
