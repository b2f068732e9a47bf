// refused: the description of this message misses a field, lists one twice, or the struct has padding
#include "msg/describe.hpp"

namespace sinew::msg {

struct Probe {
  Time stamp;
  double range_m = 0;
  float level = 0;
};

template <>
struct Description<Probe> {
  static constexpr std::string_view name = "Probe", doc = "A message of this test.";
  static constexpr auto fields =
      describe(field<&Probe::stamp>("ns"), field<&Probe::range_m>("m"), field<&Probe::level>("1"));
};

const TypeInfo& probe() { return type_info<Probe>(); }

}  // namespace sinew::msg
