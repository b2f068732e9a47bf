// For any text: problems in words, or a link that the driver reads, with problems in words again.
#include "drivers/text/alturi_ini.hpp"

#include "drivers/text/text_spec.hpp"

using namespace sinew;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  drivers::DeviceSpec link;
  link.driver = "text";
  std::vector<rt::Problem> problems;
  drivers::read_alturi_ini({reinterpret_cast<const char*>(data), size}, link, problems);
  drivers::DeviceKeys keys(link, "device.d", problems);
  const drivers::TextLinkSpec spec = drivers::read_text_link(keys);
  keys.finish();
  for (const auto& drive : spec.drives)
    if (drive.range.max >= drive.range.min && !(drive.range.fitted(1e300) <= drive.range.max)) __builtin_trap();
  return 0;
}
