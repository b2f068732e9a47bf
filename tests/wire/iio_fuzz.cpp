// For any texts about channels: a layout without overlaps, and no read outside of the scan.
#include <cstdlib>
#include <string_view>
#include <vector>

#include "wire/iio.hpp"

using namespace sinew::wire;

/// Lines of forms up to an empty one; the rest is a scan.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view text(reinterpret_cast<const char*>(data), size);
  IioLayout layout;
  std::uint32_t index = 0;
  for (std::size_t end; (end = text.find('\n')) != std::string_view::npos && end > 0; text.remove_prefix(end + 1)) {
    const std::string_view line = text.substr(0, end);
    parse_iio_number(line);
    parse_iio_mount_matrix(line);
    if (const auto form = parse_iio_form(line)) layout.add(index++, *form);
  }
  std::size_t at = 0;
  for (const IioChannel& c : layout.channels()) {
    if (c.offset < at || c.offset + c.form.bytes() > layout.scan_bytes() || c.offset % c.form.bytes() != 0)
      std::abort();
    at = c.offset + c.form.bytes();
  }
  const std::vector<std::uint8_t> scan(text.begin(), text.end());  // exactly as long as it is: one byte more is seen
  for (const IioChannel& c : layout.channels())
    for (std::size_t i = 0; i < c.form.repeat; ++i) {
      const std::int64_t value = iio_raw(scan, c, i);
      if (i > 0 || c.offset + c.form.bytes() > scan.size()) continue;
      std::vector<std::uint8_t> again(scan.size());
      put_iio_raw(again, c, value);
      if (iio_raw(again, c) != value) std::abort();
    }
  return 0;
}
