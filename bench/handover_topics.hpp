#pragma once
// The messages that bench/handover*.cpp pass around, and one topic with one reader.
#include <array>
#include <cstring>

#include "msg/image.hpp"
#include "rt/commit.hpp"
#include "rt/latch.hpp"

namespace sinew::bench {

inline constexpr std::uint32_t kFrameBytes = 921600;  // 640 x 480, three bytes a pixel

/// 64 bytes. Six of its numbers are looked at for NaN at the commit, as in a real message.
struct Small {
  msg::Time stamp;
  std::array<double, 6> value{};
  std::int64_t last = 0;
};

}  // namespace sinew::bench

template <>
struct sinew::msg::Description<sinew::bench::Small> {
  using Small = sinew::bench::Small;
  static constexpr std::string_view name = "Small", doc = "64 bytes.";
  static constexpr auto fields =
      describe(field<&Small::stamp>("ns"), field<&Small::value>("1"), field<&Small::last>("1"));
};

namespace sinew::bench {

/// The writer marks both ends of the payload, the reader looks at both: what is measured is the hand-over, not filling.
inline void mark(Small& m, std::int64_t n) { m.stamp.ns = n, m.last = n; }
inline bool marked(const Small& m, std::int64_t n) { return m.stamp.ns == n && m.last == n; }
inline void mark(msg::Image& m, std::int64_t n) {
  m.stamp.ns = n;
  m.width = 640, m.height = 480, m.stride = 1920, m.format = msg::PixelFormat::rgb8;
  std::memcpy(m.pixels() + kFrameBytes - sizeof n, &n, sizeof n);
}
inline bool marked(const msg::Image& m, std::int64_t n) {
  return m.stamp.ns == n && std::memcmp(m.pixels() + kFrameBytes - sizeof n, &n, sizeof n) == 0;
}

template <class M>
struct Topic {
  explicit Topic(bool same_thread)
      : plan([&] {
          rt::SegmentPlan p;
          p.add_topic(
              p.add_writer("bench"),
              {.name = "bench.out", .type = &msg::type_info<M>(), .bulk_bytes = msg::HasBulk<M> ? kFrameBytes : 0});
          p.connect(0, {rt::ConnectionPlan::Kind::latest, 1, same_thread});
          return p;
        }()),
        segment(plan),
        commit(segment, 0),
        latch(segment) {
    commit.bind(out, 0);
    latch.bind(in, 0);
  }
  void write(std::int64_t n, msg::Time now) {
    mark(out.loan(), n);
    info.now = now;
    commit.commit(info);
  }
  bool read(std::int64_t n) {
    latch.latch();
    const bool good = in.get() && marked(*in.get(), n);
    latch.release();
    return good;
  }

  rt::SegmentPlan plan;
  rt::Segment segment;
  rt::Commit commit;
  rt::CommitInfo info;
  rt::Latch latch;
  rt::Out<M> out;
  rt::In<M> in;
};

}  // namespace sinew::bench
