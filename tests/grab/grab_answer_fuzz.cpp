// An answer that another program wrote into the shared memory, and windows of it: whatever it says, a picture that
// passes the check is read within its bytes.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "hal/linux/grab/grab_pixels.hpp"
#include "hal/linux/grab/grab_view.hpp"
#include "msg/image_buffer.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sinew;
  grab::Answer answer{};
  hal::GrabRegion region;
  if (size < sizeof answer + sizeof region) return 0;
  std::memcpy(&answer, data, sizeof answer);
  std::memcpy(&region, data + sizeof answer, sizeof region);
  auto* head = new grab::Head{};
  std::memcpy(static_cast<void*>(&head->window), data, std::min(size, sizeof head->window));
  std::memcpy(static_cast<void*>(&head->title), data, std::min(size, sizeof head->title));
  for (std::uint32_t i = 0; i < grab::kMaxWindows; ++i) {  // titles that count
    head->title[i].process.store(head->window[i].process.load());
    head->title[i].x11.store(head->window[i].x11);
  }
  for (const hal::GrabWindow& w : hal::windows_of(*head))
    if (hal::clean_title(w.title) != w.title) std::abort();
  static_cast<void>(hal::window_titled(*head, "a"));
  delete head;
  hal::GrabPicture picture = hal::checked_picture(answer, 0);
  const std::size_t bytes = std::size_t{picture.stride} * picture.height;
  if (picture.status != grab::AnswerStatus::ok || bytes > (1u << 22)) return 0;
  // A camera's keys keep its region within these.
  constexpr std::int32_t kSide = grab::kMaxSide;
  region.x %= kSide + 1, region.y %= kSide + 1, region.width %= kSide + 1, region.height %= kSide + 1;
  const std::vector<std::uint8_t> pixels(bytes, 0x5A);
  picture.pixels = pixels.data();
  static hal::GrabPixels converter;
  for (const auto format : {msg::PixelFormat::yuyv, msg::PixelFormat::bgr8}) {
    msg::ImageBuffer image(format, 33, 21);
    converter.convert(picture, region, *image);
  }
  return 0;
}
