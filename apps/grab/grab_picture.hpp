#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/linux/grab/grab_view.hpp"

namespace sinew::app {

/// `sinew grab --to`.
struct PictureOptions {
  std::string file;
  double after_s = 0;  // after the first picture
  int window = -1;
  std::string title;
  std::string region;  // "X,Y,WIDTH,HEIGHT"; empty: the whole window
};

/// Takes one picture of a session into a file: poll() again and again. Opening the session waits for its answer, so a
/// session in this process cannot be meant.
class PictureTaker {
 public:
  PictureTaker(std::string session, const PictureOptions& options);
  /// The exit code, once it is over; what went wrong was printed.
  std::optional<int> poll();

 private:
  std::optional<int> opened();
  std::optional<int> untitled();
  int written(const hal::GrabPicture& picture) const;
  std::string session_;
  PictureOptions options_;
  hal::GrabRegion region_;
  bool region_is_good_ = true;
  std::unique_ptr<hal::GrabView> view_;
  std::optional<hal::Time> due_;
  std::optional<hal::Time> windows_since_;  // while none of them has the title
};

/// Four numbers with commas between. False: it is none.
bool read_region(const std::string& text, hal::GrabRegion& region);

}  // namespace sinew::app
