#include "apps/search/generate.hpp"

#include "math/convert.hpp"
#include "math/random.hpp"

namespace sinew::search {
namespace {

constexpr std::uint32_t kCaseStream = 0x63617365, kRunStream = 0x72756e73;
constexpr double kFirstOnset_s = 0.3, kLastOnset_s = 20.0;  // a flight takes 15 to 20 s

/// What a device can do wrong: amounts in steps of `grain`, lengths in milliseconds.
struct Kind {
  const char *device, *kind;
  double least, most, grain;  // of the amount; 0: it has none
  int shortest_ms, longest_ms;
};

constexpr Kind kKinds[] = {
    // Dropped and late samples, as a loaded bus makes them. The robot must not notice.
    {"imu", "off", 0, 0, 0, 1, 5},
    {"imu", "delayed", 1, 4, 0.5, 1, 50},
    {"imu", "slow", 2, 4, 1, 5, 300},
    {"imu", "intermittent", 0.5, 1, 0.1, 5, 100},
    {"imu", "duplicated", 0, 0, 0, 1, 300},
    {"range", "off", 0, 0, 0, 10, 200},
    {"range", "delayed", 5, 60, 5, 10, 1000},
    {"range", "slow", 2, 8, 1, 100, 3000},
    {"range", "garbage", 0, 0, 0, 10, 100},
    {"range", "duplicated", 0, 0, 0, 10, 1000},
    {"baro", "off", 0, 0, 0, 20, 3000},
    {"baro", "delayed", 5, 100, 5, 20, 1000},
    {"baro", "garbage", 0, 0, 0, 20, 500},
    {"camera", "off", 0, 0, 0, 34, 350},
    {"camera", "delayed", 5, 60, 5, 34, 2000},
    {"camera", "slow", 2, 4, 1, 200, 4000},
    {"camera", "duplicated", 0, 0, 0, 34, 1000},
    {"camera", "garbage", 0, 0, 0, 34, 300},
    {"motors", "delayed", 0.5, 3, 0.5, 1, 200},
    {"motors", "off", 0, 0, 0, 1, 5},
    // Devices that fail for a while. A failsafe has to bring it down.
    {"imu", "off", 0, 0, 0, 10, 300},
    {"imu", "stuck", 0, 0, 0, 5, 100},
    {"imu", "garbage", 0, 0, 0, 1, 50},
    {"range", "off", 0, 0, 0, 500, 6000},
    {"range", "stuck", 0, 0, 0, 100, 1000},
    {"range", "intermittent", 20, 200, 10, 500, 5000},
    {"baro", "intermittent", 50, 500, 50, 500, 5000},
    {"camera", "off", 0, 0, 0, 1000, 8000},
    {"camera", "intermittent", 50, 500, 50, 500, 5000},
    {"camera", "stuck", 0, 0, 0, 100, 2000},
    {"motors", "off", 0, 0, 0, 10, 40},
};
constexpr std::uint32_t kKindCount = sizeof kKinds / sizeof kKinds[0];

/// In whole steps of `grain`, so that the text reads well.
double draw(math::Random& random, double least, double most, double grain) {
  const double steps = (most - least) / grain;
  const auto step = random.below(static_cast<std::uint32_t>(math::to_integer<std::int32_t>(steps + 0.5)) + 1);
  return static_cast<double>(math::to_integer<std::int64_t>(1e3 * (least + grain * step) + 0.5)) / 1e3;
}

Fault draw_fault(math::Random& random) {
  const Kind& k = kKinds[random.below(kKindCount)];
  Fault f;
  f.device = k.device;
  f.kind = k.kind;
  if (k.grain > 0) f.amount = draw(random, k.least, k.most, k.grain);
  const auto from_ms = math::to_integer<std::int64_t>(1e3 * random.uniform(kFirstOnset_s, kLastOnset_s));
  const double spread = random.uniform();  // more short ones than long ones
  const double length_ms = k.shortest_ms + spread * spread * (k.longest_ms - k.shortest_ms);
  f.from = Time{from_ms * kMsNs};
  f.length = Duration{math::to_integer<std::int64_t>(length_ms) * kMsNs};
  return f;
}

}  // namespace

Case generate(std::uint64_t seed, const std::vector<std::string>& modules) {
  math::Random random(seed, kCaseStream);
  Case c;
  c.world = random.next_u32();
  c.jitter = random.next_u32();
  c.gust_mps = draw(random, 0, 2, 0.1);
  if (!modules.empty() && random.below(8) == 0) {
    const std::string& module = modules[random.below(static_cast<std::uint32_t>(modules.size()))];
    c.stress.push_back({module, draw(random, 6, kHeaviestStress, 2)});
  } else if (!modules.empty() && random.below(2)) {
    for (std::uint32_t n = 1 + random.below(3); n > 0; --n) {
      const std::string& module = modules[random.below(static_cast<std::uint32_t>(modules.size()))];
      const double factor = draw(random, 1.5, kMostStress, 0.5);
      if (c.stress_of(module) == 1.0) c.stress.push_back({module, factor});
    }
  }
  if (random.below(3) > 0)
    for (std::uint32_t n = 1 + random.below(kMostFaults); n > 0; --n) c.faults.push_back(draw_fault(random));
  return c;
}

std::uint64_t case_seed(std::uint64_t search_seed, std::uint64_t run) {
  return math::Random(search_seed, kRunStream, run).next_u64();
}

}  // namespace sinew::search
