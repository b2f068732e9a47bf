#include "hal/linux/fd_watch.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>

#include "hal/platform.hpp"
#include "hal/wake_counter.hpp"

namespace sinew::hal::fd_watch_test {
namespace {

using namespace std::chrono_literals;

const ThreadOptions kThread{"watch", 0, {}, std::size_t{64} * 1024, 0};

class Pipe {
 public:
  Pipe() { EXPECT_EQ(pipe(ends_.data()), 0); }
  ~Pipe() { close(ends_[0]), close(ends_[1]); }
  int reader() const { return ends_[0]; }
  void put() { EXPECT_EQ(write(ends_[1], "x", 1), 1); }
  void take() {
    char c = 0;
    EXPECT_EQ(read(ends_[0], &c, 1), 1);
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

TEST(FdWatch, RingsTheLineOfTheDescriptorThatHasSomething) {
  Pipe first, second;
  FdLine first_line, second_line;
  WakeCounter first_wakes, second_wakes;
  auto watch = FdWatch::start(system_os(), kThread);
  ASSERT_TRUE(watch);
  ASSERT_TRUE((*watch)->add(first.reader(), first_line));
  ASSERT_TRUE((*watch)->add(second.reader(), second_line));
  first_line.change_wake(&first_wakes), second_line.change_wake(&second_wakes);
  EXPECT_TRUE(first_line.ready()) << "nobody has looked yet";
  first_line.begin_read(), second_line.begin_read();
  second.put();
  ASSERT_TRUE(second_wakes.wait_for(1));
  EXPECT_TRUE(second_line.ready());
  EXPECT_FALSE(first_line.ready());
  EXPECT_EQ(first_wakes.count(), 0u);
  second_line.begin_read(), second.take();
  EXPECT_FALSE(second_line.ready());
  second.put();
  EXPECT_TRUE(second_wakes.wait_for(2)) << "what comes after a read rings again";
  (*watch)->remove(first.reader()), (*watch)->remove(second.reader());
}

TEST(FdWatch, LineThatWasTakenAwayIsNotTouched) {
  Pipe pipe, other;
  WakeCounter wakes;
  auto watch = FdWatch::start(system_os(), kThread);
  ASSERT_TRUE(watch);
  {
    FdLine line;
    ASSERT_TRUE((*watch)->add(pipe.reader(), line));
    (*watch)->remove(pipe.reader());
  }
  pipe.put();
  FdLine line;
  line.change_wake(&wakes);
  ASSERT_TRUE((*watch)->add(other.reader(), line));
  other.put();
  EXPECT_TRUE(wakes.wait_for(1));
  (*watch)->remove(other.reader());
}

TEST(FdWatch, DescriptorThatCannotBeWatchedIsAnError) {
  auto watch = FdWatch::start(system_os(), kThread);
  ASSERT_TRUE(watch);
  FdLine line;
  const Status added = (*watch)->add(-1, line);
  ASSERT_FALSE(added);
  EXPECT_EQ(added.error().code, Errc::io);
}

}  // namespace
}  // namespace sinew::hal::fd_watch_test
