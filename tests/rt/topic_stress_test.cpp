// Real threads: one writer, three readers, all checks that a torn or inconsistent message would fail. For TSan, too.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "msg/image.hpp"
#include "topic_fixture.hpp"

namespace sinew::rt::topic_stress_test {
namespace {

#ifdef SINEW_SANITIZED
constexpr std::uint32_t kCommits = 20'000;
#else
constexpr std::uint32_t kCommits = 500'000;
#endif
constexpr std::uint32_t kPixels = 512;

/// A pair and an image, committed together; the image is filled with bytes that follow from the number.
struct Camera {
  Camera() : plan(SegmentOptions{kNearWrap, 2}) {
    const WriterId w = plan.add_writer("w");
    pair_topic = plan.add_topic(w, {.name = "w.pair", .type = &msg::type_info<Pair>()});
    image_topic = plan.add_topic(w, {.name = "w.image", .type = &msg::type_info<msg::Image>(), .bulk_bytes = kPixels});
  }
  static std::uint8_t pixel(std::uint32_t number, std::uint32_t i) {
    return static_cast<std::uint8_t>(number * 31 + i);
  }

  void write() {
    Commit commit(*segment, 0);
    Out<Pair> pair;
    Out<msg::Image> image;
    commit.bind(pair, 0);
    commit.bind(image, 1);
    for (std::uint32_t n = 1; n <= kCommits; ++n) {
      Pair& p = pair.loan();
      p.number = n;
      p.value.fill(n);
      msg::Image& i = image.loan();
      i.frame_number = n;
      if (!i.format_as(msg::PixelFormat::mono8, kPixels, 1)) return;
      for (std::uint32_t k = 0; k < kPixels; ++k) i.pixels()[k] = pixel(n, k);
      commit.commit({Time{n}});
      if (n % 64 == 0) std::this_thread::yield();
    }
  }
  static bool whole(const Pair& p) {
    for (const double v : p.value)
      if (v != p.number) return false;
    return true;
  }
  static bool whole(const msg::Image& i) {
    if (i.width != kPixels || i.bulk_used() != kPixels) return false;
    for (std::uint32_t k = 0; k < kPixels; ++k)
      if (i.pixels()[k] != pixel(i.frame_number, k)) return false;
    return true;
  }

  SegmentPlan plan;
  TopicId pair_topic, image_topic;
  std::unique_ptr<Segment> segment;
};

struct Findings {
  std::uint32_t torn = 0, inconsistent = 0, backwards = 0, out_of_order = 0, steps = 0;
  std::uint64_t received = 0, dropped = 0;
  std::uint32_t last = 0;
};

/// Latches both outputs as state until the last commit has come.
Findings read_latest(Segment& segment, ConnectionId pair_id, ConnectionId image_id) {
  Findings f;
  In<Pair> pair;
  In<msg::Image> image;
  Latch latch(segment);
  latch.bind(pair, pair_id);
  latch.bind(image, image_id);
  while (f.last != kCommits) {
    Latched step(latch);
    ++f.steps;
    if (!pair.get() != !image.get()) ++f.inconsistent;
    if (!pair.get() || !image.get()) {
      std::this_thread::yield();
      continue;
    }
    f.torn += !Camera::whole(*pair.get()) + !Camera::whole(*image.get());
    f.inconsistent += pair.get()->number != image.get()->frame_number;
    f.inconsistent += pair.header(0)->commit != image.header(0)->commit;
    f.inconsistent += pair.header(0)->sequence != kNearWrap - 1 + pair.get()->number;
    if (!pair.updated()) std::this_thread::yield();
    f.backwards += static_cast<std::int32_t>(pair.get()->number - f.last) < 0;
    f.last = pair.get()->number;
  }
  return f;
}

Findings read_queue(Segment& segment, ConnectionId id, ConnectionId state_id) {
  Findings f;
  InQueue<Pair> queue;
  In<msg::Image> image;
  Latch latch(segment);
  latch.bind(queue, id);
  latch.bind(image, state_id);
  std::uint32_t newest = 0;
  while (newest != kCommits) {
    Latched step(latch);
    ++f.steps;
    for (const Pair& p : queue) {
      f.torn += !Camera::whole(p);
      f.out_of_order += p.number <= f.last;
      f.last = p.number;
      ++f.received;
    }
    if (image.get()) newest = image.get()->frame_number;
    f.inconsistent += f.last > newest;
    if (queue.empty()) std::this_thread::yield();
  }
  f.dropped = queue.dropped_total();
  return f;
}

TEST(TopicStress, ThreeReadersNeverSeeATornOrInconsistentSet) {
  Camera camera;
  const auto p1 = camera.plan.connect(camera.pair_topic, latest()),
             i1 = camera.plan.connect(camera.image_topic, latest());
  const auto q2 = camera.plan.connect(camera.pair_topic, drop_oldest(8)),
             i2 = camera.plan.connect(camera.image_topic, latest());
  const auto q3 = camera.plan.connect(camera.pair_topic, drop_newest(8)),
             i3 = camera.plan.connect(camera.image_topic, latest());
  camera.segment = std::make_unique<Segment>(camera.plan);
  Findings f[3];
  std::thread first([&] { f[0] = read_latest(*camera.segment, p1, i1); });
  std::thread second([&] { f[1] = read_queue(*camera.segment, q2, i2); });
  std::thread third([&] { f[2] = read_queue(*camera.segment, q3, i3); });
  camera.write();
  first.join();
  second.join();
  third.join();
  for (const Findings& g : f) {
    EXPECT_EQ(g.torn, 0U);
    EXPECT_EQ(g.inconsistent, 0U);
    EXPECT_EQ(g.backwards, 0U);
    EXPECT_EQ(g.out_of_order, 0U);
    EXPECT_GT(g.steps, 0U);
  }
  EXPECT_EQ(f[1].received + f[1].dropped, kCommits);
  EXPECT_EQ(f[2].received + f[2].dropped, kCommits);
  std::printf("[ stress   ] steps %u %u %u, received %llu %llu of %u\n", f[0].steps, f[1].steps, f[2].steps,
              static_cast<unsigned long long>(f[1].received), static_cast<unsigned long long>(f[2].received), kCommits);
}

}  // namespace
}  // namespace sinew::rt::topic_stress_test
