#pragma once
#include <cstdint>
#include <string>

#include "hal/result.hpp"
#include "msg/image.hpp"

namespace sinew::hal {

/// A camera that fills memory which its reader lends it, so that nothing copies pixels on their way from the device to
/// whoever reads them. A camera that may be able to implements this beside hal::Camera: ask with dynamic_cast.
///
///   const auto images = memory->begin_lending(room, why);   // once, before the start
///   memory->lend(image);                                    // so many of them; each is the camera's from now on
///   const auto filled = memory->take_filled();              // and the reader's again, in the order of exposure
///
/// Thread:  owner (the reader's), but for what says "any".
/// Owner:   a lent image belongs to whoever lent it, and neither it nor its pixels may be touched until take_filled()
///          or take_back() has answered it. An image that the camera lost track of does not exist: while a device is
///          gone the camera keeps what it was lent, and goes on with it when the device is back.
class CameraMemory {
 public:
  virtual ~CameraMemory() = default;
  /// From now on pictures go into what is lent, and read() gives none. Answers how many images the camera works on at a
  /// time. `room_bytes`: for pixels, in each of them. Before the start; not RT.
  /// Errors:  bad_argument: it was told to lend or do nothing, and cannot; anything else: it cannot, and goes on with
  ///          read(). `why` has it in words.
  virtual Result<std::uint32_t> begin_lending(std::uint32_t room_bytes, std::string& why) = 0;
  /// RT: yes; the first time for each image the kernel pins its memory, which takes it some 100 us.
  /// Errors:  busy: not now, try again in a later cycle; bad_argument: too many, or no room; not_supported: the driver
  ///          refuses such memory, read() gives pictures again from now on. The image stays the caller's.
  virtual Status lend(msg::Image& image) noexcept = 0;
  /// The oldest image that is filled, described as read() does it; null: none is ready. RT: yes.
  /// Errors:  closed, bad_data: as read(); not_supported: read() gives the pictures, and what is lent has to be taken
  /// back.
  virtual Result<msg::Image*> take_filled() noexcept = 0;
  /// Ends the stream, and answers one image after the other that was lent. Null: there is none, or the device has not
  /// let go yet. The next lend() begins it anew. RT: yes.
  virtual msg::Image* take_back() noexcept = 0;
  /// Waits until the device has let go; take_back() then answers all. Not RT.
  virtual void stop_lending() noexcept = 0;
  /// "the driver fills the topic's slots", or why pixels are copied, for people. Thread: any.
  virtual std::string path_of_pixels() const = 0;
};

}  // namespace sinew::hal
