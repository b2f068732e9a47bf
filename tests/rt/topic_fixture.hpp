#pragma once
// One writer with two outputs and any readers, in memory of its own.
#include <memory>
#include <utility>
#include <vector>

#include "rt/commit.hpp"
#include "rt/latch.hpp"

namespace sinew::rt {

struct Pair {
  msg::Time stamp;
  std::uint32_t number = 0, reserved = 0;
  std::array<double, 4> value{};
};

}  // namespace sinew::rt

namespace sinew::msg {

template <>
struct Description<rt::Pair> {
  static constexpr std::string_view name = "Pair", doc = "A message of the tests.";
  static constexpr auto fields = describe(field<&rt::Pair::stamp>("ns"), field<&rt::Pair::number>("1"),
                                          field<&rt::Pair::reserved>("1"), field<&rt::Pair::value>("1"));
};

}  // namespace sinew::msg

namespace sinew::rt {

inline constexpr std::uint32_t kNearWrap = 0xFFFFFF00;

inline ConnectionPlan latest(bool same_thread = false) { return {ConnectionPlan::Kind::latest, 1, same_thread}; }
inline ConnectionPlan drop_oldest(std::uint32_t depth, bool same_thread = false) {
  return {ConnectionPlan::Kind::drop_oldest, depth, same_thread};
}
inline ConnectionPlan drop_newest(std::uint32_t depth) { return {ConnectionPlan::Kind::drop_newest, depth, false}; }

/// Two outputs "w.a" and "w.b" of one writer; connect() before start().
struct TwoOutputs {
  explicit TwoOutputs(std::uint32_t burst = 1, std::uint32_t first_sequence = kNearWrap)
      : plan(SegmentOptions{first_sequence, 16}) {
    const WriterId w = plan.add_writer("w");
    a_topic = plan.add_topic(w, {.name = "w.a", .type = &msg::type_info<Pair>(), .burst = burst});
    b_topic = plan.add_topic(w, {.name = "w.b", .type = &msg::type_info<Pair>(), .burst = burst});
  }
  void start() {
    segment = std::make_unique<Segment>(plan);
    commit = std::make_unique<Commit>(*segment, 0);
    commit->bind(a, 0);
    commit->bind(b, 1);
  }
  /// Publishes `number` on both outputs.
  void publish(std::uint32_t number) {
    a.loan().number = number;
    b.loan().number = number;
    commit->commit({Time{number}});
  }
  void publish_a(std::uint32_t number) {
    a.loan().number = number;
    commit->commit({Time{number}});
  }

  SegmentPlan plan;
  TopicId a_topic, b_topic;
  std::unique_ptr<Segment> segment;
  std::unique_ptr<Commit> commit;
  Out<Pair> a, b;
};

/// A latch that releases in time.
struct Latched {
  explicit Latched(Latch& l) : latch(l) { latch.latch(); }
  ~Latched() { latch.release(); }
  Latch& latch;
};

template <class Queue>
std::vector<std::uint32_t> numbers(const Queue& queue) {
  std::vector<std::uint32_t> n;
  for (const Pair& p : queue) n.push_back(p.number);
  return n;
}

}  // namespace sinew::rt
