#pragma once
#include <memory>
#include <string_view>

#include "grab/grab_memory.hpp"

namespace sinew::hal {

/// Writes the title of a window into the shared memory, where readers find it. `process` and `x11` say of which window
/// it is. False: it was there already. For GrabTitles, and tests.
bool write_grab_title(grab::Head& head, std::uint32_t window, std::uint32_t process, std::uint32_t x11,
                      std::string_view text);

/// Keeps the titles of a session's windows: asks the X server of $DISPLAY for them, four times a second while there are
/// windows, from a thread of its own, since a display server may not answer. Without libxcb.so.1 or without a display
/// there are no titles. Thread: owner.
class GrabTitles {
 public:
  explicit GrabTitles(grab::Head& head);
  /// From then on the memory is not touched.
  ~GrabTitles();
  GrabTitles(const GrabTitles&) = delete;
  GrabTitles& operator=(const GrabTitles&) = delete;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
};

}  // namespace sinew::hal
