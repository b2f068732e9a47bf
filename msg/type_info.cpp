// The descriptions of all messages, checked wherever the room is built.
#include "msg/actuators.hpp"
#include "msg/flight.hpp"
#include "msg/gait.hpp"
#include "msg/image.hpp"
#include "msg/operator.hpp"
#include "msg/referee.hpp"
#include "msg/safety.hpp"
#include "msg/sensors.hpp"

#include <bit>

namespace sinew::msg {

static_assert(std::endian::native == std::endian::little,
              "slots, hashes and recordings hold messages as they are in memory, and all of these are little-endian");

static_assert(alignof(std::int64_t) == 8 && alignof(double) == 8, "32-bit x86 would lay them out otherwise");

static_assert(check_layout<ImuSample>() && check_layout<RangeSample>() && check_layout<BaroSample>());
static_assert(check_layout<BatterySample>() && check_layout<SolePressure>());
static_assert(check_layout<Image>() && sizeof(Image) == 40);
static_assert(check_layout<ActuatorCommand>() && check_layout<GuardianState>() && check_layout<SafetyState>());
static_assert(check_layout<NavState>() && check_layout<FlightSetpoint>() && check_layout<AttitudeSetpoint>());
static_assert(check_layout<OperatorLink>() && check_layout<RefereeState>());
static_assert(check_layout<WrenchSetpoint>() && check_layout<PadSighting>() && check_layout<MotionField>());
static_assert(check_layout<MissionState>() && check_layout<GaitState>());

namespace detail {
namespace {

void add_runs(std::span<const FieldInfo> fields, std::uint32_t base, FloatRun* out, std::size_t& n) {
  for (const FieldInfo& f : fields) {
    if (f.kind == Kind::nested) {
      for (std::uint32_t i = 0; i < f.count; ++i)
        add_runs(f.nested->fields, base + f.offset + i * f.nested->size, out, n);
    } else if (f.kind == Kind::f32 || f.kind == Kind::f64) {
      const bool wide = f.kind == Kind::f64;
      const std::uint32_t offset = base + f.offset;
      const bool continues =
          n > 0 && out[n - 1].is_f64 == wide && out[n - 1].offset + out[n - 1].count * (wide ? 8 : 4) == offset;
      if (continues)
        out[n - 1].count += f.count;
      else
        out[n++] = {offset, f.count, wide};
    }
  }
}

}  // namespace

std::size_t find_float_runs(std::span<const FieldInfo> fields, FloatRun* out) {
  std::size_t n = 0;
  add_runs(fields, 0, out, n);
  return n;
}

}  // namespace detail

}  // namespace sinew::msg
