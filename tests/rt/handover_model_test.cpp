// The memory model against the litmus tests whose answers are known, so that a proof by it means something.
#include <gtest/gtest.h>

#include <set>

#include "memory_model.hpp"

namespace sinew::model::handover_model_test {
namespace {

constexpr auto kRelaxed = std::memory_order_relaxed, kAcquire = std::memory_order_acquire,
               kRelease = std::memory_order_release;

/// Two threads with one result each; collects all pairs of results.
struct Litmus {
  static inline std::set<std::pair<std::uint32_t, std::uint32_t>> seen;
  static constexpr int threads = 2;
  Word x, y;
  std::uint32_t r[2] = {9, 9};
  void finish() { seen.insert({r[0], r[1]}); }
};

template <class P>
std::set<std::pair<std::uint32_t, std::uint32_t>> results() {
  Litmus::seen.clear();
  EXPECT_EQ(Explorer::explore<P>().failure, "");
  return Litmus::seen;
}

using Pairs = std::set<std::pair<std::uint32_t, std::uint32_t>>;

template <bool ordered>
struct MessagePassing : Litmus {
  void run(int thread) {
    if (thread == 0) {
      x.store(1, kRelaxed);
      y.store(1, ordered ? kRelease : kRelaxed);
    } else {
      r[0] = y.load(ordered ? kAcquire : kRelaxed);
      r[1] = x.load(kRelaxed);
    }
  }
};

TEST(HandOverModel, MessagePassingNeedsReleaseAndAcquire) {
  EXPECT_EQ(results<MessagePassing<false>>(), (Pairs{{0, 0}, {0, 1}, {1, 0}, {1, 1}}));
  EXPECT_EQ(results<MessagePassing<true>>(), (Pairs{{0, 0}, {0, 1}, {1, 1}}));
}

struct StoreBuffering : Litmus {
  void run(int thread) {
    (thread == 0 ? x : y).store(1, kRelease);
    r[thread] = (thread == 0 ? y : x).load(kAcquire);
  }
};

TEST(HandOverModel, StoreBuffersMayHideBothStores) {
  EXPECT_EQ(results<StoreBuffering>(), (Pairs{{0, 0}, {0, 1}, {1, 0}, {1, 1}}));
}

struct Coherence : Litmus {
  void run(int thread) {
    if (thread == 0) {
      x.store(1, kRelaxed);
      x.store(2, kRelaxed);
    } else {
      r[0] = x.load(kRelaxed);
      r[1] = x.load(kRelaxed);
    }
  }
};

TEST(HandOverModel, OneWordNeverGoesBack) {
  EXPECT_EQ(results<Coherence>(), (Pairs{{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}}));
}

struct Counter : Litmus {
  void run(int thread) { r[thread] = x.fetch_add(1, kRelaxed); }
};

TEST(HandOverModel, ReadModifyWritesNeverReadTheSame) { EXPECT_EQ(results<Counter>(), (Pairs{{0, 1}, {1, 0}})); }

struct Exchange : Litmus {
  void run(int thread) {
    std::uint32_t expected = 0;
    r[thread] = x.compare_exchange_strong(expected, 1, kAcquire, kRelaxed) ? 1 : 0;
  }
};

TEST(HandOverModel, OneCompareExchangeWins) { EXPECT_EQ(results<Exchange>(), (Pairs{{0, 1}, {1, 0}})); }

/// A third thread's relaxed increment stands between the release and the acquire.
template <bool released>
struct ReleaseSequence {
  static constexpr int threads = 3;
  Word x;
  Plain<std::uint32_t> data;
  void run(int thread) {
    if (thread == 0) {
      data = 1;
      x.fetch_add(1, released ? kRelease : kRelaxed);
    } else if (thread == 1) {
      x.fetch_add(2, kRelaxed);
    } else if (x.load(kAcquire) & 1) {
      require(data == 1, "old data");
    }
  }
  void finish() {}
};

TEST(HandOverModel, IncrementsCarryAReleaseOn) {
  EXPECT_EQ(Explorer::explore<ReleaseSequence<true>>().failure, "");
  EXPECT_EQ(Explorer::explore<ReleaseSequence<false>>().failure, "data race");
}

/// A release does not cover what the thread does after it.
struct LateWrite {
  static constexpr int threads = 2;
  Word x;
  Plain<std::uint32_t> data;
  void run(int thread) {
    if (thread == 0) {
      x.store(1, kRelease);
      data = 1;
    } else if (x.load(kAcquire) == 1) {
      require(data < 2, "impossible");
    }
  }
  void finish() {}
};

TEST(HandOverModel, WriteAfterTheReleaseIsARace) { EXPECT_EQ(Explorer::explore<LateWrite>().failure, "data race"); }

}  // namespace
}  // namespace sinew::model::handover_model_test
